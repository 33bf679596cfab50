"""Annotation formats: shapes for labelme, instances of COCO, and the JSON of everything."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from cpm_core.formats import encoded, export

from ..drawn import CELL, CORE, FIBRE, HOLE, RESULT


def test_labelme_has_a_polygon_or_a_line_of_each_contour():
    content = json.loads(encoded(RESULT, ".labelme.json"))
    assert (content["imagePath"], content["imageHeight"], content["imageWidth"]) == ("cells & more.png", 60, 90)
    assert content["imageData"] is None
    shapes = content["shapes"]
    assert [shape["shape_type"] for shape in shapes] == ["polygon", "linestrip", "polygon", "polygon", "point"]
    assert [shape["label"] for shape in shapes] == ["cell", "fibre", "closed", "Kern β", "open"]
    for shape, contour in zip(shapes, RESULT.contours, strict=True):
        np.testing.assert_allclose(shape["points"], contour.points[:, ::-1] + 0.5, atol=1e-4)
    # what labelme asks of a shape, and of a file
    assert all({"label", "points", "group_id", "shape_type", "flags"} <= set(shape) for shape in shapes)
    assert {"version", "flags", "shapes", "imagePath", "imageData", "imageHeight", "imageWidth"} == set(content)


def test_coco_has_an_instance_of_each_closed_contour_in_the_category_of_its_name():
    content = json.loads(encoded(RESULT, ".coco.json"))
    assert content["images"] == [{"id": 1, "file_name": "cells & more.png", "width": 90, "height": 60}]
    names = {category["id"]: category["name"] for category in content["categories"]}
    instances = content["annotations"]
    assert [names[instance["category_id"]] for instance in instances] == ["cell", "object", "Kern β"]
    for instance, contour in zip(instances, (CELL, HOLE, CORE), strict=True):
        assert (instance["image_id"], instance["iscrowd"]) == (1, 0)
        assert instance["area"] == pytest.approx(contour.area, abs=1e-4)
        (polygon,) = instance["segmentation"]
        corners = np.reshape(polygon, (-1, 2))
        np.testing.assert_allclose(corners, contour.points[:, ::-1] + 0.5, atol=1e-4)
        x, y, width, height = instance["bbox"]
        np.testing.assert_allclose([x, y], corners.min(axis=0), atol=1e-4)
        np.testing.assert_allclose([x + width, y + height], corners.max(axis=0), atol=1e-4)
    assert [instance["id"] for instance in instances] == [1, 2, 3]


def test_coco_of_open_contours_alone_is_refused(tmp_path):
    with pytest.raises(ValueError, match="a COCO file tells only of closed ones"):
        export(replace(RESULT, contours=(FIBRE,)), tmp_path / "a.coco.json")
    assert list(tmp_path.iterdir()) == []


def test_the_json_of_everything_tells_the_run_the_contours_and_the_bridges():
    content = json.loads(encoded(RESULT, ".json"))
    assert content["image"] == {"name": "cells & more.png", "shape": [60, 90], "spacing": [0.5, 0.25], "unit": "µm"}
    assert content["run"] == {"steps": 123, "converged": True, "stop_reason": "at rest", "particles": 7}
    assert content["bridges"] == [{"length": 15.0, "strength": 0.5, "points": FIBRE.points[:2].tolist()}]
    for number, (entry, contour) in enumerate(zip(content["contours"], RESULT.contours, strict=True), start=1):
        np.testing.assert_allclose(entry["points"], contour.points, atol=1e-4)
        assert (entry["number"], entry["closed"], entry["name"]) == (number, contour.closed, contour.name)
        assert entry["junctions"] == list(contour.junctions)
        assert entry["length"] == pytest.approx(contour.length, abs=1e-4)
        assert entry["area_in_units"] == pytest.approx(0.125 * contour.area)
        assert entry["contrast"] is None
    assert [entry["inside"] for entry in content["contours"]] == [0, 0, 1, 3, 0]
    assert [entry["label"] for entry in content["contours"]] == [1, 0, 2, 3, 0]
    assert content["contours"][3]["colour"] == "#0072B2"


def test_a_number_that_json_cannot_say_is_not_written(tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        export(replace(RESULT, contours=(replace(FIBRE, strength=float("nan")),)), tmp_path / "a.json")
    assert list(tmp_path.iterdir()) == []


def test_the_table_of_measures_has_a_row_for_each_contour():
    rows = list(csv.DictReader(encoded(RESULT, ".measures.csv").decode().splitlines()))
    assert [row["name"] for row in rows] == ["cell", "fibre", "", "Kern β", ""]
    assert [row["inside"] for row in rows] == ["0", "0", "1", "3", "0"]
    assert [row["closed"] for row in rows] == ["TRUE", "FALSE", "TRUE", "TRUE", "FALSE"]
    assert [row["junctions"] for row in rows] == ["0", "1", "0", "0", "0"]
    for row, contour in zip(rows, RESULT.contours, strict=True):
        assert float(row["length_px"]) == pytest.approx(contour.length, abs=1e-4)
        assert float(row["area_px2"]) == pytest.approx(contour.area, abs=1e-4)
        assert float(row["area_um2"]) == pytest.approx(contour.area * 0.125, rel=1e-6)
        assert row["contrast"] == ""
    plain = encoded(replace(RESULT, unit=None, spacing=(1.0, 1.0)), ".measures.csv").decode()
    assert plain.splitlines()[0].endswith("length_px,area_px2")
