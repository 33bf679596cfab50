"""Command line: runs without a window, reports bad input in one line, and then writes nothing."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.formats.common.content import compute_fingerprint
from cpm_core.formats.sessions import session_run
from cpm_core.parameters import PARAMETERS, PRESETS, Parameters

ROOT = Path(__file__).parents[3]
START = ("--circle", "40,50,12")


def test_run_finds_the_disk_and_tells_it_as_json(disk, told):
    facts = told("run", disk, *START)
    assert (facts["contours"], facts["closed"], facts["converged"]) == (1, 1, True)
    assert facts["particles"] > 20
    made = facts["provenance"]
    assert made["shapes"] == [{"shape": "circle", "center": [40.0, 50.0], "radius": 12.0}]
    assert made["image"] == {"name": "disk.png", "sha256": compute_fingerprint(disk)}
    assert (made["method"], made["steps"], made["parameters"]["w1"]) == ("cpm", facts["steps"], 1.6)


def test_run_tells_a_person_what_it_found_and_wrote(disk, command, tmp_path):
    status, out, _ = command("run", disk, *START, "--export", tmp_path / "a.svg")
    assert status == 0
    assert out.startswith("disk.png: 1 contour (1 closed), 1 face\n")
    assert f"Wrote {tmp_path / 'a.svg'}\n" in out


def test_a_run_that_ends_without_particles_says_why(disk, command, tmp_path):
    (tmp_path / "corner.csv").write_text("0,0\n0.5,0.2\n")
    method = ("--method", "published", "--time-step", "1")
    status, out, _ = command("run", disk, *method, "--points", tmp_path / "corner.csv")
    assert status == 0
    assert "0 particles, 1 step" in out and "Stopped: all particles left the image" in out


@pytest.fixture
def cut(tmp_path):
    """Path of an image of a bright disk that the upper border cuts."""
    row, col = np.mgrid[:60, :100]
    inside = np.hypot(row - 12, col - 50) < 18.0
    PIL.Image.fromarray((220 * inside).astype(np.uint8)).save(tmp_path / "cut.png")
    return tmp_path / "cut.png", inside


def test_open_contours_that_a_mask_leaves_out_are_told(cut, command, told, tmp_path):
    image, inside = cut
    run, mask = ("run", image, "--circle", "14,50,10", "--export"), tmp_path / "m.tif"
    status, _, err = command(*run, mask)
    assert status == 2  # no contour is closed
    assert "cut.png" in err and "--object ROW,COL" in err
    told(*run, mask, "--object", "14,50")
    found = tifffile.imread(mask) > 0
    assert 2 * (found & inside).sum() / (found.sum() + inside.sum()) > 0.97


def test_a_mask_that_would_be_empty_does_not_lose_the_other_files(cut, command, tmp_path):
    image, _ = cut
    mask, drawing, table = tmp_path / "m.png", tmp_path / "m.svg", tmp_path / "m.csv"
    run = ("run", image, "--circle", "14,50,10", "--export", drawing, mask, table)
    status, out, err = command(*run)
    assert status == 1
    assert err.startswith(f"cpm: {mask} was not written: ")
    assert err.endswith("Name an object by --object ROW,COL, whose boundary is closed.\n")
    assert err.count("\n") == 1
    assert drawing.exists() and table.exists() and not mask.exists()
    assert "m.svg" in out and "m.png" not in out
    facts = json.loads(command(*run, "--json")[1])
    assert facts["left_out"] == {str(drawing): 0, str(table): 0}
    assert list(facts["not_written"]) == [str(mask)] and facts["not_written"][str(mask)] in err


def test_run_starts_from_points_and_by_itself_too(disk, told, tmp_path):
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    points = np.stack([40 + 12 * np.sin(angle), 50 + 12 * np.cos(angle)], axis=1)
    np.savetxt(tmp_path / "p.csv", points, delimiter=",", header="row,col", comments="")
    for start in (
        ("--points", tmp_path / "p.csv"),
        ("--stroke", "40,50", "--stroke", "20, 50, 20.5, 52, 25, 55"),
        ("--auto", "centers"),
    ):
        assert told("run", disk, *start)["closed"] == 1


def test_regions_and_barriers_tell_where_particles_may_be(disk, command, told, tmp_path):
    polygon, barrier = "10,10,10,90,40,90,40,10", "20.5,-1,20.5,120"
    facts = told("run", disk, *START, "--region", polygon, "--export", tmp_path / "half.csv")
    assert (facts["contours"], facts["closed"]) == (1, 0)
    rows = np.genfromtxt(tmp_path / "half.csv", delimiter=",", skip_header=1)[:, 5]
    assert 21.0 < rows.min() < 23.0
    assert 37.0 < rows.max() <= 40.0
    assert told("run", disk, *START, "--barrier", barrier)["closed"] == 1
    status, _, err = command("run", disk, *START, "--region", "0,0,0,99,26,99,26,0")
    assert status == 2
    assert "starting particles lies inside the regions of interest" in err


def test_bridges_are_told(tmp_path, command):
    """A level edge that fades out towards the middle, and comes back: under the floor for 18 px."""
    row, col = np.mgrid[:100, :120]
    fade = np.clip((np.abs(col - 60.0) - 7.0) / 25.0, 0.0, 1.0)
    below = 1.0 / (1.0 + np.exp((50.0 - row) / 0.5))
    PIL.Image.fromarray((128 + 100 * fade * (below - 0.5)).astype(np.uint8)).save(tmp_path / "edge.png")
    run = ("run", tmp_path / "edge.png", "--auto", "grid", "--scales", 1)
    assert "Bridged" not in command(*run)[1]
    reported = re.search(r"\nBridged 1 gap, longest ([\d.]+) px\n", command(*run, "--max-gap", 40)[1])
    assert reported
    assert float(reported[1]) == pytest.approx(18.0, abs=2.5)


@pytest.fixture
def parameters_of(monkeypatch, disk, command):
    """Function that gives the parameters of a command line."""

    def parameters(*arguments):
        seen = []

        def segment(_image, _seeds, parameters, **_rest):
            seen.append(parameters)
            raise ValueError("enough seen.")

        monkeypatch.setattr(session_run, "segment", segment)
        command("run", disk, *START, *arguments)
        return seen[0]

    return parameters


def test_each_parameter_has_a_flag_of_its_name(parameters_of):
    values = {name: (info.slider_low + info.slider_high) / 2 for name, info in PARAMETERS.items()}
    values |= {"scales": 2, "w1": 0.5, "w2": 2.5, "smoothing": "auto", "edges": "vessels"}
    flags = [part for name, value in values.items() for part in (f"--{name.replace('_', '-')}", value)]
    assert parameters_of(*flags) == Parameters(**values)


def test_a_preset_sets_all_that_no_flag_does(parameters_of):
    name = "automatic"
    assert parameters_of("--preset", name) == PRESETS[name]
    assert parameters_of("--preset", name, "--beta", "1.5").beta == 1.5


def test_info_tells_size_grey_levels_and_what_reading_changed(tmp_path, command, told):
    colours = np.zeros((12, 30, 3), dtype=np.uint8)
    colours[..., 1] = np.arange(30) * 8
    PIL.Image.fromarray(colours).save(tmp_path / "a.png")
    _, out, _ = command("info", tmp_path / "a.png")
    assert "12 rows x 30 columns" in out
    assert "luminance" in out
    facts = told("info", tmp_path / "a.png")
    assert facts["shape"] == [12, 30]
    assert (facts["minimum"], facts["maximum"]) == pytest.approx((0, 0.7154 * 232))
    assert (facts["spacing"], facts["unit"]) == (None, None)


def test_progress_is_shown_on_a_terminal_and_taken_away_again(disk, command, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    status, out, err = command("run", disk, *START)
    assert status == 0
    assert "particles" in err
    assert err.endswith("\r\x1b[2K")
    assert "\x1b" not in out


def test_an_interrupt_ends_the_run_cleanly_and_writes_nothing(disk, command, tmp_path, monkeypatch):
    def interrupted(*_, progress, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(session_run, "segment", interrupted)
    status, _, err = command("run", disk, *START, "--export", tmp_path / "out.svg")
    assert (status, err) == (130, "cpm: interrupted.\n")
    assert not (tmp_path / "out.svg").exists()


def test_the_size_of_a_pixel_goes_from_the_image_into_the_table(tmp_path, command):
    row, col = np.mgrid[:80, :100]
    values = (200 * (np.hypot(row - 40, col - 50) < 22.0)).astype(np.uint8)
    tifffile.imwrite(tmp_path / "a.tif", values, imagej=True, resolution=(4, 2), metadata={"unit": "um"})
    assert "0.5 x 0.25 µm" in command("info", tmp_path / "a.tif")[1]
    assert command("run", tmp_path / "a.tif", *START, "--export", tmp_path / "a.csv")[0] == 0
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert ",row,col,x_um,y_um,contrast,program," in lines[0]
    rows, columns, across, down = np.array([line.split(",")[5:9] for line in lines[1:]], dtype=float).T
    assert np.allclose(across, 0.25 * columns, atol=1e-4)
    assert np.allclose(down, 0.5 * rows, atol=1e-4)
