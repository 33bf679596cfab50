"""Objects in files: holes, several parts, net areas and bridged stretches."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
import tifffile

from cpm_core import Contour, Image, encoded, measure, objects_result
from cpm_core.contours.rasterize import inside, paint
from cpm_core.objects.faces.faces import ground
from cpm_core.objects.outline import outlines
from cpm_core.objects.selection import Selection

ROW, COL = np.indices((40, 60))


def selection(mask):
    """A mask as an object; nothing of its boundary follows a contour."""
    flat = np.zeros(mask.shape)
    found = outlines(mask, ground(flat, flat, [], None))
    gaps = tuple(gap for outline in found for gap in outline.gaps)
    return Selection(mask, tuple(outline.contour for outline in found), gaps, 0.5, np.empty((0, 2)), np.empty((0, 2)))


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
    labels = paint(result.contours, result.shape)
    expected = np.zeros(result.shape, int)
    expected[ring((20, 22), 9.5, 15)] = 1
    expected[ring((20, 20), -1, 3) | ring((20, 27), -1, 2)] = 2
    expected[ring((20, 50), -1, 5)] = 3
    assert np.array_equal(labels, expected)
    assert np.array_equal(tifffile.imread(io.BytesIO(encoded(result, ".tif"))), expected)
    assert np.array_equal(inside(result.contours, result.shape), expected > 0)


def test_the_net_area_is_that_of_the_ring(result):
    rows = measure(result.contours, result.spacing)
    outer = next(row for row, c in zip(rows, result.contours, strict=True) if c.group == 1 and not c.hole)
    hole = next(row for row, c in zip(rows, result.contours, strict=True) if c.hole)
    assert outer.net_area == pytest.approx(outer.area - hole.area)
    assert outer.net_area == pytest.approx(ring((20, 22), 9.5, 15).sum(), rel=0.04)
    assert outer.net_area_in_units == pytest.approx(0.25 * outer.net_area)
    assert hole.net_area == 0.0
    assert (outer.label, hole.label) == (1, 0)


def test_the_table_tells_object_hole_net_area_and_what_was_bridged(result):
    rows = list(csv.DictReader(io.StringIO(encoded(result, ".measures.csv").decode())))
    assert [row["object"] for row in rows] == [str(contour.group) for contour in result.contours]
    assert sorted(row["hole"] for row in rows) == ["FALSE"] * 4 + ["TRUE"]
    for row, contour in zip(rows, result.contours, strict=True):
        assert float(row["bridged_px"]) == pytest.approx(contour.length, abs=1e-3)
        assert float(row["net_area_um2"]) == pytest.approx(0.25 * float(row["net_area_px2"]), rel=1e-5)


def test_a_table_of_other_contours_has_no_such_columns():
    square = Contour(np.array([(2.0, 2.0), (2.0, 9.0), (9.0, 9.0), (9.0, 2.0)]), True)
    plain = replace(objects_result([], Image(np.zeros((20, 20)))), contours=(square,))
    assert "object" not in encoded(plain, ".measures.csv").decode().splitlines()[0].split(",")
    assert b'"hole"' not in encoded(plain, ".json")


def test_geojson_has_holes_as_rings_and_not_as_features(result):
    features = json.loads(encoded(result, ".geojson"))["features"]
    assert len(features) == 4
    around = next(feature for feature in features if feature["properties"]["name"] == "object 1")
    assert len(around["geometry"]["coordinates"]) == 2
    measurements = around["properties"]["measurements"]
    assert measurements["Net area px^2"] == pytest.approx(ring((20, 22), 9.5, 15).sum(), rel=0.04)
    assert measurements["Bridged px"] > 0.0


def test_json_and_coco_tell_objects(result):
    entries = json.loads(encoded(result, ".json"))
    assert sorted((entry["object"], entry["hole"]) for entry in entries["contours"]) == [
        (1, False),
        (1, True),
        (2, False),
        (2, False),
        (3, False),
    ]
    assert len(entries["bridges"]) == 5
    assert len(json.loads(encoded(result, ".coco.json"))["annotations"]) == 3


def test_names_are_one_for_each_object():
    with pytest.raises(ValueError, match="2 names for 1 objects"):
        objects_result([selection(ring((20, 20), -1, 5))], Image(np.zeros((40, 60))), ["a", "b"])


@pytest.mark.parametrize("names", [None, 1j, "a", ["\n", 2], np.array(["a"]), np.zeros((2, 2)), {"a": 1}, {"a"}])
def test_names_of_another_kind_are_refused_in_a_sentence(names):
    with pytest.raises(ValueError, match=r"^names is .* but must be a list of names, .* left out\.$"):
        objects_result([selection(ring((20, 20), -1, 5))], Image(np.zeros((40, 60))), names)
