"""What the command line says: no terminal, pipe or full disk makes work that is done a failure."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import PIL.Image
import pytest

import cpm_core
import cpm_core.cli
from app import __main__ as program
from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.shapes import Circle

ROOT = Path(__file__).parents[3]
posix = pytest.mark.skipif(sys.platform == "win32", reason="pipes, devices and signals are those of POSIX")


@pytest.fixture
def disk(tmp_path):
    row, col = np.mgrid[:40, :40]
    PIL.Image.fromarray((220 * (np.hypot(row - 20, col - 20) < 12)).astype(np.uint8)).save(tmp_path / "disk.png")
    return tmp_path / "disk.png"


def cpm(*arguments, **settings):
    """The real command."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **settings.pop("environment", {})}
    settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **settings}
    command = [sys.executable, "-m", "app", *map(str, arguments)]
    return subprocess.run(command, env=environment, check=False, **settings)


NAME = "größe µm² 輪 é"


@pytest.mark.parametrize("encoding", ["cp932", "gbk", "cp1251", "ascii"])
def test_a_terminal_that_lacks_a_character_is_no_failure(disk, encoding, tmp_path, monkeypatch):
    image = disk.rename(tmp_path / f"{NAME}.png")

    def said(path):
        """Status, output and error output of the command on a terminal of this encoding."""
        written = {stream: io.TextIOWrapper(io.BytesIO(), encoding=encoding) for stream in ("stdout", "stderr")}
        with monkeypatch.context() as patch:
            for stream, text in written.items():
                patch.setattr(sys, stream, text)
            status = cpm_core.cli.main(["info", str(path)])
        for text in written.values():
            text.flush()
        return status, *(text.buffer.getvalue() for text in written.values())

    status, output, error = said(image)
    assert (status, error) == (0, b"")
    assert b"40 rows" in output
    status, _, error = said(tmp_path / f"{NAME}.txt")
    assert status == 2
    assert b"does not exist" in error and error.count(b"\n") == 1


def test_the_real_command_fails_on_no_terminal_either(disk, tmp_path):
    done = cpm("info", disk.rename(tmp_path / f"{NAME}.png"), environment={"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"40 rows" in done.stdout


@posix
def test_a_closed_pipe_ends_the_command_without_a_word(disk):
    reading, writing = os.pipe()
    os.close(reading)
    for line, statuses in ((("info", disk), (141,)), (("--version",), (0, 141)), (("run", "--help"), (0, 141))):
        done = cpm(*line, stdout=writing)
        assert done.returncode in statuses  # argparse itself goes on
        assert done.stderr == b""
    os.close(writing)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is always full")
def test_an_output_on_a_full_disk_is_told_in_one_line(disk):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = cpm("info", disk, stdout=full)
        assert (done.returncode, done.stderr) == (2, b"cpm: the output cannot be written: No space left on device.\n")
        # some releases of Python end with 120 when standard error cannot be flushed at the end
        assert cpm("info", "none.png", stderr=full).returncode in (2, 120)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is always full")
@pytest.mark.parametrize("asked", [["--help"], ["run", "--help"], ["--version"]])
def test_help_that_cannot_be_written_is_told_too(asked):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = cpm(*asked, stdout=full)
    assert done.returncode == 2
    assert done.stderr == b"cpm: the output cannot be written: No space left on device.\n"


@posix
@pytest.mark.parametrize("closed", ["0", "1", "2", "012"])
def test_a_run_needs_no_standard_stream_and_its_files_are_whole(disk, tmp_path, closed):
    """What libraries write to the number of a closed stream must not get into a file that has taken it."""
    script = "; ".join(f"os.close({number})" for number in closed)
    made = ["run", str(disk), "--circle", "32,32,24", "--max-steps", "5", "--export", str(tmp_path / "a.svg"), "--json"]
    start = [sys.executable, "-P", "-m", "app", *made]
    begin = f"import os; {script}; os.execv({sys.executable!r}, {start!r})"
    done = subprocess.run([sys.executable, "-c", begin], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert (tmp_path / "a.svg").read_text().endswith("</svg>\n")
    assert (tmp_path / "a.svg").read_text().startswith("<?xml")
    if "1" not in closed:
        assert json.loads(done.stdout)["steps"] == 5


@posix
@pytest.mark.parametrize("makes", ["nothing of it", "another error of it"])
def test_an_interrupt_during_the_start_is_one_line(disk, makes):
    """Whenever it comes after Python itself has started, there is no traceback, whatever a library makes of it."""
    wrong = "ImportError('half loaded')" if makes == "another error of it" else "KeyboardInterrupt"
    program = (
        "import os, signal, sys, threading\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "class Interrupt:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'cpm_core.cli.run.command':\n"
        "            try:\n"
        "                os.kill(os.getpid(), signal.SIGINT)\n"
        "            except KeyboardInterrupt:\n"
        f"                raise {wrong}\n"
        "sys.meta_path.insert(0, Interrupt())\n"
        "from app.__main__ import main\n"
        "sys.exit(main(['info', sys.argv[1]]))\n"
    )
    command = [sys.executable, "-c", program, str(disk)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "cpm: interrupted; nothing was written.\n")


@pytest.mark.parametrize(
    ("place", "files"),
    [
        ("cpm_core.cli.run.command.segment", "nothing was"),
        ("cpm_core.formats.common.atomic.Path.unlink", "2 files were"),
        ("cpm_core.cli.run.command.save", "2 files were"),
        ("cpm_core.cli.run.command._report", "3 files were"),
        ("cpm_core.cli.outcome.Files.status", "3 files were"),
    ],
)
def test_an_interrupt_says_how_many_files_were_written(disk, command, tmp_path, monkeypatch, place, files):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(place, interrupted)
    exports = ("--export", tmp_path / "a.csv", tmp_path / "a.svg", "--save-session", tmp_path / "a.cpm")
    status, _, err = command("run", disk, "--circle", "20,20,8", "--max-steps", 5, *exports)
    assert (status, err) == (130, f"cpm: interrupted; {files} written{' before' if files[0].isdigit() else ''}.\n")
    assert len(list(tmp_path.glob("a.*"))) == (int(files[0]) if files[0].isdigit() else 0)


def test_a_second_interrupt_says_nothing_of_files(capsys, monkeypatch):
    monkeypatch.setattr(cpm_core.cli, "say", Mock(side_effect=KeyboardInterrupt))
    assert program.main(["run"]) == 130
    assert capsys.readouterr().err == "cpm: interrupted.\n"


def test_the_version_is_told(capsys):
    with pytest.raises(SystemExit) as stop:
        cpm_core.cli.main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"cpm {cpm_core.__version__}\n"


@posix
@pytest.mark.parametrize("name", [os.fsdecode(b"caf\xe9.png"), "a\x1b[31m\nb.png", "=1+1.png", "n" * 251 + ".png"])
def test_an_image_of_any_name_goes_through_a_run_and_a_batch(disk, command, tmp_path, name):
    image = disk.rename(tmp_path / name)
    save_session(SessionFile(shapes=(Circle((20.0, 20.0), 8.0),)), tmp_path / "a.cpm")
    files = [tmp_path / f"out{suffix}" for suffix in (".svg", ".csv", ".json", ".labelme.json", ".geojson")]
    status, out, err = command("run", image, "--circle", "20,20,8", "--max-steps", 40, "--export", *files)
    assert status == 0
    batch = ("batch", image, "--session", tmp_path / "a.cpm", "--output", tmp_path / "o", "--workers", 1)
    status, batch_out, batch_err = command(*batch, "--max-steps", 40, "--export", "svg")
    assert status == 0
    said = out + err + batch_out + batch_err
    assert "\x1b" not in said and not any("\ud800" <= letter <= "\udfff" for letter in said)
    table = (tmp_path / "o" / "summary.csv").read_text("utf-8")
    assert "\x1b" not in table and not any(line.startswith("=") for line in table.splitlines())
    status, out, _ = command(*batch, "--max-steps", 40, "--export", "svg", "--json")
    assert (status, json.loads(out)["done"]) == (0, 1)
    assert len(list((tmp_path / "o").glob("*.svg"))) == 1


@pytest.mark.parametrize("side", [8, 16, 24])
def test_a_small_image_is_taken_with_the_scales_that_it_has_room_for(command, tmp_path, side):
    values = np.zeros((side, side), np.uint8)
    values[side // 4 : -(side // 4), side // 4 : -(side // 4)] = 200
    PIL.Image.fromarray(values).save(tmp_path / "a.png")
    status, out, err = command("run", tmp_path / "a.png", "--auto", "grid", "--json", "--max-steps", 40)
    most = 1 if side == 8 else 2
    assert (status, err) == (0, f"cpm: a.png: The image is small: scales is set to {most}.\n")
    assert json.loads(out)["steps"] > 0
    status, _, err = command("run", tmp_path / "a.png", "--auto", "grid", "--scales", 3)
    assert status == 2 and "scales is 3 but must be from 1" in err
    save_session(SessionFile(shapes=(Circle((side / 2, side / 2), 3.0),)), tmp_path / "a.cpm")
    line = ("batch", tmp_path / "a.png", "--session", tmp_path / "a.cpm", "--output", tmp_path / "o")
    status, _, err = command(*line, "--export", "svg", "--workers", 1, "--max-steps", 5)
    assert status == 0 and f"scales is set to {most}" in err
