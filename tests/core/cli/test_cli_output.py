"""What the command line says: no terminal, pipe or full disk makes work that is done a failure."""

import json
import os
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

import cpm_core
import cpm_core.cli
from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.shapes import Circle

ROOT = Path(__file__).parents[3]
posix = pytest.mark.skipif(sys.platform == "win32", reason="pipes, devices and signals are those of POSIX")


def test_the_version_is_told(capsys):
    with pytest.raises(SystemExit) as stop:
        cpm_core.cli.main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"cpm {cpm_core.__version__}\n"


@posix
@pytest.mark.parametrize("name", [os.fsdecode(b"=1+caf\xe9\x1b[31m\nb.png"), "n" * 251 + ".png"])
def test_an_image_of_any_name_goes_through_a_run_and_a_batch(disk, command, tmp_path, name):
    image = disk.rename(tmp_path / name)
    save_session(SessionFile(shapes=(Circle((40.0, 50.0), 12.0),)), tmp_path / "a.cpm")
    files = [tmp_path / f"out{suffix}" for suffix in (".svg", ".csv", ".json", ".labelme.json", ".geojson")]
    status, out, err = command("run", image, "--circle", "40,50,12", "--max-steps", 40, "--export", *files)
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


def test_a_small_image_is_taken_with_the_scales_that_it_has_room_for(command, tmp_path):
    values = np.zeros((8, 8), np.uint8)
    values[2:-2, 2:-2] = 200
    PIL.Image.fromarray(values).save(tmp_path / "a.png")
    run = ("run", tmp_path / "a.png", "--auto", "grid", "--max-steps", 5)
    assert command(*run)[2] == "cpm: a.png: The image is small: scales is set to 1.\n"
    status, _, err = command(*run, "--scales", 3)
    assert status == 2 and "scales is 3 but must be from 1" in err
    save_session(SessionFile(shapes=(Circle((4.0, 4.0), 3.0),)), tmp_path / "a.cpm")
    line = ("batch", tmp_path / "a.png", "--session", tmp_path / "a.cpm", "--output", tmp_path / "o")
    status, _, err = command(*line, "--export", "svg", "--workers", 1, "--max-steps", 5)
    assert status == 0 and "scales is set to 1" in err
