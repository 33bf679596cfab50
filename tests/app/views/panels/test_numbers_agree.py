"""Each number of an object is the same in the panel, in tables, in labels and in annotations."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import replace

import nibabel
import numpy as np
import pytest
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.objects import build_objects_result
from cpm_app.session.features.object_measures import _measure_object
from cpm_app.session.features.object_rows import ObjectRow
from cpm_app.views.panels.objects import build_object_columns

from cpm_core import Image, to_bytes
from cpm_core.image.geometry import Geometry
from cpm_core.image.region import Region
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects

FIRST, SECOND, *OTHERS = SegmentedObjects().classes
CLASSES = (FIRST, replace(SECOND, name="nucleus"), *OTHERS)


def box(row, col, high, wide):
    """The corners of a box around whole pixels."""
    top, left, bottom, right = row - 0.5, col - 0.5, row + high - 0.5, col + wide - 0.5
    return ((top, left), (top, right), (bottom, right), (bottom, left))


def columns_of_panel(objects, image):
    """Cells of the panel by object and column."""
    columns = build_object_columns(objects, image.spacing)
    rows = [ObjectRow(("object", one.number), "object", "", one, _measure_object(one, image)) for one in objects.items]
    return {row.item.number: {column.name: column.value(row) for column in columns} for row in rows}


def table(result):
    return {int(row["label"]): row for row in csv.DictReader(io.StringIO(to_bytes(result, ".table.csv").decode()))}


def test_in_an_image_with_a_pixel_size():
    sides = (0.5, 0.25)
    image = Image(np.random.default_rng(0).normal(100, 9, (60, 80)), sides, "µm", "cells.tif")
    frame = SegmentedObject(3, (), Region((box(5, 5, 20, 30), box(10, 12, 6, 8))), (), 0.75, name="frame")
    dot = SegmentedObject(7, (), Region((box(40, 50, 9, 11),)), (), 0.6, category=2)
    objects = SegmentedObjects((frame, dot), CLASSES)
    document = Document(ImageReference("cells.tif", "", image.shape, 9.0, "", sides, "µm"), objects=objects)
    result, panel = build_objects_result(document), columns_of_panel(objects, image)
    rows = table(result)
    labels = np.asarray(nibabel.Nifti1Image.from_bytes(to_bytes(result, ".nii")).dataobj)
    coco = json.loads(to_bytes(result, ".coco.json"))
    instances = {one["id"]: one for one in coco["annotations"]}
    categories = {one["id"]: one["name"] for one in coco["categories"]}
    annotated = [one["properties"] for one in json.loads(to_bytes(result, ".geojson"))["features"]]
    features = {one["name"]: one for one in annotated}
    expected = (3, "frame", "object", 552, 0.75), (7, "nucleus 7", "nucleus", 99, 0.6)
    for number, name, kind, pixels, confidence in expected:
        area = pixels * math.prod(sides)
        assert panel[number]["area"] == pytest.approx(area)
        assert float(rows[number]["area_um2"]) == pytest.approx(area)
        assert int((labels == number).sum()) == pixels
        assert instances[number]["area"] == pixels
        feature = features[name]
        assert feature["measurements"]["Net area µm^2"] == pytest.approx(area)
        assert rows[number]["name"] == name
        assert feature["classification"]["name"] == categories[instances[number]["category_id"]] == kind
        assert rows[number]["class"] == kind
        assert panel[number]["confidence"] == pytest.approx(100 * confidence)
        assert float(rows[number]["confidence"]) == feature["measurements"]["Confidence"] == confidence
        assert instances[number]["score"] == confidence


def test_in_a_volume_of_uneven_voxels():
    sides = (2.0, 0.5, 0.75)
    plane, row, col = np.indices((20, 40, 50))
    away = np.sqrt(((plane - 9) * 2) ** 2 + ((row - 18) * 0.5) ** 2 + ((col - 20) * 0.75) ** 2)
    masks = {2: (away < 8) & (away > 3), 5: (abs(plane - 6) < 3) & (abs(row - 33) < 4) & (col > 40) & (col < 47)}
    image = Image(np.random.default_rng(0).normal(100, 9, plane.shape), sides, "mm", "head.nii", geometry=Geometry())
    items = (
        SegmentedObject(2, (), Region.from_mask(masks[2])),
        SegmentedObject(5, (), Region.from_mask(masks[5]), category=2),
    )
    objects = SegmentedObjects(items, CLASSES)
    document = Document(ImageReference("head.nii", "", image.shape, 9.0, "", sides, "mm"), objects=objects)
    result, panel = build_objects_result(document), columns_of_panel(objects, image)
    rows = table(result)
    labels = np.asarray(nibabel.Nifti1Image.from_bytes(to_bytes(result, ".nii")).dataobj)
    for number, mask in masks.items():
        volume = float(mask.sum()) * math.prod(sides)
        assert panel[number]["area"] == pytest.approx(volume)
        assert float(rows[number]["volume_mm3"]) == pytest.approx(volume)
        assert int((labels == number).sum()) == mask.sum()
        assert rows[number]["name"] == {2: "object 2", 5: "nucleus 5"}[number]
        assert rows[number]["class"] == {2: "object", 5: "nucleus"}[number]
        assert panel[number]["confidence"] is None
        assert rows[number]["confidence"] == ""
