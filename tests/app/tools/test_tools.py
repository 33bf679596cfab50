"""The tools work as a user expects, with real mouse and key events."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

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
    assert window.session.selected == 0


def test_a_click_with_the_circle_tool_draws_nothing_and_says_how(window, hand) -> None:
    hand.click(30, 20)
    assert window.session.document.shapes == ()
    assert "drag" in window.canvas_area.messages.text


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


def test_everything_can_be_drawn_moved_and_deleted_with_keys_alone(window, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_K, CONTROL)
    drawn = circle_of(window)
    hand.key(KEY.Key_Right)
    hand.key(KEY.Key_Down, SHIFT)
    hand.key(KEY.Key_Greater)
    circle = circle_of(window)
    assert circle.center == (drawn.center[0] + 10.0, drawn.center[1] + 1.0)
    assert circle.radius == drawn.radius + 1.0
    hand.key(KEY.Key_Escape)
    assert window.session.selected is None
    hand.key(KEY.Key_N)
    assert window.session.selected == 0
    hand.key(KEY.Key_Backspace)
    assert window.session.document.shapes == ()


def test_the_wheel_zooms_around_the_pointer_and_fit_shows_the_whole_image(window, hand) -> None:
    canvas = hand.canvas
    whole = canvas.view.viewRect()
    point = QPointF(hand.at(20, 44))
    before = canvas.position(point)
    turn = QWheelEvent(
        point, canvas.viewport().mapToGlobal(point), QPoint(), QPoint(0, 360), Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(canvas.viewport(), turn)
    assert canvas.view.viewRect().width() < 0.7 * whole.width()
    assert canvas.position(point) == pytest.approx(before, abs=0.05)
    hand.key(KEY.Key_F)
    assert canvas.view.viewRect().width() == pytest.approx(whole.width())


@pytest.mark.parametrize("button", [Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton])
def test_a_drag_with_another_button_pans_by_what_the_pointer_moves(window, hand, button) -> None:
    canvas = hand.canvas
    start, end = hand.at(32, 32), hand.at(20, 40)
    before = canvas.position(QPointF(start))
    hand.qtbot.mousePress(canvas.viewport(), button, pos=start)
    hand.qtbot.mouseMove(canvas.viewport(), end)
    hand.qtbot.mouseRelease(canvas.viewport(), button, pos=end)
    assert canvas.position(QPointF(end)) == pytest.approx(before, abs=0.3)
    assert window.session.document.shapes == ()


def test_the_status_bar_shows_position_and_gray_value_under_the_pointer(window, hand) -> None:
    hand.move(32, 32)
    hand.wait(lambda: window.pointer_readout.text() == "row 32, col 32:  200")
    hand.move(3, 60)
    hand.wait(lambda: window.pointer_readout.text() == "row 3, col 60:  20")


def test_canvas_positions_and_points_are_each_others_inverse(hand) -> None:
    for position in ((0.0, 0.0), (12.5, 40.0), (63.0, 1.0)):
        assert hand.canvas.position(hand.canvas.point(position)) == pytest.approx(position, abs=0.1)
