"""The part that a session shows of its file, of other files: ``cpm batch`` and ``cpm run IMAGE --session``."""

import csv

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.shapes import Circle

from .drawn import SHAPE, page

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
    with (folder / f"{name}_contours.measures.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    column = next(name for name in rows[0] if name.startswith("net_area_") and not name.endswith("px2"))
    return [float(row[column]) for row in rows]


def test_a_batch_takes_the_part_that_the_session_shows_of_each_file(command, session, tmp_path):
    write(tmp_path / "other.ome.tif")
    PIL.Image.fromarray(RIGHT.astype(np.uint8)).save(tmp_path / "plain.png")
    status, _, _ = command("batch", tmp_path / "other.ome.tif", tmp_path / "plain.png", "--session", session,
                             "--output", tmp_path / "out", "--export", "measures.csv", "--workers", 1)  # fmt: skip
    assert status == 0
    for name in ("other.ome", "plain"):
        assert areas(tmp_path / "out", name) == pytest.approx([np.pi * 49], rel=0.05)


def test_a_file_that_lacks_the_part_is_reported(command, session, tmp_path):
    one = np.array([[LEFT, LEFT, RIGHT]]).astype(np.uint8)
    tifffile.imwrite(tmp_path / "own.ome.tif", one, metadata={"axes": "TCYX"}, photometric="minisblack", ome=True)
    image = ImageFile(str(tmp_path / "own.ome.tif"), "", SHAPE, reading=Reading(channel=3))
    save_session(SessionFile(image, (INSIDE,)), tmp_path / "third.cpm")
    write(tmp_path / "other.ome.tif")
    status, _, err = command("batch", tmp_path / "other.ome.tif", "--session", tmp_path / "third.cpm",
                             "--output", tmp_path / "out", "--workers", 1)  # fmt: skip
    assert status == 1
    assert "channel is 3" in err


def test_a_run_on_another_file_takes_the_part_as_well_and_flags_take_its_place(command, session, tmp_path):
    write(tmp_path / "other.ome.tif", at=(0, 1))
    _, at_two, _ = command("run", tmp_path / "other.ome.tif", "--session", session, "--json")
    _, at_one, _ = command("run", tmp_path / "other.ome.tif", "--session", session, "--time", 1, "--json")
    assert at_two != at_one
    flags = ("--channel", 2, "--time", 1, "--pixel-size", "0.5um", "--circle", "32,66,5")
    command("run", tmp_path / "other.ome.tif", *flags, "--export", tmp_path / "a.csv")
    command("run", tmp_path / "other.ome.tif", "--session", session, "--time", 1, "--export", tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
