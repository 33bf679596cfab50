"""Length and area of polygons whose length and area are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Contour

from ..scenes import circle_points

RECTANGLE = np.array([(1.0, 2.0), (1.0, 7.0), (4.0, 7.0), (4.0, 2.0)])


def test_rectangle():
    contour = Contour(RECTANGLE, closed=True)
    assert contour.length == pytest.approx(16.0, rel=1e-14)
    assert contour.area == pytest.approx(15.0, rel=1e-14)
    np.testing.assert_array_equal(contour.path, [*RECTANGLE, RECTANGLE[0]])


def test_open_curve_is_as_long_as_its_pieces_and_encloses_nothing():
    contour = Contour(RECTANGLE, closed=False)
    assert contour.length == pytest.approx(13.0, rel=1e-14)
    assert contour.area == 0.0
    np.testing.assert_array_equal(contour.path, RECTANGLE)


@settings(max_examples=40, deadline=None)
@given(st.integers(3, 60), st.floats(0.5, 80.0), st.floats(-50.0, 50.0), st.floats(0.0, 6.3), st.booleans())
def test_regular_polygon(corners, radius, shift, angle, backwards):
    points = circle_points((shift, 2.0 * shift), radius, corners)
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    contour = Contour((points @ turn.T)[:: -1 if backwards else 1], closed=True)
    assert contour.length == pytest.approx(2.0 * corners * radius * np.sin(np.pi / corners), rel=1e-9)
    area = 0.5 * corners * radius**2 * np.sin(2.0 * np.pi / corners)
    assert contour.area == pytest.approx(area, rel=1e-6, abs=1e-6 * shift**2)


def test_area_of_a_concave_polygon():
    arrow = np.array([(0.0, 0.0), (4.0, 2.0), (0.0, 4.0), (1.0, 2.0)])
    assert Contour(arrow, closed=True).area == pytest.approx(6.0, rel=1e-14)


def test_single_point_has_no_length():
    assert Contour(np.array([(3.0, 4.0)]), closed=False).length == 0.0
