"""Files that a command line names: none that is read is replaced, and none is named by nothing."""

import numpy as np
import PIL.Image
import pytest

from cpm_core.formats import export, load_image
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.parameters import Parameters
from cpm_core.segmentation.evolve import segment
from cpm_core.shapes import Circle

ROW, COL = np.indices((60, 70))
START = Circle((30.0, 34.0), 12.0)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with an image and its name as a link, and with all that may be named beside it."""
    PIL.Image.fromarray((200 * (np.hypot(ROW - 30, COL - 34) < 18)).astype(np.uint8)).save(tmp_path / "disk.png")
    PIL.Image.fromarray((255 * (np.hypot(ROW - 30, COL - 34) < 20)).astype(np.uint8)).save(tmp_path / "mask.png")
    (tmp_path / "link.png").symlink_to(tmp_path / "disk.png")
    (tmp_path / "points.csv").write_text("row,col\n20,34\n40,34\n30,24\n30,44\n")
    found = segment(load_image(tmp_path / "disk.png"), START.seeds(), Parameters())
    export(found, tmp_path / "found.svg")
    image = ImageFile(str(tmp_path / "disk.png"))
    save_session(SessionFile(image, (START,), parameters=Parameters(scales=1)), tmp_path / "own.cpm")
    monkeypatch.chdir(tmp_path)
    return tmp_path


RUN, COMPARED = "run disk.png --circle 30,34,12", "compare disk.png --circle 30,34,12 --methods gvf --max-steps 2"


@pytest.mark.parametrize(
    "line",
    [
        f"{RUN} --export disk.png",
        f"{RUN} --export ../{{folder}}/disk.png",
        f"{RUN} --export link.png",
        "run link.png --circle 30,34,12 --export disk.png",
        "run --session own.cpm --export disk.png",
        "run disk.png --points points.csv --export points.csv",
        "run disk.png --start found.svg --export a.json found.svg",
        f"{RUN} --truth mask.png --export mask.png",
        f"{COMPARED} --export disk.png",
        f"{COMPARED} --truth mask.png --export mask.png",
        "compare disk.png --start found.svg --methods gvf --max-steps 2 --export found.svg",
        "compare --session own.cpm --methods gvf --max-steps 2 --export disk.png",
        "skeleton disk.png --within mask.png --export mask.png",
        "skeleton disk.png --export disk.png",
        "export found.svg --to found.svg",
        "export found.svg --image disk.png --to disk.png",
        "export own.cpm --to disk.png",
        "export mask.png --to mask.png",
    ],
)
def test_a_file_that_is_read_is_not_replaced(folder, command, line):
    before = {path: path.read_bytes() for path in folder.iterdir()}
    status, out, err = command(*line.format(folder=folder.name).split())
    assert (status, out) == (2, "")
    assert " would overwrite " in err and err.endswith(": choose another name.\n") and err.count("\n") == 1
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_a_batch_replaces_no_image_in_its_folder(folder, command):
    for name in ("disk_contours.png", "disk_contours_2.png"):
        (folder / name).write_bytes((folder / "mask.png").read_bytes())
    images = ["disk.png", "disk_contours.png", folder / "disk_contours_2.png"]
    before = [(folder / image).read_bytes() for image in images]
    line = ("batch", *images, "--session", "own.cpm", "--output", ".", "--export", "png", "--workers", 1)
    assert command(*line)[0] == 0
    assert [(folder / image).read_bytes() for image in images] == before
    made = {"disk_contours_3.png", "disk_contours_contours.png", "disk_contours_2_contours.png"}
    assert made < {path.name for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ((*RUN.split(), "--export", "a.svg", ""), "--export"),
        ((*RUN.split(), "--session", ""), "--session"),
        ((*RUN.split(), "--truth", ""), "--truth"),
        ((*RUN.split(), "--save-session", ""), "--save-session"),
        (("run", "", "--circle", "30,34,12"), "IMAGE"),
        (("info", "disk.png", ""), "IMAGE"),
        (("batch", "disk.png", "--session", "own.cpm", "--output", ""), "--output"),
        (("export", "", "--to", "a.svg"), "FILE"),
        (("export", "found.svg", "--image", "", "--to", "a.svg"), "--image"),
        (("skeleton", "disk.png", "--within", ""), "--within"),
    ],
)
def test_a_name_that_is_empty_is_refused_before_anything_is_written(folder, command, line, what):
    before = sorted(folder.iterdir())
    status, out, err = command(*line)
    assert (status, out, err) == (2, "", f"cpm: {what} is empty: give the name of a file, or leave it out.\n")
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("export found.svg --to a.json --page 0", "--page is 0 but must be a whole number from 1 up"),
        ("export found.svg --to a.json --page one", '--page is "one" but must be a whole number from 1 up'),
        ("export own.cpm --to a.json --page 1", "own.cpm is a session"),
        (f"{RUN} --object 30,70", "--object is 30,70 but lies outside the image, which has 60 x 70 px"),
        (f"{RUN} --object -1,5", "--object is -1,5 but lies outside the image"),
    ],
)
def test_what_names_nothing_is_refused_in_one_sentence(folder, command, line, sentence):
    status, out, err = command(*line.split())
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert sentence in err
    assert not (folder / "a.json").exists()
