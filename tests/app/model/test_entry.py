"""`cpm` opens the window or calls the command line, and explains in one sentence when it cannot."""

from __future__ import annotations

import subprocess
import sys

import pytest
from cpm_app import __main__ as entry

from cpm_core import cli


@pytest.mark.parametrize("arguments", [["run", "image.png"], ["info", "image.png"], ["--help"]])
def test_a_subcommand_or_an_option_goes_to_the_command_line(arguments, monkeypatch) -> None:
    seen = []
    monkeypatch.setattr(cli, "main", lambda argv: seen.append(list(argv)) or 7)
    assert entry.main(arguments) == 7
    assert seen == [arguments]


def test_the_command_line_runs_without_importing_qt() -> None:
    code = (
        "import sys; from cpm_app.__main__ import main; status = main(['info', 'nowhere.png']);"
        "assert not [name for name in sys.modules if name.startswith(('PySide6', 'pyqtgraph'))]; sys.exit(status)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert "nowhere.png" in done.stderr


def test_more_than_one_image_is_refused_in_a_sentence(capsys, tmp_path) -> None:
    images = [tmp_path / "a.png", tmp_path / "b.png"]
    for image in images:
        image.touch()
    assert entry.main([str(image) for image in images]) == 2
    assert "one image" in capsys.readouterr().err


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
@pytest.mark.parametrize("display", [None])
def test_without_a_display_there_is_one_sentence_and_no_crash(monkeypatch, capsys, display) -> None:
    for name in ("QT_QPA_PLATFORM", "WAYLAND_DISPLAY", "DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    if display:
        monkeypatch.setenv("DISPLAY", display)
    assert entry.main([]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "cpm run" in said or "missing" in said
