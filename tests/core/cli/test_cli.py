"""Command line: runs without a window, reports bad input in one line, and then writes nothing."""

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core import cli
from cpm_core.cli.run import command as run_command
from cpm_core.formats.common.content import fingerprint
from cpm_core.parameters import DEFAULTS, PARAMETERS, PRESETS, Parameters
from cpm_core.parameters.choices import CHOICES

ROOT = Path(__file__).parents[3]
CENTER, RADIUS = (40.0, 50.0), 18.0


@pytest.fixture
def disk(tmp_path):
    """Path of an image of a bright disk."""
    row, col = np.mgrid[:80, :100]
    distance = np.hypot(row - CENTER[0], col - CENTER[1])
    PIL.Image.fromarray((220 * np.clip(RADIUS + 0.5 - distance, 0, 1)).astype(np.uint8)).save(tmp_path / "disk.png")
    return tmp_path / "disk.png"


START = ("--circle", "40,50,12")


def test_run_finds_the_disk_and_tells_it_as_json(disk, command):
    status, out, err = command("run", disk, *START, "--json")
    facts = json.loads(out)
    assert (status, err) == (0, "")
    head = ["command", "schema", "version"]
    known = [
        *head,
        "particles",
        "contours",
        "closed",
        "steps",
        "converged",
        "stop_reason",
        "seconds",
        "bridges",
        "left_out",
        "not_written",
    ]
    known.append("provenance")
    assert list(facts) == known
    assert (facts["contours"], facts["closed"], facts["converged"]) == (1, 1, True)
    assert facts["particles"] > 20
    assert facts["steps"] > 0
    assert facts["seconds"] > 0
    made = facts["provenance"]
    assert made["shapes"] == [{"shape": "circle", "center": [40.0, 50.0], "radius": 12.0}]
    assert made["image"] == {"name": "disk.png", "sha256": fingerprint(disk)}
    assert (made["method"], made["steps"], made["parameters"]["w1"]) == ("cpm", facts["steps"], 1.6)


def test_run_tells_a_person_what_it_found_and_wrote(disk, command, tmp_path):
    status, out, _ = command("run", disk, *START, "--export", tmp_path / "a.svg")
    assert status == 0
    assert out.startswith("disk.png: 1 contour (1 closed)\n")
    assert f"Wrote {tmp_path / 'a.svg'}\n" in out


def test_run_exports_what_it_found_in_every_format(disk, command, tmp_path):
    paths = [tmp_path / name for name in ("a.svg", "a.csv", "a.png")]
    status, _, _ = command("run", disk, *START, "--export", *paths[:2], "--export", paths[2])
    assert status == 0
    with PIL.Image.open(paths[2]) as picture:
        mask = np.asarray(picture)
    assert mask.shape == (80, 100)
    assert mask.sum() == pytest.approx(np.pi * RADIUS**2, rel=0.02)
    assert all(path.stat().st_size > 100 for path in paths)


@pytest.fixture
def cut(tmp_path):
    """Path of an image of a bright disk that the upper border cuts."""
    row, col = np.mgrid[:60, :100]
    inside = np.hypot(row - 12, col - 50) < RADIUS
    PIL.Image.fromarray((220 * inside).astype(np.uint8)).save(tmp_path / "cut.png")
    return tmp_path / "cut.png", inside


def test_open_contours_that_a_mask_leaves_out_are_told_and_can_be_closed(cut, command, tmp_path):
    image, inside = cut
    start, mask, drawing = ("--circle", "14,50,10"), tmp_path / "m.tif", tmp_path / "m.svg"
    status, _, err = command("run", image, *start, "--export", mask)
    assert status == 2  # no contour is closed
    assert "No contour of cut.png is closed" in err and "Add --close" in err
    status, out, err = command("run", image, *start, "--export", drawing, "--json")
    assert (status, err, json.loads(out)["left_out"]) == (0, "", {str(drawing): 0})
    for close in (("--close",), ("--close", "straight")):
        status, out, err = command("run", image, *start, "--export", mask, "--json", *close)
        facts = json.loads(out)
        assert (status, err, facts["closed"], facts["left_out"]) == (0, "", 1, {str(mask): 0})
        assert facts["bridges"] == 1
        found = tifffile.imread(mask) > 0
        assert 2 * (found & inside).sum() / (found.sum() + inside.sum()) > 0.97


def test_a_mask_that_would_be_empty_does_not_lose_the_other_files(cut, command, tmp_path):
    image, _ = cut
    mask, drawing, table = tmp_path / "m.png", tmp_path / "m.svg", tmp_path / "m.csv"
    run = ("run", image, "--circle", "14,50,10", "--export", drawing, mask, table)
    status, out, err = command(*run)
    assert status == 1
    assert err.startswith(
        f"cpm: {drawing} and {table} were written, but {mask} was not written: No contour of cut.png "
    )
    assert err.endswith("Add --close to close those whose ends are near each other.\n")
    assert err.count("\n") == 1
    assert drawing.exists() and table.exists() and not mask.exists()
    assert "m.svg" in out and "m.png" not in out
    facts = json.loads(command(*run, "--json")[1])
    assert facts["left_out"] == {str(drawing): 0, str(table): 0}
    assert list(facts["not_written"]) == [str(mask)] and facts["not_written"][str(mask)] in err


def test_files_that_cannot_be_written_do_not_lose_the_session_of_a_run(cut, command, tmp_path):
    image, _ = cut
    mask, other, session = tmp_path / "m.png", tmp_path / "m.tif", tmp_path / "m.cpm"
    run = ("run", image, "--circle", "14,50,10", "--export", mask, other)
    status, out, err = command(*run, "--save-session", session)
    assert status == 1
    assert err.startswith(
        f"cpm: {session} was written, but {mask} and {other} were not written: No contour of cut.png "
    )
    assert out.splitlines()[-1] == f"Wrote {session}"
    session.unlink()
    assert command(*run)[0] == 2
    assert not any(path.exists() for path in (mask, other))


def test_a_mask_with_some_contours_tells_how_many_open_ones_it_lacks(tmp_path, command):
    row, col = np.mgrid[:60, :140]
    values = (np.hypot(row - 12, col - 40) < RADIUS) | (np.hypot(row - 30, col - 100) < RADIUS)
    PIL.Image.fromarray((220 * values).astype(np.uint8)).save(tmp_path / "two.png")
    starts = ("--circle", "14,40,10", "--circle", "30,100,10")
    status, out, err = command("run", tmp_path / "two.png", *starts, "--export", tmp_path / "m.png", "--json")
    facts = json.loads(out)
    assert (status, facts["closed"], facts["left_out"]) == (0, 1, {str(tmp_path / "m.png"): facts["contours"] - 1})
    assert f"m.png: {facts['contours'] - 1} of {facts['contours']} contours is open and not in a mask." in err
    assert err.count("\n") == 1


def test_the_size_of_a_pixel_goes_from_the_image_into_the_table(tmp_path, command):
    row, col = np.mgrid[:80, :100]
    values = (200 * (np.hypot(row - 40, col - 50) < RADIUS)).astype(np.uint8)
    tifffile.imwrite(tmp_path / "a.tif", values, imagej=True, resolution=(4, 2), metadata={"unit": "um"})
    assert "0.5 x 0.25 µm" in command("info", tmp_path / "a.tif")[1]
    assert command("run", tmp_path / "a.tif", *START, "--export", tmp_path / "a.csv")[0] == 0
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert ",row,col,x_um,y_um,contrast,program," in lines[0]
    rows, columns, across, down = np.array([line.split(",")[5:9] for line in lines[1:]], dtype=float).T
    assert np.allclose(across, 0.25 * columns, atol=1e-4)
    assert np.allclose(down, 0.5 * rows, atol=1e-4)


def test_run_starts_from_points_and_by_itself_too(disk, command, tmp_path):
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    points = np.stack([40 + 12 * np.sin(angle), 50 + 12 * np.cos(angle)], axis=1)
    np.savetxt(tmp_path / "p.csv", points, delimiter=",", header="row,col", comments="")
    for start in (
        ("--points", tmp_path / "p.csv"),
        ("--stroke", "30,40,50,60"),
        ("--stroke", "40,50", "--stroke", "20, 50, 20.5, 52, 25, 55"),
        ("--auto", "grid"),
        ("--auto", "gradient"),
        ("--auto", "centers"),
    ):
        status, out, err = command("run", disk, *start, "--json")
        assert (status, err) == (0, "")
        assert json.loads(out)["closed"] == 1


def test_regions_and_barriers_tell_where_particles_may_be(disk, command, tmp_path):
    polygon, barrier = "10,10,10,90,40,90,40,10", "20.5,-1,20.5,120"
    _, out, _ = command("run", disk, *START, "--region", polygon, "--export", tmp_path / "half.csv", "--json")
    assert (json.loads(out)["contours"], json.loads(out)["closed"]) == (1, 0)
    rows = np.genfromtxt(tmp_path / "half.csv", delimiter=",", skip_header=1)[:, 5]
    assert 21.0 < rows.min() < 23.0
    assert 37.0 < rows.max() <= 40.0
    _, out, _ = command("run", disk, *START, "--barrier", barrier, "--json")
    assert json.loads(out)["closed"] == 1
    status, _, err = command("run", disk, *START, "--region", "0,0,0,99,26,99,26,0")
    assert status == 2
    assert "none of the 38 starting particles lies inside the regions of interest" in err


def test_bridges_are_told(tmp_path, command):
    """A level edge that fades out towards the middle, and comes back: under the floor for 18 px."""
    row, col = np.mgrid[:100, :120]
    fade = np.clip((np.abs(col - 60.0) - 7.0) / 25.0, 0.0, 1.0)
    below = 1.0 / (1.0 + np.exp((50.0 - row) / 0.5))
    PIL.Image.fromarray((128 + 100 * fade * (below - 0.5)).astype(np.uint8)).save(tmp_path / "edge.png")
    run = ("run", tmp_path / "edge.png", "--auto", "grid", "--scales", 1)
    assert json.loads(command(*run, "--json")[1])["bridges"] == 0
    assert "Bridged" not in command(*run)[1]
    assert json.loads(command(*run, "--max-gap", 40, "--json")[1])["bridges"] == 1
    reported = re.search(r"\nBridged 1 gap, longest ([\d.]+) px\n", command(*run, "--max-gap", 40)[1])
    assert reported
    assert float(reported[1]) == pytest.approx(18.0, abs=2.5)


def test_run_stops_after_the_steps_it_may_take(disk, command):
    _, out, _ = command("run", disk, *START, "--max-steps", 3, "--json")
    facts = json.loads(out)
    assert (facts["steps"], facts["converged"]) == (3, False)


@pytest.fixture
def parameters_of(monkeypatch, disk, command):
    """Function that gives the parameters of a command line."""

    def parameters(*arguments):
        seen = []

        def segment(_image, _seeds, parameters, **_rest):
            seen.append(parameters)
            raise ValueError("enough seen.")

        monkeypatch.setattr(run_command, "segment", segment)
        command("run", disk, *START, *arguments)
        return seen[0]

    return parameters


@pytest.mark.parametrize("name", PARAMETERS)
def test_each_parameter_has_a_flag_of_its_name(parameters_of, name):
    info = PARAMETERS[name]
    value = {"scales": 2, "w1": 0.5, "w2": 2.5}.get(name, (info.slider_low + info.slider_high) / 2)
    assert parameters_of(f"--{name.replace('_', '-')}", value) == Parameters(**{name: value})


def test_smoothing_and_gamma_can_be_left_to_the_image(parameters_of):
    assert parameters_of("--smoothing", "auto").smoothing == "auto"
    assert parameters_of("--gamma", "auto").gamma == "auto"


def test_a_choice_has_a_flag_that_takes_its_names(parameters_of, disk, command):
    assert parameters_of("--edges", "vessels") == Parameters(edges="vessels")
    status, _, err = command("run", disk, *START, "--edges", "veins")
    assert status == 2
    assert 'edges is "veins" but must be "gradient" or "vessels".' in err


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_sets_all_that_no_flag_does(parameters_of, name):
    assert parameters_of("--preset", name) == PRESETS[name]
    assert parameters_of("--preset", name, "--beta", "1.5").beta == 1.5


BAD = [
    ("", "COMMAND"),
    ("fly disk.png", "fly"),
    ("run", "IMAGE"),
    ("run disk.png", "No start"),
    ("run disk.png --stroke 40,50,12", '--stroke is "40,50,12" but must be rows and columns in turn'),
    ("run disk.png --stroke 40,fifty", '--stroke is "40,fifty" but must be rows and columns in turn'),
    ("run disk.png --stroke 40,nan", "not finite"),
    ("run disk.png --auto middle", "--auto"),
    ("run disk.png --circle 40,50,12 --colour red", "--colour"),
    ("run disk.png --circle 40,50,12 --beta", "--beta"),
    ("run disk.png --circle 40,50,12 --export out.svg --beta much", 'beta is "much"'),
    ("run disk.png --circle 40,50,12 --export out.svg --beta nan", "beta is nan"),
    ("run disk.png --circle 40,50,12 --export out.svg --beta 9", "from 0 to 4"),
    ("run disk.png --circle 40,50,12 --export out.svg --w1 3", "above w1"),
    ("run disk.png --circle 40,50,12 --export out.svg --scales 1.5", "whole number"),
    ("run disk.png --circle 40,50,12 --export out.svg --preset best", "best"),
    ("run disk.png --circle 40,50,12 --export out.svg --max-steps 0", "--max-steps is 0"),
    ("run disk.png --circle 40,50,12 --export out.svg --max-steps 2.5", "--max-steps is 2.5"),
    ("run disk.png --export out.svg --circle 1,2", '"1,2"'),
    ("run disk.png --export out.svg --circle a,b,c", '"a,b,c"'),
    ("run disk.png --export out.svg --circle 1,2,3,4", '"1,2,3,4"'),
    ("run disk.png --export out.svg --circle 1,2,nan", "nan"),
    ("run disk.png --export out.svg --circle 40,50,-3", "-3"),
    ("run disk.png --export out.svg --circle 900,900,10", "inside"),
    ("run disk.png --export out.svg --points none.csv", "none.csv"),
    ("run disk.png --export out.svg --auto magic", "magic"),
    ("run none.png --export out.svg --circle 40,50,12", "does not exist"),
    ("run . --export out.svg --circle 40,50,12", "is a folder"),
    ("run text.png --export out.svg --circle 40,50,12", "of an unknown kind"),
    ("run dot.png --export out.svg --circle 40,50,12", "1 x 1 px"),
    ("run flat.png --export out.svg --circle 20,20,9", "constant"),
    ("run nan.npy --export out.svg --circle 40,50,12", "NaN"),
    ("run disk.png --circle 40,50,12 --export out.xyz", "out.xyz"),
    ("run disk.png --circle 40,50,12 --export none/out.svg", "no folder"),
    ("run disk.png --circle 40,50,12 --export out.svg disk.png", "overwrite the image"),
    ("run disk.png --circle 40,50,12 --export out.svg --region 1,1,9,9", "--region"),
    ("run disk.png --circle 40,50,12 --export out.svg --region 1,1,9,9,1", "--region"),
    ("run disk.png --circle 40,50,12 --export out.svg --region 1,1,9,9,a,b", "--region"),
    ("run disk.png --circle 40,50,12 --export out.svg --region 900,900,990,990,900,990", "region of interest 1"),
    ("run disk.png --circle 40,50,12 --export out.svg --region 36,46,36,54,44,54,44,46", "no edges in the regions"),
    ("run disk.png --circle 40,50,12 --export out.svg --barrier 5,5", "--barrier"),
    ("run disk.png --circle 40,50,12 --export out.svg --barrier 5,5,5,5", "2 different points"),
    ("run disk.png --circle 40,50,12 --export out.svg --barrier 5,5,5,nan", "barrier 1"),
    ("info", "IMAGE"),
    ("info none.png", "does not exist"),
    ("info text.png --json", "of an unknown kind"),
]


@pytest.mark.parametrize(("line", "word"), BAD)
def test_bad_input_is_one_line_on_standard_error_and_nothing_is_written(disk, command, monkeypatch, line, word):
    folder = disk.parent
    (folder / "text.png").write_text("no picture", encoding="utf-8")
    PIL.Image.new("L", (1, 1)).save(folder / "dot.png")
    PIL.Image.new("L", (40, 40), 9).save(folder / "flat.png")
    np.save(folder / "nan.npy", np.full((20, 20), np.nan))
    monkeypatch.chdir(folder)
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    status, out, err = command(*line.split())
    assert (status, out) == (2, "")
    assert err.startswith("cpm: ")
    assert err.count("\n") == 1
    assert word in err
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


def test_nothing_is_loaded_before_parameters_and_places_are_known_to_be_good(disk, command, monkeypatch):
    loaded = []
    monkeypatch.setattr(run_command, "load_image", loaded.append)
    for arguments in (("--beta", "9"), ("--export", "a.xyz"), ("--max-steps", "-1")):
        assert command("run", disk, *START, *arguments)[0] == 2
    assert loaded == []


def test_info_tells_size_grey_levels_and_what_reading_changed(tmp_path, command):
    colours = np.zeros((12, 30, 3), dtype=np.uint8)
    colours[..., 1] = np.arange(30) * 8
    PIL.Image.fromarray(colours).save(tmp_path / "a.png")
    status, out, _ = command("info", tmp_path / "a.png")
    assert status == 0
    assert "12 rows x 30 columns" in out
    assert "Color was turned into luminance." in out
    facts = json.loads(command("info", tmp_path / "a.png", "--json")[1])
    assert facts["shape"] == [12, 30]
    assert (facts["minimum"], facts["maximum"]) == pytest.approx((0, 0.7154 * 232))
    assert (facts["spacing"], facts["unit"]) == (None, None)


def test_help_shows_every_parameter_with_its_default(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["run", "--help"])
    assert stop.value.code == 0
    text = " ".join(capsys.readouterr().out.split())
    for info in PARAMETERS.values():
        assert f"--{info.name.replace('_', '-')}" in text
        assert f"(default: {DEFAULTS[info.name]})" in text
    for choice in CHOICES.values():
        assert f"--{choice.name}" in text
        assert all(effect in text for effect in choice.choices.values())


def test_progress_is_shown_on_a_terminal_and_taken_away_again(disk, command, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    status, out, err = command("run", disk, *START)
    assert status == 0
    assert "particles" in err
    assert err.endswith("\r\x1b[2K")
    assert "\x1b" not in out


def test_no_window_library_is_loaded():
    program = (
        "import sys, cpm_core.cli\n"
        "windowed = {'PySide6', 'shiboken6', 'pyqtgraph', 'app'}\n"
        "print(*windowed & {name.split('.')[0] for name in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "\n", "")


@pytest.mark.skipif(sys.platform == "win32", reason="interrupts are those of POSIX")
def test_an_interrupt_ends_the_run_cleanly_and_writes_nothing(disk, tmp_path, interrupts_heeded):
    program = (
        "import sys\n"
        "from cpm_core.cli import main\n"
        "from cpm_core.cli.run import command as run\n"
        "original = run.segment\n"
        "def segment(*args, progress, **rest):\n"
        "    def reported(state):\n"
        "        print('running', flush=True)\n"
        "        import time; time.sleep(0.05)\n"
        "    return original(*args, progress=reported, **rest)\n"
        "run.segment = segment\n"
        "sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", program, "run", str(disk), *START, "--export", str(tmp_path / "out.svg")]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "running\n"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err == "cpm: interrupted; nothing was written.\n"
    assert not (tmp_path / "out.svg").exists()
