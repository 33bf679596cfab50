"""Hit testing finds the shape that the user sees under the pointer."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.model.document.hit_testing import Hit, hit
from cpm_core.shapes import Barrier, Circle, Everywhere, Points, Region, Stroke

CIRCLE = Circle((50.0, 60.0), 20.0)


@given(st.floats(0, 2 * math.pi), st.floats(0, 40))
def test_a_circle_is_hit_exactly_inside_its_rim_widened_by_the_tolerance(angle: float, distance: float) -> None:
    at = (50.0 + distance * math.sin(angle), 60.0 + distance * math.cos(angle))
    found = hit((CIRCLE,), at, tolerance=3.0)
    if distance < 22.9:
        assert found == Hit(0, "body")
    elif distance > 23.1:
        assert found is None


def test_handles_are_hit_only_while_their_circle_is_selected() -> None:
    for handle in CIRCLE.handles():
        assert hit((CIRCLE,), handle, 3.0) == Hit(0, "body")
        assert hit((CIRCLE,), handle, 3.0, selected=0) == Hit(0, "handle")


def test_a_rim_wins_over_the_inside_of_a_circle_drawn_later() -> None:
    large = Circle((50.0, 60.0), 40.0)
    assert hit((CIRCLE, large), (50.0, 80.0), 3.0) == Hit(0, "body")


def test_what_was_drawn_last_wins_unless_another_is_selected() -> None:
    shapes = (CIRCLE, CIRCLE)
    assert hit(shapes, (50.0, 60.0), 3.0) == Hit(1, "body")
    assert hit(shapes, (50.0, 60.0), 3.0, selected=0) == Hit(0, "body")


def test_points_are_hit_at_any_of_them_and_nowhere_between() -> None:
    shapes = (Points(((10.0, 10.0), (10.0, 40.0))),)
    assert hit(shapes, (11.0, 39.0), 3.0) == Hit(0, "body")
    assert hit(shapes, (10.0, 25.0), 3.0) is None


CORNERS = ((10.0, 10.0), (10.0, 50.0), (40.0, 50.0))


@pytest.mark.parametrize("kind", [Stroke, Region, Barrier])
def test_a_path_is_hit_on_its_line_and_not_beside_or_within_it(kind) -> None:
    shapes = (kind(CORNERS),)
    assert hit(shapes, (12.0, 30.0), 3.0) == Hit(0, "body")
    assert hit(shapes, (25.0, 48.0), 3.0) == Hit(0, "body")
    assert hit(shapes, (16.0, 40.0), 3.0) is None


def test_only_a_region_is_hit_between_its_last_corner_and_its_first() -> None:
    between = (25.0, 30.0)
    assert hit((Region(CORNERS),), between, 1.0) == Hit(0, "body")
    assert hit((Barrier(CORNERS),), between, 1.0) is None


def test_a_circle_within_a_region_is_hit_through_it_and_a_start_everywhere_nowhere() -> None:
    shapes = (CIRCLE, Region(((0.0, 0.0), (0.0, 120.0), (120.0, 120.0), (120.0, 0.0))), Everywhere("grid"))
    assert hit(shapes, CIRCLE.center, 3.0) == Hit(0, "body")
    assert hit(shapes, (100.0, 100.0), 3.0) is None
