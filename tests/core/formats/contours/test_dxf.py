"""DXF: ezdxf opens the drawing without a complaint and finds the contours in it."""

import io
from dataclasses import replace

import ezdxf
import numpy as np
import pytest

from cpm_core import Contour
from cpm_core.formats import encoded

from ..drawn import FIBRE, RESULT


def opened(result=RESULT):
    return ezdxf.read(io.StringIO(encoded(result, ".dxf").decode("ascii")))


def polylines(result=RESULT):
    return list(opened(result).modelspace().query("POLYLINE"))


def test_the_drawing_is_one_of_release_12_without_errors():
    drawing = opened()
    assert drawing.dxfversion == "AC1009"
    auditor = drawing.audit()
    assert (auditor.errors, auditor.fixes) == ([], [])


def test_its_extents_are_those_of_the_image():
    header = opened().header
    assert header["$EXTMIN"][:2] == (0.0, 0.0)
    assert header["$EXTMAX"][:2] == (90 * 0.25, 60 * 0.5)


def test_polylines_run_through_the_contours_the_right_way_up_in_the_unit_of_the_image():
    drawn = [contour for contour in RESULT.contours if len(contour.points) > 1]
    for line, contour in zip(polylines(), drawn, strict=True):
        assert line.is_2d_polyline
        assert line.is_closed == contour.closed
        x, y, _ = np.array(list(line.points())).T
        np.testing.assert_allclose(x, (contour.points[:, 1] + 0.5) * 0.25, atol=1e-6)
        np.testing.assert_allclose(y, (60 - 0.5 - contour.points[:, 0]) * 0.5, atol=1e-6)


def test_a_vertex_by_itself_is_a_point():
    (point,) = opened().modelspace().query("POINT")
    assert tuple(point.dxf.location) == (81.0 * 0.25, 4.5 * 0.5, 0.0)


def test_names_are_layers_that_are_declared_and_colors_numbers():
    assert [(line.dxf.layer, line.dxf.color) for line in polylines()] == [
        ("CELL", 30),
        ("FIBRE", 256),
        ("CLOSED", 256),
        ("KERN", 5),
    ]
    drawn = {"CELL", "CLOSED", "FIBRE", "KERN", "OPEN"}
    assert {layer.dxf.name for layer in opened().layers} - {"0", "Defpoints"} == drawn


@pytest.mark.parametrize(
    ("name", "layer"),
    [("", "OPEN"), ("a b/c", "A_B_C"), ("ß", "SS"), ("日本", "OPEN"), ("x" * 40, "X" * 31)],
)
def test_names_of_layers_have_the_letters_that_they_may_have(name, layer):
    named = Contour(FIBRE.points, False, name=name)
    assert [line.dxf.layer for line in polylines(replace(RESULT, contours=(named,)))] == [layer]


@pytest.mark.parametrize(
    ("color", "number", "shown"),
    [
        ("#ff1005", 1, (255, 0, 0)),
        ("#7f8080", 8, (128, 128, 128)),
        ("#00f0ff", 4, (0, 255, 255)),
        # white on a dark screen, black on white paper
        ("#000000", 7, (255, 255, 255)),
        ("#ffffff", 7, (255, 255, 255)),
    ],
)
def test_the_nearest_color_is_taken(color, number, shown):
    (line,) = polylines(replace(RESULT, contours=(Contour(FIBRE.points, False, color=color),)))
    assert line.dxf.color == number
    assert tuple(ezdxf.colors.aci2rgb(number)) == shown
