"""Strokes, regions of interest and barriers: drawn with real mouse and key events, then moved, deleted and undone."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import Qt

from cpm_core.numerics import polyline
from cpm_core.shapes import Barrier, Grid, PolygonRegion, Stroke, Threshold
from tests.app.reading import only_shape

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL = Qt.KeyboardModifier.ControlModifier
PIXEL = 0.5

KINDS = {KEY.Key_T: Stroke, KEY.Key_I: PolygonRegion, KEY.Key_B: Barrier}
CORNERS = ((10.0, 12.0), (12.0, 48.0), (50.0, 44.0), (46.0, 10.0))


def near(points, expected) -> bool:
    return len(points) == len(expected) and all(
        math.dist(point, other) <= PIXEL for point, other in zip(points, expected, strict=True)
    )


def draw(hand, key: KEY, corners=CORNERS) -> None:
    """Draw a path corner by corner and end it with Enter."""
    hand.canvas.setFocus()
    hand.key(key)
    for corner in corners:
        hand.click(*corner)
    hand.key(KEY.Key_Return)


def test_clicks_place_corners_and_enter_ends_the_path_as_one_step_of_undo(window, hand, cases) -> None:
    for key in cases(KINDS):
        draw(hand, key)
        shape = only_shape(window)
        assert type(shape) is KINDS[key]
        assert near(shape.points, CORNERS)
        assert window.session.selected_shape == 0
        hand.key(KEY.Key_Z, CONTROL)
        assert window.session.document.shapes == ()
        hand.key(KEY.Key_Y, CONTROL)
        assert only_shape(window) == shape


def test_a_drag_draws_freehand_and_the_path_follows_the_pointer(window, hand, cases) -> None:
    for key in cases((KEY.Key_T, KEY.Key_B)):
        hand.key(key)
        angles = np.linspace(0.0, 1.5 * np.pi, 120)
        way = [(32.0 + 20.0 * math.sin(angle), 32.0 + 20.0 * math.cos(angle)) for angle in angles]
        hand.drag(*way)
        shape = only_shape(window)
        assert type(shape) is KINDS[key]
        assert max(polyline.distance_to_path(shape.points, position) for position in way) < 1.5
        assert max(polyline.distance_to_path(way, point) for point in shape.points) < 1.0
        assert 8 <= len(shape.points) < len(way)


def test_a_drag_from_corner_to_corner_draws_an_area_as_a_rectangle(window, hand, cases) -> None:
    for key, kind in cases({KEY.Key_I: PolygonRegion, KEY.Key_G: Grid, KEY.Key_H: Threshold}.items()):
        hand.canvas.setFocus()
        hand.key(key)
        hand.drag((50.0, 52.0), (30.0, 31.0), (10.0, 12.0))
        shape = only_shape(window)
        assert type(shape) is kind
        assert near(shape.points, ((50.0, 52.0), (50.0, 12.0), (10.0, 12.0), (10.0, 52.0)))


def test_a_click_on_the_first_corner_closes_a_region_but_not_a_barrier(window, hand) -> None:
    hand.key(KEY.Key_I)
    for corner in (*CORNERS, CORNERS[0]):
        hand.click(*corner)
    assert near(only_shape(window).points, CORNERS)
    hand.key(KEY.Key_B)
    for corner in (*CORNERS, CORNERS[0]):
        hand.click(*corner)
    assert len(window.session.document.shapes) == 1
    hand.canvas.setFocus()
    hand.key(KEY.Key_Return)
    assert near(window.session.document.shapes[1].points, (*CORNERS, CORNERS[0]))


def test_escape_discards_a_path_and_leaves_nothing_to_undo(window, hand, cases) -> None:
    for key in cases(KINDS):
        hand.key(key)
        hand.click(10, 10)
        hand.click(10, 40)
        hand.move(40, 40)
        assert window.session.document.shapes == ()
        assert "Esc cancels" in window.canvas_area.hint.text()
        hand.canvas.setFocus()
        hand.key(KEY.Key_Escape)
        hand.key(KEY.Key_Return)
        assert window.session.document.shapes == ()
        assert not window.actions_by_name["undo"].isEnabled()
        assert "Esc cancels" not in window.canvas_area.hint.text()


def test_a_path_is_selected_on_its_line_moved_by_drag_and_keys_and_deleted(window, hand, cases) -> None:
    for key in cases(KINDS):
        draw(hand, key)
        drawn = only_shape(window)
        hand.key(KEY.Key_Escape)
        assert window.session.selected_shape is None
        hand.key(KEY.Key_S)
        middle = tuple(np.mean(drawn.points[:2], axis=0))
        hand.drag(middle, (middle[0] + 2, middle[1] + 2), (middle[0] + 4, middle[1] + 3))
        assert window.session.selected_shape == 0
        moved = only_shape(window)
        assert near(moved.points, [(row + 4, col + 3) for row, col in drawn.points])
        assert [math.dist(a, b) for a, b in pairwise(moved.points)] == pytest.approx(
            [math.dist(a, b) for a, b in pairwise(drawn.points)]
        )
        hand.key(KEY.Key_Down)
        assert only_shape(window).points == tuple((row + 1, col) for row, col in moved.points)
        hand.key(KEY.Key_Delete)
        assert window.session.document.shapes == ()


def test_a_corner_of_the_selected_path_can_be_dragged_with_any_tool(window, hand, cases) -> None:
    for key in cases(KINDS):
        draw(hand, key)
        hand.drag(CORNERS[1], (15, 50), (20, 54))
        assert near(only_shape(window).points, (CORNERS[0], (20.0, 54.0), *CORNERS[2:]))
        assert window.actions_by_name["undo"].text().startswith("Undo reshape")
        hand.press(*CORNERS[0])
        hand.move(30, 30)
        hand.canvas.setFocus()
        hand.key(KEY.Key_Escape)
        hand.release(30, 30)
        assert near(only_shape(window).points, (CORNERS[0], (20.0, 54.0), *CORNERS[2:]))
        hand.key(KEY.Key_Z, CONTROL)
        assert near(only_shape(window).points, CORNERS)
