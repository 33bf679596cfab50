"""Completion: what each shell proposes, asked of the shells themselves where they are there."""

import shutil
import subprocess

import pytest

from cpm_core import cli


def script(shell, capsys):
    assert cli.main(["completion", shell]) == 0
    return capsys.readouterr().out


def run(shell, program, *arguments):
    found = shutil.which(shell)
    if found is None:
        pytest.skip(f"{shell} is not installed")
    done = subprocess.run([found, *arguments, program], capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split("\n")


CASES = [
    (["cpm", "ru"], {"run"}),
    (["cpm", "run", "--sav"], {"--save-session"}),
    (["cpm", "run", "--auto", "gr"], {"grid", "gradient"}),
    (["cpm", "completion", "po"], {"powershell"}),
]


@pytest.mark.parametrize(("words", "proposed"), CASES)
def test_bash_proposes_commands_options_and_values(words, proposed, capsys, tmp_path):
    listed = " ".join(f'"{word}"' for word in words)
    asked = f"COMP_WORDS=({listed}); COMP_CWORD={len(words) - 1}; _cpm; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    found = run("bash", f'cd "{tmp_path}"\n{script("bash", capsys)}\n{asked}', "-c")
    assert set(filter(None, found)) == proposed


def test_bash_proposes_files_where_any_value_may_follow(capsys, tmp_path):
    (tmp_path / "cell.png").touch()
    asked = "COMP_WORDS=(cpm run c); COMP_CWORD=2; _cpm; printf '%s\\n' \"${COMPREPLY[@]}\""
    assert "cell.png" in run("bash", f'cd "{tmp_path}"\n{script("bash", capsys)}\n{asked}', "-c")


@pytest.mark.parametrize(("words", "proposed"), CASES)
def test_fish_proposes_commands_options_and_values(words, proposed, capsys, tmp_path):
    program = f"{script('fish', capsys)}\ncd {tmp_path}\ncomplete -C '{' '.join(words)}'"
    found = {line.split("\t")[0] for line in run("fish", program, "--no-config", "-c") if line}
    assert found == proposed


def test_zsh_reads_the_script_and_knows_each_command(capsys, tmp_path):
    (tmp_path / "_cpm").write_text(script("zsh", capsys), "utf-8")
    program = (
        "autoload -Uz compinit; compinit -u -D; source _cpm\n"
        "_describe() { print -rl -- ${commands%%:*} }\n"
        "_files() { }\n"
        "_arguments() { print -rl -- ${@%%\\[*} }\n"
        "words=(cpm ru); CURRENT=2; _cpm; words=(cpm run --sav); CURRENT=3; _cpm\n"
    )
    (tmp_path / "ask").write_text(f'cd "{tmp_path}"\n{program}', "utf-8")
    found = run("zsh", str(tmp_path / "ask"), "-f")
    assert {"run", "batch", "completion", "--save-session", "*--save-session"} & set(found) >= {
        "run",
        "*--save-session",
    }


def test_powershell_registers_a_completer_of_balanced_brackets(capsys):
    """It is read by PowerShell itself where that is installed."""
    text = script("powershell", capsys)
    for left, right in ("{}", "()", "[]"):
        assert text.count(left) == text.count(right)
    assert "'run --auto' = @('grid', 'gradient', 'centers')" in text
    if shutil.which("pwsh"):
        asked = f"{text}\n(TabExpansion2 'cpm run --sav' 13).CompletionMatches.CompletionText"
        assert "--save-session" in run("pwsh", asked, "-NoProfile", "-Command")
