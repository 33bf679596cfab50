"""Length and area of polygons whose length and area are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Contour

from ..scenes import circle_points


@settings(max_examples=40, deadline=None)
@given(st.integers(3, 60), st.floats(0.5, 80.0), st.floats(-50.0, 50.0), st.floats(0.0, 6.3), st.booleans())
def test_regular_polygon(corners, radius, shift, angle, backwards):
    points = circle_points((shift, 2.0 * shift), radius, corners)
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    contour = Contour((points @ turn.T)[:: -1 if backwards else 1], closed=True)
    assert contour.length == pytest.approx(2.0 * corners * radius * np.sin(np.pi / corners), rel=1e-9)
    area = 0.5 * corners * radius**2 * np.sin(2.0 * np.pi / corners)
    assert contour.area == pytest.approx(area, rel=1e-6, abs=1e-6 * shift**2)
