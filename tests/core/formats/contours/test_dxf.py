"""DXF: pairs of group codes and values, as the reference of release 12 has them."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import Contour
from cpm_core.formats import encoded

from ..drawn import FIBRE, RESULT


def pairs(result=RESULT):
    lines = encoded(result, ".dxf").decode("ascii").splitlines()
    assert len(lines) % 2 == 0
    return [(int(code), value) for code, value in zip(lines[::2], lines[1::2], strict=True)]


def entities(result=RESULT):
    """Entities as lists of pairs, the vertices of a polyline among them."""
    found, section = [], None
    for code, value in pairs(result):
        if code == 2 and found == [] and value == "ENTITIES":
            section = value
        elif section and code == 0 and value == "ENDSEC":
            return found
        elif section and code == 0:
            found.append([(code, value)])
        elif section:
            found[-1].append((code, value))
    raise AssertionError("the section does not end")


def polylines(result=RESULT):
    """(layer, colour, closed, vertices) of each."""
    found = []
    for entity in entities(result):
        kind, values = entity[0][1], dict(entity)
        if kind == "POLYLINE":
            assert values[66] == "1"
            found.append((values[8], int(values[62]), values[70] == "1", []))
        elif kind == "VERTEX":
            found[-1][3].append((float(values[10]), float(values[20])))
    return found


def test_sections_and_tables_open_and_end_in_turn():
    marks = [value for code, value in pairs() if code == 0]
    assert marks[-1] == "EOF"
    assert marks.count("SECTION") == marks.count("ENDSEC") == 3
    assert marks.count("TABLE") == marks.count("ENDTAB") == 2
    assert marks.count("POLYLINE") == marks.count("SEQEND") == 4
    assert (9, "$ACADVER") in pairs()
    assert (1, "AC1009") in pairs()


def test_polylines_run_through_the_contours_the_right_way_up_in_the_unit_of_the_image():
    lines = polylines()
    drawn = [contour for contour in RESULT.contours if len(contour.points) > 1]
    for (_, _, closed, vertices), contour in zip(lines, drawn, strict=True):
        assert closed == contour.closed
        x, y = np.array(vertices).T
        np.testing.assert_allclose(x, (contour.points[:, 1] + 0.5) * 0.25, atol=1e-6)
        np.testing.assert_allclose(y, (60 - 0.5 - contour.points[:, 0]) * 0.5, atol=1e-6)


def test_a_vertex_by_itself_is_a_point():
    (point,) = (dict(entity) for entity in entities() if entity[0] == (0, "POINT"))
    assert (float(point[10]), float(point[20])) == (81.0 * 0.25, 4.5 * 0.5)


def test_names_are_layers_that_are_declared_and_colours_numbers():
    assert [(layer, colour) for layer, colour, *_ in polylines()] == [
        ("CELL", 30),
        ("FIBRE", 256),
        ("CLOSED", 256),
        ("KERN", 5),
    ]
    found = pairs()
    layers = [found[k + 1] for k, pair in enumerate(found) if pair == (0, "LAYER")]
    assert sorted(layers) == [(2, "CELL"), (2, "CLOSED"), (2, "FIBRE"), (2, "KERN"), (2, "OPEN")]


@pytest.mark.parametrize(
    ("name", "layer"),
    [("", "OPEN"), ("a b/c", "A_B_C"), ("ß", "SS"), ("日本", "OPEN"), ("x" * 40, "X" * 31)],
)
def test_names_of_layers_have_the_letters_that_they_may_have(name, layer):
    named = Contour(FIBRE.points, False, name=name)
    assert [line[0] for line in polylines(replace(RESULT, contours=(named,)))] == [layer]


@pytest.mark.parametrize(
    ("colour", "number"), [("#ff1005", 1), ("#000000", 7), ("#ffffff", 7), ("#7f8080", 8), ("#00f0ff", 4)]
)
def test_the_nearest_colour_is_taken(colour, number):
    coloured = Contour(FIBRE.points, False, colour=colour)
    assert [line[1] for line in polylines(replace(RESULT, contours=(coloured,)))] == [number]
