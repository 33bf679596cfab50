"""Distances between contours, against circles whose distance is known."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.display.difference import difference
from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result


def result(*contours: Contour) -> Result:
    """A result that found these."""
    return Result(
        particles=np.empty((0, 2)),
        contours=contours,
        surface=None,
        steps=1,
        converged=True,
        stop_reason="",
        shape=(64, 64),
        spacing=(1.0, 1.0),
        unit="px",
        source="test",
    )


def ring(radius: float, middle: tuple[float, float] = (32.0, 32.0), corners: int = 400) -> Contour:
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    points = np.column_stack([middle[0] + radius * np.cos(angle), middle[1] + radius * np.sin(angle)])
    return Contour(points, closed=True)


def test_rings_around_one_place_lie_apart_by_the_difference_of_their_radii() -> None:
    apart = difference(result(ring(10.0)), result(ring(13.0)))
    assert apart.mean == pytest.approx(3.0, abs=0.02)
    assert apart.largest == pytest.approx(3.0, abs=0.02)


def test_a_contour_lies_on_itself_however_many_corners_it_has() -> None:
    apart = difference(result(ring(10.0)), result(ring(10.0, corners=250)))
    assert apart.largest < 0.26  # half the distance of the places at which it is measured


def test_the_largest_distance_is_that_of_the_place_furthest_off() -> None:
    apart = difference(result(ring(5.0)), result(ring(5.0), ring(5.0, (52.0, 32.0))))
    assert apart.largest == pytest.approx(20.0, abs=0.1)
    assert 0.0 < apart.mean < 20.0


def test_there_is_no_distance_to_nothing() -> None:
    assert difference(result(ring(5.0)), result()) is None
    assert difference(result(), result()) is None
