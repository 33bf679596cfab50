"""Completion: the script of each shell, and what is proposed for a line that is begun."""

import os
import subprocess
import sys

import pytest

from cpm_core import cli


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_each_shell_has_a_script(shell, capsys):
    assert cli.main(["completion", shell]) == 0
    assert "_ARGCOMPLETE" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "proposed"),
    [
        ("cpm ru", {"run"}),
        ("cpm run --sav", {"--save-session"}),
        ("cpm run --auto gr", {"grid", "gradient"}),
        ("cpm completion po", {"powershell"}),
        ("cpm run cel", {"cell.png"}),
    ],
)
def test_commands_options_values_and_files_are_proposed(line, proposed, tmp_path):
    (tmp_path / "cell.png").touch()
    asked = {
        "_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE_SHELL": "bash",
        "_ARGCOMPLETE_IFS": "\n", "_ARGCOMPLETE_STDOUT_FILENAME": str(tmp_path / "found"), "COMP_TYPE": "9",
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }  # fmt: skip
    subprocess.run([sys.executable, "-m", "app"], env=os.environ | asked, cwd=tmp_path, check=True, timeout=60)
    found = (tmp_path / "found").read_text("utf-8").split("\n")
    assert {word.strip() for word in found} == proposed
