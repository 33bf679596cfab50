"""Whatever the library finds, and labels of other programs, can be written in every format that can hold it."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import re

import nibabel
import numpy as np
import PIL.Image
import pytest
import tifffile
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.formats import CONTOURS_WRITABLE, VOLUMES_WRITABLE

LABELS = np.zeros((40, 60), np.int64)
LABELS[5:15, 5:20] = 3
LABELS[8:11, 8:11] = 0
LABELS[20:35, 30:50] = 70
LABELS[30:35, 5:9] = 3
ROOM = np.zeros((12, 30, 30), np.uint8)
ROOM[3:9, 5:12, 5:12] = 2
ROOM[3:9, 5:12, 12:20] = 5


@pytest.fixture(scope="module")
def found():
    """One of each kind, in an image and in a volume with sizes of pixels."""
    image = dataclasses.replace(cpm.example("disks"), spacing=(0.5, 0.25), unit="µm")
    ball = cpm.example("ball")
    result = cpm.segment(image, cpm.uniform_grid(image.shape))
    chosen = cpm.partition(result).select([(32, 18)])
    body = cpm.partition(ball).select([(15, 15, 15)])
    return {
        "plane": (result, chosen, [chosen], result.contours, result.contours[0], result.labels),
        "volume": (body, (body, body), body.surface, ROOM),
        "image": image, "ball": ball,
    }  # fmt: skip


@pytest.mark.parametrize("suffix", sorted(set(CONTOURS_WRITABLE) - {".roi"}))
def test_what_is_found_in_an_image_is_written_in_every_format_of_contours(found, suffix, tmp_path):
    for one in found["plane"]:
        cpm.export(one, tmp_path / f"a{suffix}", image=found["image"])
        assert (tmp_path / f"a{suffix}").stat().st_size > 0


@pytest.mark.parametrize("suffix", sorted(set(VOLUMES_WRITABLE) - {".seg.dcm", ".points.csv"}))
def test_what_is_found_in_a_volume_is_written_in_every_format_of_volumes(found, suffix, tmp_path):
    for one in found["volume"]:
        image = None if one is ROOM else found["ball"]
        cpm.export(one, tmp_path / f"a{suffix}", image=image)
        assert (tmp_path / f"a{suffix}").stat().st_size > 0


def test_labels_stay_as_they_are_in_masks(tmp_path):
    for labels, read in ((LABELS, cpm.load_image), (ROOM, cpm.load_volume)):
        for suffix in (".tif", ".nii.gz", ".nrrd"):
            cpm.export(labels, tmp_path / f"a{suffix}")
            assert np.array_equal(read(tmp_path / f"a{suffix}").values, labels), suffix
    assert np.array_equal(PIL.Image.open(io.BytesIO(cpm.to_bytes(LABELS, ".png"))), LABELS)
    assert tifffile.imread(io.BytesIO(cpm.to_bytes(LABELS == 70, ".tif"))).max() == 1


def test_labels_become_objects_with_holes_and_parts(caplog):
    text = cpm.to_bytes(LABELS, ".coco.json").decode()
    assert text.count('"category_id"') == 2
    assert caplog.records == []
    surface = cpm.formats.exportable.as_result(ROOM).surface
    assert sorted(set(surface.numbers.tolist())) == [2, 5]


def test_an_object_takes_the_size_of_pixels_and_the_provenance_of_its_image(found, tmp_path):
    cpm.export(found["plane"][1], tmp_path / "a.tif")
    read = cpm.load_image(tmp_path / "a.tif")
    assert read.unit == "µm"
    assert np.allclose(read.spacing, (0.5, 0.25))
    assert found["image"].sha256 in cpm.to_bytes(found["plane"][1], ".json").decode()
    cpm.export(LABELS, tmp_path / "b.tif", image=cpm.Image(np.eye(60)[:40], spacing=(2.0, 1.0), unit="mm"))
    assert np.allclose(cpm.load_image(tmp_path / "b.tif").spacing, (2.0, 1.0))


def test_bodies_have_numbers_and_names_in_label_volumes(found):
    result = cpm.objects_result(found["volume"][1], names=["left", "right"])
    assert [label.name for label in result.surface.labels] == ["left", "right"]
    assert result.labels.max() == 2
    assert result.table()["label"].tolist() == [2]  # the second covers the first
    assert result.image is found["ball"]


@pytest.mark.parametrize(
    ("what", "suffix", "says"),
    [
        (None, ".tif", "None cannot be exported: give a result"),
        ("a", ".svg", '"a" cannot be exported'),
        ([], ".svg", "[] cannot be exported"),
        ([1, 2], ".svg", "[1, 2] cannot be exported"),
        (LABELS * 0.5, ".tif", "the array holds values of type float64 in the shape (40, 60), but labels are whole"),
        (LABELS[0], ".tif", "in the shape (60,), but labels"),
        (-LABELS, ".tif", "the labels are -70 to 0, but must be"),
        (LABELS * 0, ".tif", "No contour of labels is closed"),
        (LABELS, ".ply", "labels has no surface"),
        (ROOM, ".svg", 'labels is a volume, but a file with the suffix ".svg"'),
        ([cpm.Contour(np.eye(3)[:, :2] * 9.0, True)], ".tif", "A .tif file is as large as an image, and none is known"),
        (cpm.Surface(np.eye(3), [[0, 1, 2]]), ".nii", "A .nii file is as large as an image"),
    ],
)
def test_what_a_file_cannot_hold_is_said_in_one_sentence(what, suffix, says, tmp_path):
    for write in (lambda: cpm.export(what, tmp_path / f"a{suffix}"), lambda: cpm.to_bytes(what, suffix)):
        with pytest.raises(ValueError, match=re.escape(says)) as caught:
            write()
        assert str(caught.value).endswith(".")
        assert not list(tmp_path.iterdir())


def test_labels_of_another_size_than_the_image_are_refused(found):
    with pytest.raises(ValueError, match=r"the labels have the shape \(40, 60\), but disks has"):
        cpm.to_bytes(LABELS, ".tif", image=found["image"])


@given(st.sets(st.integers(1, 2**31 - 1), min_size=1, max_size=5), st.booleans(), st.randoms())
@settings(max_examples=20, deadline=None)
def test_tables_masks_and_annotations_name_an_object_by_the_same_number(tmp_path_factory, numbers, volume, random):
    folder = tmp_path_factory.mktemp("numbers")
    order = random.sample(sorted(numbers), len(numbers))
    labels = np.zeros((8, 9, 60) if volume else (9, 60), np.int64)
    for place, number in enumerate(order):
        labels[..., 2:7, 4 + 10 * place : 9 + 10 * place] = number
    image = cpm.Image(labels.astype(float))
    cpm.export(labels, folder / "a.table.csv", folder / "a.nii.gz", image=image)
    rows = list(csv.DictReader((folder / "a.table.csv").read_text("utf-8").splitlines()))
    assert {int(row["label"]) for row in rows} == numbers
    assert all(float(row["intensity_mean"]) == pytest.approx(int(row["label"]), rel=1e-6) for row in rows)
    assert np.array_equal(np.asarray(nibabel.load(folder / "a.nii.gz").dataobj).T.reshape(labels.shape), labels)
    if not volume:
        plain = json.loads(cpm.to_bytes(labels, ".coco.json", image=image))
        assert {one["id"]: round(one["bbox"][0]) // 10 for one in plain["annotations"]} == {
            number: place for place, number in enumerate(order)
        }
