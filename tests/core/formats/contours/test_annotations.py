"""Annotation formats: labelme and pycocotools find in them what was drawn; and the JSON of everything."""

import contextlib
import csv
import json
from dataclasses import replace

import numpy as np
import PIL.Image
import PIL.ImageDraw
import pytest
import shapely
from pycocotools.coco import COCO

from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.formats import export, to_bytes
from cpm_core.numerics.polyline import path_length

from ..drawn import CELL, CORE, FIBRE, HOLE, RESULT

ROUNDING = 0.2
"""pycocotools rounds outlines to a fifth of a pixel: pixels whose centers are as near to the line may go either way."""


def test_labelme_has_a_polygon_or_a_line_of_each_contour():
    content = json.loads(to_bytes(RESULT, ".labelme.json"))
    assert (content["imagePath"], content["imageHeight"], content["imageWidth"]) == ("cells & more.png", 60, 90)
    assert content["imageData"] is None
    shapes = content["shapes"]
    assert [shape["shape_type"] for shape in shapes] == ["polygon", "linestrip", "polygon", "polygon", "point"]
    assert [shape["label"] for shape in shapes] == ["cell", "fibre", "contour", "Kern β", "contour"]
    for shape, contour in zip(shapes, RESULT.contours, strict=True):
        np.testing.assert_allclose(shape["points"], contour.points[:, ::-1] + 0.5, atol=1e-4)
    # what labelme asks of a shape, and of a file
    assert all({"label", "points", "group_id", "shape_type", "flags"} <= set(shape) for shape in shapes)
    asked = {"version", "flags", "shapes", "imagePath", "imageData", "imageHeight", "imageWidth"}
    assert asked | {"provenance"} == set(content)


def test_labelme_has_the_class_as_label_and_one_polygon_that_goes_around_the_holes():
    cell = replace(CELL, category="cell", name="cell 5", group=5)
    other = replace(HOLE, points=HOLE.points * 0.2 + [22.0, 60.0], hole=True, group=5)
    holes = [replace(HOLE, hole=True, group=5), other]
    outer = replace(cell, points=np.array([(0.0, 0.0), (0.0, 88.0), (58.0, 88.0), (58.0, 0.0)]))
    (shape,) = json.loads(to_bytes(replace(RESULT, contours=(outer, *holes)), ".labelme.json"))["shapes"]
    assert (shape["label"], shape["description"], shape["group_id"]) == ("cell", "cell 5", 5)
    # as labelme paints a polygon (`labelme.utils.shape_to_mask`)
    picture = PIL.Image.new("L", (90, 60))
    PIL.ImageDraw.Draw(picture).polygon([tuple(point) for point in shape["points"]], outline=1, fill=1)
    differ = np.argwhere((np.asarray(picture) > 0) != (rasterize_labels((outer, *holes), (60, 90)) > 0))
    edges = [shapely.LinearRing(contour.points) for contour in (outer, *holes)]
    slits = shapely.LineString(np.array(shape["points"])[:, ::-1] - 0.5)
    assert all(min(edge.distance(shapely.Point(pixel)) for edge in (*edges, slits)) < 1.5 for pixel in differ)
    assert shapely.Polygon(shape["points"]).area == pytest.approx(outer.area - sum(hole.area for hole in holes))


def test_labelme_finds_the_image_from_the_folder_of_the_file(tmp_path):
    image = tmp_path / "images" / "a b.png"
    (tmp_path / "found" / "here").mkdir(parents=True)
    for folder, wanted in (("images", "a b.png"), ("found/here", "../../images/a b.png"), (".", "images/a b.png")):
        (tmp_path / folder).mkdir(exist_ok=True)
        file = tmp_path / folder / "a.labelme.json"
        export(RESULT, file, image=image)
        path = json.loads(file.read_text(encoding="utf-8"))["imagePath"]
        assert path == wanted
        assert (file.parent / path).resolve() == image


def coco(tmp_path, result=RESULT):
    """What pycocotools finds in the file of a result."""
    export(result, tmp_path / "a.coco.json")
    with contextlib.redirect_stdout(None):
        return COCO(tmp_path / "a.coco.json")


def test_coco_has_an_instance_of_each_closed_contour_in_the_category_of_its_name(tmp_path):
    found = coco(tmp_path)
    (image,) = found.loadImgs(found.getImgIds())
    assert (image["file_name"], image["height"], image["width"]) == ("cells & more.png", 60, 90)
    instances = found.loadAnns(found.getAnnIds(imgIds=[image["id"]]))
    names = [found.loadCats([instance["category_id"]])[0]["name"] for instance in instances]
    assert names == ["cell", "object", "Kern β"]
    inside = (HOLE.area, CORE.area, 0.0)
    for instance, contour, taken in zip(instances, (CELL, HOLE, CORE), inside, strict=True):
        polygon = shapely.Polygon(contour.points[:, ::-1] + 0.5)
        assert instance["area"] == pytest.approx(polygon.area - taken, abs=1e-2)
        assert instance["gross_area"] == pytest.approx(polygon.area, abs=1e-2)
        x, y, width, height = instance["bbox"]
        np.testing.assert_allclose([x, y, x + width, y + height], polygon.bounds, atol=1e-4)
    np.testing.assert_allclose(
        np.reshape(instances[2]["segmentation"][0], (-1, 2)), CORE.points[:, ::-1] + 0.5, atol=1e-4
    )


def object_in_two_parts():
    """An object of two parts, one with a hole that holds another object, and a contour beyond the image."""
    parts = [replace(CELL, group=1, points=CELL.points * 0.6 + shift) for shift in ([0.0, 0.0], [0.0, 40.0])]
    hole = replace(HOLE, group=1, hole=True, points=HOLE.points * 0.6)
    other = replace(CORE, group=2, points=CORE.points * 0.6)
    return (*parts, hole, other, replace(CELL, name="", points=CELL.points * 0.5 + [40.0, -20.0]))


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # of pycocotools
@pytest.mark.parametrize("contours", [RESULT.contours, object_in_two_parts()])
def test_the_mask_of_an_instance_with_holes_is_its_label_in_the_label_mask(tmp_path, contours):
    result = replace(RESULT, contours=contours)
    found = coco(tmp_path, result)
    labels = rasterize_labels(contours, RESULT.shape)
    instances = found.loadAnns(found.getAnnIds())
    assert len(instances) == labels.max() == len({instance["id"] for instance in instances})
    masks = [(found.annToMask(instance) == 1, isinstance(instance["segmentation"], dict)) for instance in instances]
    assert any(packed for _, packed in masks)
    for label, (mask, packed) in enumerate(masks, start=1):
        differ = np.argwhere(mask != (labels == label))
        edges = [shapely.LinearRing(contour.points) for contour in contours if contour.closed]
        allowed = 0.0 if packed else ROUNDING
        assert all(min(edge.distance(shapely.Point(pixel)) for edge in edges) < allowed for pixel in differ)


def test_coco_of_open_contours_alone_is_refused(tmp_path):
    with pytest.raises(ValueError, match="a COCO file holds only closed ones"):
        export(replace(RESULT, contours=(FIBRE,)), tmp_path / "a.coco.json")
    assert list(tmp_path.iterdir()) == []


def test_the_json_of_everything_tells_the_run_the_contours_and_the_bridges():
    content = json.loads(to_bytes(RESULT, ".json"))
    assert content["image"] == {"name": "cells & more.png", "shape": [60, 90], "spacing": [0.5, 0.25], "unit": "µm"}
    assert content["run"] == {"steps": 123, "converged": True, "stop_reason": "at rest", "particles": 7}
    assert content["bridges"] == [{"length": 15.0, "strength": 0.5, "points": FIBRE.points[:2].tolist()}]
    for number, (entry, contour) in enumerate(zip(content["contours"], RESULT.contours, strict=True), start=1):
        np.testing.assert_allclose(entry["points"], contour.points, atol=1e-4)
        assert (entry["number"], entry["closed"], entry["name"]) == (number, contour.closed, contour.name)
        assert entry["junctions"] == list(contour.junctions)
        assert entry["length"] == pytest.approx(contour.length, abs=1e-4)
        assert entry["gross_area_in_units"] == pytest.approx(0.125 * contour.area)
        assert entry["net_area_in_units"] == pytest.approx(0.125 * entry["net_area"], abs=1e-4)
        assert entry["contrast"] is None
    assert [entry["inside"] for entry in content["contours"]] == [0, 0, 1, 3, 0]
    assert [entry["label"] for entry in content["contours"]] == [1, 0, 2, 3, 0]
    assert content["contours"][3]["color"] == "#0072B2"


def test_a_number_that_json_cannot_say_is_not_written(tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        export(replace(RESULT, contours=(replace(FIBRE, strength=float("nan")),)), tmp_path / "a.json")
    assert list(tmp_path.iterdir()) == []


def test_the_table_of_measures_has_a_row_for_each_contour():
    rows = list(csv.DictReader(to_bytes(RESULT, ".measures.csv").decode().splitlines()))
    assert [row["name"] for row in rows] == ["cell", "fibre", "", "Kern β", ""]
    assert [row["inside"] for row in rows] == ["0", "0", "1", "3", "0"]
    assert [row["closed"] for row in rows] == ["TRUE", "FALSE", "TRUE", "TRUE", "FALSE"]
    assert [row["junctions"] for row in rows] == ["0", "1", "0", "0", "0"]
    for row, contour in zip(rows, RESULT.contours, strict=True):
        assert float(row["length_px"]) == pytest.approx(contour.length, abs=1e-4)
        assert row["contrast"] == ""
        areas = [row[name] for name in ("gross_area_px2", "net_area_px2", "gross_area_um2", "net_area_um2")]
        if not contour.closed:
            assert areas == [""] * 4, "an open contour has no area"
            continue
        gross, net, gross_um2, net_um2 = map(float, areas)
        assert gross == pytest.approx(contour.area, abs=1e-4)
        assert gross_um2 == pytest.approx(contour.area * 0.125, rel=1e-6)
        assert net_um2 == pytest.approx(net * 0.125, rel=1e-5)
    plain = to_bytes(replace(RESULT, unit=None, spacing=(1.0, 1.0)), ".measures.csv").decode()
    assert "length_px,gross_area_px2,net_area_px2,program" in plain.splitlines()[0]


def test_the_table_of_objects_has_a_row_for_each_object_with_its_class():
    contours = [replace(one, category="nucleus") if one.group else one for one in object_in_two_parts()]
    rows = list(csv.DictReader(to_bytes(replace(RESULT, contours=tuple(contours)), ".table.csv").decode().splitlines()))
    assert [(row["label"], row["class"]) for row in rows] == [("1", "nucleus"), ("2", "nucleus"), ("3", "")]
    parts = sum(contour.area for contour in contours[:2]) - contours[2].area
    assert float(rows[0]["area_um2"]) == pytest.approx(0.125 * parts, rel=1e-6)
    with pytest.raises(ValueError, match="no closed contour"):
        to_bytes(replace(RESULT, contours=(FIBRE,)), ".table.csv")


def test_an_open_object_has_a_row_with_its_length():
    fibre = [replace(FIBRE, group=4, name="fiber", confidence=0.5), replace(FIBRE, group=4)]
    (row,) = csv.DictReader(to_bytes(replace(RESULT, contours=tuple(fibre)), ".table.csv").decode().splitlines())
    assert (row["label"], row.get("area_um2", "")) == ("4", "")
    assert float(row["length_um"]) == pytest.approx(2 * path_length(FIBRE.path * RESULT.spacing), rel=1e-6)
