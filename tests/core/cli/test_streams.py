"""Standard input and output, what is printed, and what a batch would do."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import PIL.Image
import pytest

from cpm_core import cli
from cpm_core.cli import CLI_COMMANDS
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.parameters import PARAMETERS, PRESETS
from cpm_core.shapes import Circle

RUN = ("--circle", "40,50,9", "--max-steps", 40)


@pytest.fixture
def session(disk):
    """Path of a session beside its image."""
    path = disk.with_name("hand.cpm")
    save_session(SessionFile(ImageFile("disk.png"), (Circle((40.0, 50.0), 9.0),), PRESETS["shape"]), path)
    return path


def test_an_image_comes_from_standard_input_and_the_result_goes_to_standard_output(disk, monkeypatch, capfdbinary):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(disk.read_bytes())))
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), write_through=True))
    assert cli.main(["run", "-", *map(str, RUN), "--export", "-.png"]) == 0
    labels = np.asarray(PIL.Image.open(io.BytesIO(sys.stdout.buffer.getvalue())))
    assert (labels.shape, labels[40, 50], labels[5, 5]) == ((80, 100), 1, 0)


def test_a_session_runs_in_place_of_an_image(session, command):
    lines = ([session], ["--session", session], ["--session", session, session.with_name("disk.png")])
    told = [json.loads(command("run", *line, "--json")[1]) for line in lines]
    assert told[0]["closed"] == 1
    assert all({**one, "seconds": 0} == {**told[0], "seconds": 0} for one in told)


def test_quiet_prints_errors_alone(disk, command, tmp_path):
    mask = tmp_path / "a.png"
    assert command("run", disk, *RUN, "--scales", 3, "--quiet", "--export", mask) == (0, "", "")
    assert mask.is_file()
    status, out, err = command("run", disk, "--stroke", "10,10,10,20", "--quiet", "--max-steps", 1, "--export", mask)
    assert (status, out) == (2, "") and "closed" in err
    assert json.loads(command("run", disk, *RUN, "--quiet", "--json")[1])["closed"] == 1


def test_places_may_be_given_as_x_and_y(disk, command, tmp_path):
    drawn = (
        ("--region", "5,5,5,95,75,95,75,5", "--circle", "40,50,9"),
        ("--region", "5,5,95,5,95,75,5,75", "--circle", "50,40,9", "--xy"),
    )
    tables = []
    for number, options in enumerate(drawn):
        assert command("run", disk, *options, "--max-steps", 40, "--export", tmp_path / f"{number}.csv")[0] == 0
        tables.append((tmp_path / f"{number}.csv").read_text().partition("\nrow")[2].splitlines()[-20:])
    assert tables[0] == tables[1]


def test_a_dry_run_of_a_batch_lists_what_it_would_write_and_writes_nothing(session, command, tmp_path):
    disk, output = session.with_name("disk.png"), tmp_path / "found"
    line = ("batch", disk, "--session", session, "--output", output, "--export", "masks", "--workers", 1)
    status, out, err = command(*line, "--dry-run")
    assert (status, err) == (0, "") and f"{disk}: disk_objects.tif\n" in out
    assert not output.exists()
    assert command(*line)[0] == 0
    assert "0 images to do, 1 done before" in command(*line, "--dry-run")[1]
    (plan,) = json.loads(command(*line, "--dry-run", "--again", "--json")[1])["plan"]
    assert plan["overwrites"] == plan["writes"] == [str(output / "disk_objects.tif")]


def test_a_batch_names_its_files_after_an_address(session, command, tmp_path):
    fsspec = pytest.importorskip("fsspec")
    address, output = "memory://plate/b.png", tmp_path / "found"
    with fsspec.open(address, "wb") as stream:
        stream.write(session.with_name("disk.png").read_bytes())
    line = ("batch", address, "--session", session, "--output", output, "--export", "masks", "--workers", 1)
    assert command(*line)[0] == 0
    assert (output / "b_objects.tif").is_file()
    assert (output / "summary.csv").read_text().splitlines()[1].startswith(f"{address},")
    assert "1 image done before" in command(*line)[2]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only some systems have a device that is always full")
@pytest.mark.parametrize("arguments", [["--help"], ["completion", "bash"], ["info", "disk.png"]])
def test_a_full_output_ends_in_one_line(disk, arguments):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = subprocess.run(
            [sys.executable, "-m", "cpm_app", *arguments],
            stdout=full, stderr=subprocess.PIPE, text=True, cwd=disk.parent, check=False,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (2, "cpm: standard output cannot be written: No space left on device.\n")


@pytest.mark.parametrize("name", CLI_COMMANDS)
def test_help_fits_one_screen_and_all_of_it_is_in_sentences(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    shown = []
    for more in ([], ["all"]):
        with pytest.raises(SystemExit):
            cli.main([name, "--help", *more])
        shown.append(capsys.readouterr().out)
    assert len(shown[0].splitlines()) <= 50
    assert len(shown[0]) <= len(shown[1])
    assert (shown[0] != shown[1]) == ("--help [all]" in shown[0])
    (commands,) = (action for action in cli.build_parser()._actions if action.choices)
    for action in commands.choices[name]._actions:
        assert action.help[0].isupper() and action.help[-1] in ".)", action.help


def test_the_help_names_true_defaults_and_what_auto_means(capsys):
    found = {}
    for name in ("run", "batch", "skeleton"):
        with pytest.raises(SystemExit):
            cli.main([name, "--help", "all"])
        found[name] = " ".join(capsys.readouterr().out.split())
    assert "(0 to 4; default: 0.8)" in found["run"]
    assert "(0 to 20, or auto: derived from the image; default: auto)" in found["skeleton"]
    assert "default: 0.0, in a volume 0.16)" in found["skeleton"]
    assert not any(f"default: {getattr(PRESETS['published'], name)})" in found["batch"] for name in PARAMETERS)
    for suffix in (".ply", ".swc", ".seg.dcm", ".figure.pdf"):
        assert suffix in found["run"] or suffix == ".swc"
