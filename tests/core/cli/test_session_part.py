"""The part that a session shows of its file, of other files too: in ``cpm run``, ``batch`` and ``compare``."""

import csv

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle

from ..pages.drawn import SHAPE, page

NOTHING, LEFT, RIGHT = np.zeros(SHAPE), page((32, 22, 12)), page((32, 66, 14))
INSIDE = Circle((32.0, 66.0), 5.0)


def write(path, *, at=(1, 1)):
    """Two points in time with two channels, of which one, by numbers from 0, has a disk around the start."""
    images = np.array([[RIGHT if (time, channel) == at else LEFT for channel in range(2)] for time in range(2)])
    tifffile.imwrite(path, images.astype(np.uint8), metadata={"axes": "TCYX"}, photometric="minisblack", ome=True)


@pytest.fixture
def session(tmp_path):
    """A session about the second channel at the second time, with a size of a pixel by hand."""
    write(tmp_path / "own.ome.tif")
    image = ImageFile(str(tmp_path / "own.ome.tif"), "", SHAPE,
                      reading=Reading(channel=2, time=2, spacing=(0.5, 0.5), unit="µm"))  # fmt: skip
    save_session(SessionFile(image, (INSIDE,)), tmp_path / "right.cpm")
    return tmp_path / "right.cpm"


def areas(folder, name):
    """Areas of the contours of an image of a batch."""
    with (folder / f"{name}_contours.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    column = next(name for name in rows[0] if name.startswith("net_area_") and not name.endswith("px2"))
    return [float(row[column]) for row in rows]


def test_a_batch_takes_the_part_that_the_session_shows_of_each_file(command, session, tmp_path):
    write(tmp_path / "other.ome.tif")
    PIL.Image.fromarray(RIGHT.astype(np.uint8)).save(tmp_path / "plain.png")
    status, _, _ = command("batch", tmp_path / "other.ome.tif", tmp_path / "plain.png", "--session", session,
                             "--output", tmp_path / "out", "--contours", "--export", "measures.csv",
                             "--workers", 1)  # fmt: skip
    assert status == 0
    for name in ("other.ome", "plain"):
        assert areas(tmp_path / "out", name) == pytest.approx([np.pi * 49], rel=0.05)


def test_a_run_on_another_file_takes_the_part_as_well_and_flags_take_its_place(command, session, tmp_path):
    write(tmp_path / "other.ome.tif", at=(0, 1))
    _, at_two, _ = command("run", tmp_path / "other.ome.tif", "--session", session, "--json")
    _, at_one, _ = command("run", tmp_path / "other.ome.tif", "--session", session, "--time", 1, "--json")
    assert at_two != at_one
    flags = ("--channel", 2, "--time", 1, "--pixel-size", "0.5um", "--circle", "32,66,5")
    command("run", tmp_path / "other.ome.tif", *flags, "--export", tmp_path / "a.csv")
    command("run", tmp_path / "other.ome.tif", "--session", session, "--time", 1, "--export", tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def compared(told, table, *arguments):
    """What a method finds, without its time, and the measures of the contour."""
    (found,) = told("compare", *arguments, "--methods", "geodesic", "--export", table)["methods"]
    with table.open(newline="", encoding="utf-8") as stream:
        measures = [row.get("net_area_um2", row["net_area_px2"]) for row in csv.DictReader(stream)]
    return found | {"seconds": 0.0}, measures


def test_methods_are_compared_on_the_part_that_the_session_shows(told, session, tmp_path):
    write(tmp_path / "other.ome.tif")
    flags = ("--channel", 2, "--time", 2, "--pixel-size", "0.5um", "--circle", "32,66,5")
    table = tmp_path / "found.measures.csv"
    first = compared(told, table, tmp_path / "own.ome.tif", *flags)
    assert float(first[1][0]) == pytest.approx(np.pi * 49, rel=0.1)
    assert compared(told, table, tmp_path / "other.ome.tif", "--session", session) == first


def painted(path, **colors):
    """A file with the gray levels of some channels of color."""
    levels = np.stack([colors.get(name, LEFT) for name in ("red", "green", "blue")], axis=-1)
    PIL.Image.fromarray(levels.astype(np.uint8)).save(path)


@pytest.mark.parametrize(("kept", "name"), [("red", "green"), ("red", "contrast"), ("contrast", "luminance")])
def test_the_channel_of_the_command_line_comes_before_that_of_a_session(command, tmp_path, kept, name):
    painted(tmp_path / "a.png", red=page((32, 22, 14)), green=page((32, 60, 10)), blue=page((32, 64, 12)))
    reading = Reading(color="contrast") if kept == "contrast" else Reading()
    image = ImageFile(str(tmp_path / "a.png"), "", SHAPE, reading=reading)
    parameters = Parameters(channel="luminance" if kept == "contrast" else kept)
    save_session(SessionFile(image, (INSIDE,), parameters=parameters), tmp_path / "kept.cpm")
    found = []
    for given in ((tmp_path / "a.png", "--circle", "32,66,5"), ("--session", tmp_path / "kept.cpm")):
        assert command("run", *given, "--channel", name, "--export", tmp_path / "a.csv")[0] == 0
        found.append((tmp_path / "a.csv").read_text())
    assert found[0] == found[1]
