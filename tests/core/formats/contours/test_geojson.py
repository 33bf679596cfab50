"""GeoJSON: rings, holes and lines as RFC 7946 wants them, with what QuPath reads."""

import json
from dataclasses import replace

import matplotlib.path
import numpy as np
import pytest

from cpm_core.contours.rasterize import paint
from cpm_core.formats import encoded

from ..drawn import CELL, CORE, FIBRE, HOLE, RESULT


def features(result=RESULT):
    content = json.loads(encoded(result, ".geojson"))
    assert content["type"] == "FeatureCollection"
    return content["features"]


def signed_area(ring):
    x, y = np.array(ring).T
    return 0.5 * float(x[:-1] @ y[1:] - x[1:] @ y[:-1])


def test_each_contour_is_a_feature_of_its_kind():
    kinds = [feature["geometry"]["type"] for feature in features()]
    assert kinds == ["Polygon", "LineString", "Polygon", "Polygon", "Point"]
    assert all(feature["type"] == "Feature" for feature in features())


def test_coordinates_are_x_and_y_from_the_corner_of_the_image():
    cell, fibre, *_, dot = (feature["geometry"]["coordinates"] for feature in features())
    np.testing.assert_allclose(fibre, FIBRE.points[:, ::-1] + 0.5, atol=1e-4)
    assert dot == [81.0, 55.5]
    ring = np.array(cell[0])
    assert {tuple(p) for p in ring.tolist()} == {tuple(p) for p in np.round(CELL.points[:, ::-1] + 0.5, 4).tolist()}


def test_rings_are_closed_and_turn_as_the_standard_says():
    for feature in features():
        if feature["geometry"]["type"] == "Polygon":
            outer, *holes = feature["geometry"]["coordinates"]
            assert all(ring[0] == ring[-1] and len(ring) >= 4 for ring in (outer, *holes))
            assert signed_area(outer) > 0 > max(map(signed_area, holes), default=-1)


def test_a_polygon_covers_what_has_its_label_in_the_label_mask():
    mask = paint(RESULT.contours, RESULT.shape)
    row, col = np.indices(RESULT.shape)
    centers = np.stack([col.ravel() + 0.5, row.ravel() + 0.5], axis=1)
    polygons = [feature["geometry"] for feature in features() if feature["geometry"]["type"] == "Polygon"]
    assert [len(polygon["coordinates"]) for polygon in polygons] == [2, 2, 1]
    for label, polygon in enumerate(polygons, start=1):
        turns = sum(matplotlib.path.Path(ring).contains_points(centers).astype(int) for ring in polygon["coordinates"])
        assert np.array_equal((turns % 2 == 1).reshape(mask.shape), mask == label)


def test_names_colours_and_measurements_go_along():
    cell, fibre, hole, *_ = (feature["properties"] for feature in features())
    assert (cell["objectType"], cell["name"], cell["color"]) == ("annotation", "cell", [230, 159, 0])
    assert (hole["name"], hole["inside"], fibre["junctions"]) == ("contour 3", 1, [True, False])
    assert cell["measurements"]["Area px^2"] == pytest.approx(CELL.area)
    assert cell["measurements"]["Area µm^2"] == pytest.approx(CELL.area * 0.125)
    assert fibre["measurements"]["Length px"] == pytest.approx(FIBRE.length)
    assert "Area px^2" not in fibre["measurements"]
    assert all(isinstance(value, float) for value in cell["measurements"].values())


def test_units_are_left_out_where_they_are_not_known():
    plain = replace(RESULT, unit=None, spacing=(1.0, 1.0))
    assert set(features(plain)[0]["properties"]["measurements"]) == {"Length px", "Area px^2", "Edge strength"}


def test_holes_are_contours_of_their_own_as_well():
    names = [feature["properties"]["name"] for feature in features()]
    assert names == ["cell", "fibre", "contour 3", "Kern β", "contour 5"]
    assert HOLE.area > CORE.area
