"""SVG: what a browser draws are the very contours."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from cpm_core.formats import export

from ..drawn import LINE, LINE_AND_SQUARE, SQUARE

SVG = "{http://www.w3.org/2000/svg}"
RESULT = replace(LINE_AND_SQUARE, contours=(SQUARE, LINE), source="U & <me>.png")


def drawing(path, result=RESULT):
    export(result, path)
    return ET.parse(path).getroot()


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
