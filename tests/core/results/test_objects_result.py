"""Objects in files: holes, several parts, net areas and bridged stretches."""

import csv
import io
import math
from dataclasses import replace

import numpy as np
import pytest
import tifffile

import cpm_core as cpm
from cpm_core import Image, objects_result, to_bytes
from cpm_core.contours.rasterize import rasterize_labels, rasterize_mask
from cpm_core.image.region import Region
from cpm_core.objects.boundaries.boundary_guides import build_boundary_guides
from cpm_core.objects.outline import compute_outlines
from cpm_core.objects.selection import Selection

ROW, COL = np.indices((40, 60))


def selection(mask):
    """A mask as an object; nothing of its boundary follows a contour."""
    flat = np.zeros(mask.shape)
    found = compute_outlines(mask, build_boundary_guides(flat, flat))
    gaps = tuple(gap for outline in found for gap in outline.gaps)
    none, contours = np.empty((0, 2)), tuple(outline.contour for outline in found)
    return Selection(Region.from_mask(mask), mask.shape, none, none, contours, gaps, 0.5)


def ring(center, inner, outer):
    away = np.hypot(ROW - center[0], COL - center[1])
    return (away < outer) & (away > inner)


@pytest.fixture
def result():
    """A ring with two parts in its hole that make one object, and a disk."""
    parts = ring((20, 20), -1, 3) | ring((20, 27), -1, 2)
    masks = ring((20, 22), 9.5, 15), parts, ring((20, 50), -1, 5)
    return objects_result([selection(mask) for mask in masks], Image(np.zeros((40, 60)), spacing=(0.5, 0.5), unit="µm"))


def test_a_label_mask_has_one_label_for_each_object_and_none_in_its_holes(result):
    labels = rasterize_labels(result.contours, result.shape)
    expected = np.zeros(result.shape, int)
    expected[ring((20, 22), 9.5, 15)] = 1
    expected[ring((20, 20), -1, 3) | ring((20, 27), -1, 2)] = 2
    expected[ring((20, 50), -1, 5)] = 3
    assert np.array_equal(labels, expected)
    assert np.array_equal(tifffile.imread(io.BytesIO(to_bytes(result, ".tif"))), expected)
    assert np.array_equal(rasterize_mask(result.contours, result.shape), expected > 0)


def test_objects_of_an_image_and_bodies_of_a_volume_make_no_result_together() -> None:
    image, volume = cpm.example("disks"), cpm.example("ball")
    one, body = cpm.select(image, [(32, 18)]), cpm.partition(volume).select([(15, 15, 15)])
    for objects, place in (([body], image), ([one], volume), ([one, body], None)):
        with pytest.raises(ValueError, match="axes: give objects"):
            objects_result(objects, place)


def test_the_table_tells_object_hole_net_area_and_what_was_bridged(result):
    rows = list(csv.DictReader(io.StringIO(to_bytes(result, ".measures.csv").decode())))
    assert [row["object"] for row in rows] == [str(contour.group) for contour in result.contours]
    assert sorted(row["hole"] for row in rows) == ["FALSE"] * 4 + ["TRUE"]
    for row, contour in zip(rows, result.contours, strict=True):
        assert float(row["bridged_px"]) == pytest.approx(contour.length, abs=1e-3)
        assert float(row["net_area_um2"]) == pytest.approx(0.25 * float(row["net_area_px2"]), rel=1e-5)


def test_the_table_of_bodies_tells_the_confidence_of_each_that_is_known() -> None:
    none = np.empty((0, 3))
    body = Selection(Region.from_mask(np.pad(np.ones((4, 4, 4), bool), 2)), (8, 8, 8), none, none)
    for known, text in ((0.9, "0.9"), (math.nan, "")):
        found = objects_result([replace(body, confidence=known)], Image(np.zeros((8, 8, 8))))
        (row,) = csv.DictReader(io.StringIO(to_bytes(found, ".table.csv").decode()))
        assert row["confidence"] == text
