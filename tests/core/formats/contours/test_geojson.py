"""GeoJSON: shapely finds valid shapes in it, with holes and turns as RFC 7946 wants them, and what QuPath reads."""

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely

from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.formats import to_bytes

from ..drawn import CELL, CORE, FIBRE, HOLE, RESULT


def features(result=RESULT):
    content = json.loads(to_bytes(result, ".geojson"))
    assert content["type"] == "FeatureCollection"
    return content["features"]


def shapes(result=RESULT):
    """What shapely makes of the geometries."""
    return [shapely.from_geojson(json.dumps(feature["geometry"])) for feature in features(result)]


def polygons():
    return [shape for shape in shapes() if shape.geom_type == "Polygon"]


def test_each_contour_is_a_valid_feature_of_its_kind():
    assert all(feature["type"] == "Feature" for feature in features())
    assert [shape.geom_type for shape in shapes()] == ["Polygon", "LineString", "Polygon", "Polygon", "Point"]
    assert all(shape.is_valid for shape in shapes())


def test_coordinates_are_x_and_y_from_the_corner_of_the_image():
    cell, fibre, *_, dot = shapes()
    np.testing.assert_allclose(fibre.coords, FIBRE.points[:, ::-1] + 0.5, atol=1e-4)
    assert dot.coords[:] == [(81.0, 55.5)]
    assert set(cell.exterior.coords) == {tuple(p) for p in np.round(CELL.points[:, ::-1] + 0.5, 4).tolist()}


def test_rings_turn_as_the_standard_says():
    for polygon in polygons():
        assert polygon.exterior.is_ccw
        assert not any(hole.is_ccw for hole in polygon.interiors)


def test_areas_leave_out_the_holes():
    areas = [CELL.area - HOLE.area, HOLE.area - CORE.area, CORE.area]
    assert [polygon.area for polygon in polygons()] == pytest.approx(areas, abs=1e-2)


def test_a_polygon_covers_what_has_its_label_in_the_label_mask():
    mask = rasterize_labels(RESULT.contours, RESULT.shape)
    row, col = np.indices(RESULT.shape)
    for label, polygon in enumerate(polygons(), start=1):
        assert np.array_equal(shapely.contains_xy(polygon, col + 0.5, row + 0.5), mask == label)


def test_names_colors_and_measurements_go_along():
    cell, fibre, hole, *_ = (feature["properties"] for feature in features())
    assert (cell["objectType"], cell["name"], cell["color"]) == ("annotation", "cell", [230, 159, 0])
    assert (hole["name"], hole["inside"], fibre["junctions"]) == ("contour 3", 1, [True, False])
    assert cell["measurements"]["Gross area px^2"] == pytest.approx(CELL.area)
    assert cell["measurements"]["Net area px^2"] == pytest.approx(CELL.area - HOLE.area)
    assert cell["measurements"]["Gross area µm^2"] == pytest.approx(CELL.area * 0.125)
    assert fibre["measurements"]["Length px"] == pytest.approx(FIBRE.length)
    assert not [name for name in fibre["measurements"] if "area" in name.lower()]
    assert all(isinstance(value, float) for value in cell["measurements"].values())


def test_units_are_left_out_where_they_are_not_known():
    plain = replace(RESULT, unit=None, spacing=(1.0, 1.0))
    assert set(features(plain)[0]["properties"]["measurements"]) == {
        "Length px",
        "Net area px^2",
        "Gross area px^2",
        "Edge strength",
    }
