"""SVG: what a browser draws are the very contours."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from cpm_core.contours.contour import Contour
from cpm_core.field.region_contrast import Sides
from cpm_core.formats import export

from ..drawn import LINE, LINE_AND_SQUARE, SQUARE

SVG = "{http://www.w3.org/2000/svg}"
RESULT = replace(LINE_AND_SQUARE, contours=(SQUARE, LINE), source="U & <me>.png")


def drawing(path, result=RESULT):
    export(result, path)
    return ET.parse(path).getroot()


def vertices(path):
    """Points (x, y) of a path, read as SVG means them: M and L absolute, Z closes."""
    commands = re.findall(r"([MLZ])\s*([-\d.]+)?[\s,]*([-\d.]+)?", path.get("d"))
    assert commands[0][0] == "M"
    return [(float(x), float(y)) for letter, x, y in commands if letter in "ML"], commands[-1][0] == "Z"


@pytest.mark.parametrize("index", [0, 1])
def test_path_runs_through_the_points_of_the_contour_with_x_along_columns(tmp_path, index):
    path = drawing(tmp_path / "a.svg").findall(f".//{SVG}path")[index]
    points, closed = vertices(path)
    contour = RESULT.contours[index]
    assert np.allclose(points, contour.points[:, ::-1], atol=1e-3)
    assert closed == contour.closed
    assert path.get("fill") == "none"
    assert path.get("data-closed") == ("true" if contour.closed else "false")
    assert float(path.get("data-strength")) == contour.strength
    assert float(path.get("data-length")) == pytest.approx(contour.length, abs=1e-3)


def test_view_box_is_the_extent_of_the_pixels(tmp_path):
    root = drawing(tmp_path / "a.svg")
    assert [float(part) for part in root.get("viewBox").split()] == [-0.5, -0.5, 80, 50]
    assert (root.get("width"), root.get("height")) == ("80", "50")


@pytest.mark.parametrize(
    ("spacing", "unit", "page"),
    [
        ((0.2, 0.2), "mm", ("16mm", "10mm")),
        ((0.5, 0.25), "cm", ("200mm", "250mm")),
        ((0.1, 0.1), "µm", ("80", "50")),
        ((0.4, 0.1), "µm", ("80", "200")),
    ],
)
def test_page_has_true_size_where_it_can_be_seen_and_true_proportions_always(tmp_path, spacing, unit, page):
    root = drawing(tmp_path / "a.svg", replace(RESULT, spacing=spacing, unit=unit))
    assert (root.get("width"), root.get("height")) == page
    assert root.get("preserveAspectRatio") == "none"
    assert (root.get("data-unit"), root.get("data-spacing")) == (unit, f"{spacing[0]} {spacing[1]}")


def test_the_title_holds_the_name_of_the_image_in_any_characters(tmp_path):
    assert drawing(tmp_path / "a.svg").find(f"{SVG}title").text == "Contours of U & <me>.png"


def test_a_result_without_contours_is_an_empty_drawing(tmp_path):
    root = drawing(tmp_path / "a.svg", replace(RESULT, contours=()))
    assert root.findall(f".//{SVG}path") == []


def test_a_name_is_the_title_of_a_path_and_a_colour_its_stroke(tmp_path):
    named = replace(SQUARE, name="<me> & U", color="#e69f00")
    first, second = drawing(tmp_path / "a.svg", replace(RESULT, contours=(named, LINE))).findall(f".//{SVG}path")
    assert (first.find(f"{SVG}title").text, first.get("stroke")) == ("<me> & U", "#e69f00")
    assert (second.find(f"{SVG}title"), second.get("stroke")) == (None, None)


def test_contrast_is_told_where_it_can_be_measured(tmp_path):
    values = np.where(np.arange(80) < 40, 0.0, 100.0) * np.ones((50, 1))
    points = np.stack([np.arange(15.0, 35.0), np.full(20, 39.5)], axis=1)
    edge = Contour(points, closed=False, sides=Sides(values, points, np.tile([0.0, 1.0], (20, 1)), 1.0))
    first, second = drawing(tmp_path / "a.svg", replace(RESULT, contours=(edge, LINE))).findall(f".//{SVG}path")
    assert float(first.get("data-contrast")) == pytest.approx(edge.contrast, abs=1e-4)
    assert second.get("data-contrast") is None
