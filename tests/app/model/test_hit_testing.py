"""Hit testing finds the shape that the user sees under the pointer."""

from __future__ import annotations

import math

from cpm_app.model.document.edits import ShapeHit, find_shape_at
from hypothesis import assume, given
from hypothesis import strategies as st

from cpm_core.shapes import Circle, Everywhere, PolygonRegion

CIRCLE = Circle((50.0, 60.0), 20.0)


@given(st.floats(0, 2 * math.pi), st.floats(0, 40))
def test_a_circle_is_hit_exactly_inside_its_rim_widened_by_the_tolerance(angle: float, distance: float) -> None:
    assume(abs(distance - 23.0) > 0.1)
    at = (50.0 + distance * math.sin(angle), 60.0 + distance * math.cos(angle))
    assert find_shape_at((CIRCLE,), at, tolerance=3.0) == (ShapeHit(0, "body") if distance < 23.0 else None)


def test_handles_are_hit_only_while_their_circle_is_selected() -> None:
    for handle in CIRCLE.handles():
        assert find_shape_at((CIRCLE,), handle, 3.0) == ShapeHit(0, "body")
        assert find_shape_at((CIRCLE,), handle, 3.0, selected=0) == ShapeHit(0, "handle")


def test_a_rim_wins_over_the_inside_of_a_circle_drawn_later() -> None:
    large = Circle((50.0, 60.0), 40.0)
    assert find_shape_at((CIRCLE, large), (50.0, 80.0), 3.0) == ShapeHit(0, "body")


def test_what_was_drawn_last_wins_unless_another_is_selected() -> None:
    shapes = (CIRCLE, CIRCLE)
    assert find_shape_at(shapes, (50.0, 60.0), 3.0) == ShapeHit(1, "body")
    assert find_shape_at(shapes, (50.0, 60.0), 3.0, selected=0) == ShapeHit(0, "body")


def test_a_circle_within_a_region_is_hit_through_it_and_a_start_everywhere_nowhere() -> None:
    shapes = (CIRCLE, PolygonRegion(((0.0, 0.0), (0.0, 120.0), (120.0, 120.0), (120.0, 0.0))), Everywhere("grid"))
    assert find_shape_at(shapes, CIRCLE.center, 3.0) == ShapeHit(0, "body")
    assert find_shape_at(shapes, (100.0, 100.0), 3.0) is None
