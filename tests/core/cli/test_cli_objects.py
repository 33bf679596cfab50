"""Objects on the command line: chosen by places, written closed, told as text and as JSON."""

import csv
import json

import numpy as np
import PIL.Image
import pytest

from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.objects.segmented import DEFAULT_CLASSES, ObjectClass, SegmentedObjects
from cpm_core.parameters import PRESETS
from cpm_core.shapes import Everywhere

CENTER, RADIUS = (40.0, 50.0), 18.0


@pytest.fixture
def disk(tmp_path):
    """Path of an image of a bright disk with a dark hole, and a second disk."""
    row, col = np.mgrid[:80, :140]
    away = np.hypot(row - CENTER[0], col - CENTER[1])
    values = np.clip(RADIUS + 0.5 - away, 0, 1) * np.clip(away - 5.5, 0, 1)
    values += np.clip(12.5 - np.hypot(row - 40.0, col - 110.0), 0, 1)
    PIL.Image.fromarray((220 * values).astype(np.uint8)).save(tmp_path / "disk.png")
    return tmp_path / "disk.png"


def test_an_object_is_told_as_json_and_written_as_a_mask_of_one_label(disk, told, tmp_path):
    mask = tmp_path / "mask.png"
    run = ("run", disk, "--object", "40,62", "--not", "40,50", "--not", "40,110", "--export", mask)
    (found,) = told(*run)["objects"]
    true = np.pi * (RADIUS**2 - 6.0**2)
    assert found["area"] == pytest.approx(true, rel=0.06)
    assert found["perimeter"] == pytest.approx(2.0 * np.pi * (RADIUS + 6.0), rel=0.05)
    assert (found["holes"], found["gaps"], found["bridged"]) == (1, 0, 0.0)
    assert found["confidence"] > 0.85
    with PIL.Image.open(mask) as picture:
        made = json.loads(picture.info["Description"])
    assert made["method"] == "objects" and made["parameters"]["w1"] == 1.6
    assert made["shapes"][-1] == {"shape": "object", "inside": [[40.0, 62.0]], "outside": [[40.0, 50.0], [40.0, 110.0]]}
    pixels = np.asarray(PIL.Image.open(mask))
    assert np.unique(pixels).tolist() == [0, 1]
    assert np.count_nonzero(pixels) == pytest.approx(true, rel=0.06)
    assert pixels[40, 110] == 0


def test_all_objects_are_told_and_written(disk, told, tmp_path):
    mask = tmp_path / "mask.png"
    found = told("run", disk, "--objects", "--export", mask)["objects"]
    areas = [np.pi * 12.0**2, np.pi * (RADIUS**2 - 6.0**2)]
    assert sorted(one["area"] for one in found) == pytest.approx(areas, rel=0.06)
    told_areas, sure = [one["area"] for one in found], [one["confidence"] for one in found]
    assert np.bincount(np.asarray(PIL.Image.open(mask)).ravel())[1:] == pytest.approx(told_areas, rel=0.06)
    assert sure == sorted(sure, reverse=True)


def test_a_person_is_told_of_the_object(disk, command):
    status, out, _ = command("run", disk, "--circle", "40,110,6", "--object", "40,110")
    assert status == 0
    assert "Object: area 4" in out  # of pi 12 ^ 2 = 452
    assert "across gaps, confidence" in out


def test_a_batch_writes_the_objects_of_each_image_in_formats_named_by_name_and_counts_them(
    disk, command, told, tmp_path
):
    two, session, out = tmp_path / "halves.png", tmp_path / "a.cpm", tmp_path / "out"
    halves = np.where(np.arange(80)[:, None] < 40, 100, np.full((80, 140), 150))
    PIL.Image.fromarray(halves.astype(np.uint8)).save(two)
    run = ("run", disk, "--auto", "grid", "--preset", "automatic", "--objects", "--save-session", session)
    assert command(*run, "--export", tmp_path / "run.tif", tmp_path / "run.table.csv")[0] == 0
    batch = ("batch", disk, two, "--session", session, "--output", out, "--workers", 1)
    reported = told(*batch, "--export", "labelme", "csv", "masks", ".png")
    assert [image["objects"] for image in reported["images"]] == [2, 0]
    assert (reported["failed"], reported["lacking_files"]) == (0, 0)
    assert reported["images"][0]["likely"] == sum(one["confidence"] >= 0.7 for one in told(*run)["objects"])
    names = ["disk.json", *(f"disk_objects.{suffix}" for suffix in ("csv", "tif", "png"))]
    assert {path.name for path in out.iterdir()} == {*names, "objects.csv", "summary.csv"}
    assert (out / "disk_objects.tif").read_bytes() == (tmp_path / "run.tif").read_bytes()
    assert (out / "disk_objects.csv").read_bytes() == (tmp_path / "run.table.csv").read_bytes()
    shapes = json.loads((out / "disk.json").read_text())
    assert shapes["imagePath"] == "../disk.png"
    assert {(shape["label"], shape["description"]) for shape in shapes["shapes"]} == {
        ("object", "object 1"), ("object", "object 2")
    }  # fmt: skip
    with (out / "objects.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["image"] for row in rows] == ["disk.png", "disk.png"]
    assert [row["class"] for row in rows] == ["object", "object"]
    assert all(row["color"] and 0.0 < float(row["confidence"]) < 1.0 for row in rows)
    _, said, err = command(*batch, "--export", "labelme", "csv", "masks", ".png")
    assert "2 images done before" in err and "halves.png: 0 objects, 0 likely" in said


def test_the_objects_of_a_batch_are_of_the_class_that_the_session_gives_the_next_one(disk, command, tmp_path):
    session, out = tmp_path / "a.cpm", tmp_path / "out"
    classes = (DEFAULT_CLASSES[0], ObjectClass("nucleus", "#123456"), *DEFAULT_CLASSES[2:])
    objects = SegmentedObjects(classes=classes, category=2)
    save_session(SessionFile(None, (Everywhere("grid"),), PRESETS["automatic"], objects=objects), session)
    batch = ("batch", disk, "--session", session, "--output", out, "--workers", 1, "--export", "csv")
    assert command(*batch)[0] == 0
    with (out / "disk_objects.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {(row["class"], row["color"]) for row in rows} == {("nucleus", "#123456")}
    assert [row["name"] for row in rows] == [f"nucleus {number}" for number in range(1, len(rows) + 1)]
