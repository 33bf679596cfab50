"""Closing open contours: what is added is straight or follows the edge, and is told as a bridge."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import edge_map
from cpm_core.contours.contour import Contour
from cpm_core.contours.rasterize import paint
from cpm_core.contours.result import Result
from cpm_core.reconstruction.curve.closing import can_be_closed, close_contours


def arc(opening: float, radius: float = 30.0, turn: float = 0.4, center: float = 50.0) -> Contour:
    """A circle that lacks an opening [rad]."""
    angle = turn + np.linspace(opening, 2 * np.pi, 150)
    return Contour(center + radius * np.column_stack([np.sin(angle), np.cos(angle)]), False, 40.0)


def result_of(*contours: Contour) -> Result:
    return Result(np.empty((0, 2)), contours, None, 1, True, "", (100, 100), (1.0, 1.0), None, "")


def disc_edges(radius: float = 30.0) -> np.ndarray:
    row, col = np.indices((100, 100))
    return edge_map(100.0 * (np.hypot(row - 50, col - 50) < radius), 1.0)


@settings(max_examples=40, deadline=None)
@given(st.floats(0.02, 2.0), st.floats(0.0, 6.0))
def test_a_straight_line_closes_an_arc_and_cuts_off_a_segment_of_the_circle(opening, turn) -> None:
    found = close_contours(result_of(arc(opening, turn=turn)))
    (contour,), (bridge,) = found.contours, found.bridges
    assert contour.closed
    assert bridge.length == pytest.approx(2 * 30.0 * np.sin(opening / 2), rel=1e-6)
    segment = 0.5 * 30.0**2 * (opening - np.sin(opening))
    assert contour.area == pytest.approx(np.pi * 30.0**2 - segment, rel=2e-3)
    assert {tuple(p) for p in bridge.points.tolist()} <= {tuple(p) for p in contour.points.tolist()}


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.5, 4.0])
def test_along_the_edge_the_whole_disc_is_found(turn) -> None:
    found = close_contours(result_of(arc(1.2, turn=turn)), disc_edges())
    (contour,), (bridge,) = found.contours, found.bridges
    assert contour.area == pytest.approx(np.pi * 30.0**2, rel=0.01)
    assert np.abs(np.hypot(*(bridge.points - 50).T) - 30.0).max() < 1.2
    assert bridge.strength > 20.0
    assert len(np.unique(paint(found.contours, (100, 100)))) == 2


def test_only_open_contours_with_near_ends_that_enclose_something_are_closed() -> None:
    line = Contour(np.column_stack([np.full(40, 9.0), np.arange(40.0)]), False)
    half = arc(1.3 * np.pi)
    there_and_back = Contour(np.array([[9.0, 5.0], [9.0, 30.0], [9.05, 5.0]]), False)
    whole = Contour(arc(0.1).points, True)
    assert [can_be_closed(one) for one in (line, half, there_and_back, whole)] == [False] * 4
    found = close_contours(result_of(line, half, there_and_back, whole), disc_edges())
    assert found.contours == (line, half, there_and_back, whole)
    assert found.bridges == ()
