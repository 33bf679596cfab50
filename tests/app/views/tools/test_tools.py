"""The tools work as a user expects, with real mouse and key events."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPointF, Qt

from cpm_core.shapes import Circle, Points

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
PIXEL = 0.5


def circle_of(window) -> Circle:
    (circle,) = window.session.document.shapes
    assert isinstance(circle, Circle)
    return circle


def test_a_drag_with_the_circle_tool_draws_from_the_center_to_the_pointer(window, hand) -> None:
    hand.drag((30, 20), (30, 24), (30, 32))
    circle = circle_of(window)
    assert circle.center == pytest.approx((30, 20), abs=PIXEL)
    assert circle.radius == pytest.approx(12, abs=PIXEL)
    assert window.session.selected_shape == 0


def test_escape_deletes_the_circle_being_drawn_and_leaves_nothing_to_undo(window, hand) -> None:
    hand.press(30, 20)
    hand.move(30, 40)
    assert len(window.session.document.shapes) == 1
    hand.qtbot.keyClick(hand.canvas, KEY.Key_Escape)
    hand.release(30, 40)
    assert window.session.document.shapes == ()
    assert not window.actions_by_name["undo"].isEnabled()


def test_the_point_tool_places_one_point_where_the_button_comes_up(window, hand) -> None:
    hand.key(KEY.Key_P)
    hand.click(10, 10)
    hand.drag((40, 10), (40, 20), (41, 31))
    one, other = window.session.document.shapes
    assert isinstance(one, Points)
    assert isinstance(other, Points)
    assert one.positions == (pytest.approx((10, 10), abs=PIXEL),)
    assert other.positions == (pytest.approx((41, 31), abs=PIXEL),)
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document.shapes == (one,)


def test_the_point_tool_places_no_point_in_the_margin(window, hand) -> None:
    hand.key(KEY.Key_P)
    hand.click(10, -4)
    assert window.session.document.shapes == ()
    assert not window.actions_by_name["undo"].isEnabled()
    hand.drag((40, 10), (40, 3), (40, -4))
    (one,) = window.session.document.shapes
    assert one.positions == (pytest.approx((40, 3), abs=PIXEL),)


def test_the_select_tool_moves_a_circle_and_its_handle_resizes_it(ready, hand) -> None:
    hand.key(KEY.Key_S)
    hand.drag((32, 32), (30, 30), (27, 38))
    circle = circle_of(ready)
    assert circle.center == pytest.approx((27, 38), abs=PIXEL)
    assert circle.radius == 10.0
    handle = circle.handles()[1]
    hand.drag(handle, (27, 50), (27, 53))
    resized = circle_of(ready)
    assert resized.center == circle.center
    assert resized.radius == pytest.approx(15, abs=PIXEL)


def test_each_gesture_is_one_step_of_undo_named_in_the_menu(ready, hand) -> None:
    window = ready
    first = window.session.document
    hand.key(KEY.Key_S)
    hand.drag((32, 32), (30, 30), (28, 28), (26, 26))
    moved = window.session.document
    assert window.actions_by_name["undo"].text() == "Undo move circle"
    hand.key(KEY.Key_Delete)
    assert window.session.document.shapes == ()
    assert window.actions_by_name["undo"].text() == "Undo delete circle"
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document == moved
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document == first
    assert window.actions_by_name["redo"].text() == "Redo move circle"
    hand.key(KEY.Key_Z, CONTROL | SHIFT)
    hand.key(KEY.Key_Y, CONTROL)
    assert window.session.document.shapes == ()


@pytest.mark.parametrize("button", [Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton])
def test_a_drag_with_another_button_pans_by_what_the_pointer_moves(window, hand, button) -> None:
    canvas = hand.canvas
    start, end = hand.at(32, 32), hand.at(20, 40)
    before = canvas.map_to_image(QPointF(start))
    hand.qtbot.mousePress(canvas.viewport(), button, pos=start)
    hand.qtbot.mouseMove(canvas.viewport(), end)
    hand.qtbot.mouseRelease(canvas.viewport(), button, pos=end)
    assert canvas.map_to_image(QPointF(end)) == pytest.approx(before, abs=0.3)
    assert window.session.document.shapes == ()
