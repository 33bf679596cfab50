"""DXF: ezdxf opens the drawing without a complaint and finds the contours in it."""

import io
from dataclasses import replace

import ezdxf
import numpy as np
import pytest

from cpm_core import Contour
from cpm_core.formats import export, to_bytes

from ..drawn import FIBRE, RESULT


def opened(result=RESULT):
    return ezdxf.read(io.StringIO(to_bytes(result, ".dxf").decode()))


def polylines(result=RESULT):
    return list(opened(result).modelspace().query("LWPOLYLINE"))


def test_the_drawing_is_one_of_release_2007_without_errors():
    drawing = opened()
    assert drawing.dxfversion == "AC1021"
    auditor = drawing.audit()
    assert (auditor.errors, auditor.fixes) == ([], [])


def test_polylines_run_through_the_contours_the_right_way_up_in_the_unit_of_the_image():
    drawn = [contour for contour in RESULT.contours if len(contour.points) > 1]
    for line, contour in zip(polylines(), drawn, strict=True):
        assert line.closed == contour.closed
        x, y = np.array(line.get_points("xy")).T
        np.testing.assert_allclose(x, (contour.points[:, 1] + 0.5) * 0.25, atol=1e-6)
        np.testing.assert_allclose(y, (60 - 0.5 - contour.points[:, 0]) * 0.5, atol=1e-6)


def test_a_vertex_by_itself_is_a_point():
    (point,) = opened().modelspace().query("POINT")
    assert tuple(point.dxf.location) == (81.0 * 0.25, 4.5 * 0.5, 0.0)


def test_names_are_layers_that_are_declared_and_colors_their_own(tmp_path):
    export(RESULT, tmp_path / "a.dxf")
    drawing = ezdxf.readfile(tmp_path / "a.dxf")
    assert [(line.dxf.layer, line.rgb) for line in drawing.modelspace().query("LWPOLYLINE")] == [
        ("cell", (230, 159, 0)),
        ("fibre", None),
        ("CLOSED", None),
        ("Kern β", (0, 114, 178)),
    ]
    drawn = {"cell", "CLOSED", "fibre", "Kern β", "OPEN"}
    assert {layer.dxf.name for layer in drawing.layers} - {"0", "Defpoints"} == drawn


@pytest.mark.parametrize(
    ("name", "layer"),
    [("", "OPEN"), ("a b/c", "a b_c"), ("ß", "ß"), ("日本", "日本"), ("x" * 300, "x" * 255)],
)
def test_names_of_layers_have_the_letters_that_they_may_have(name, layer):
    named = Contour(FIBRE.points, False, name=name)
    assert [line.dxf.layer for line in polylines(replace(RESULT, contours=(named,)))] == [layer]


@pytest.mark.parametrize(("unit", "number"), [("nm", 12), ("µm", 13), ("mm", 4), ("cm", 5), ("m", 6), (None, 0)])
def test_the_header_tells_the_unit(unit, number):
    assert opened(replace(RESULT, unit=unit)).units == number
