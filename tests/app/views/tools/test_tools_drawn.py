"""Ellipse, polygon, spray, grid, threshold and eraser: drawn with real mouse and key events."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.text.keys import insert_keys
from cpm_app.views.tools import AUTO_GROUP, TOOLS, TOOLS_BY_GROUP
from cpm_app.views.window.bars import ToolPalette
from PySide6.QtCore import QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QContextMenuEvent, QMouseEvent
from PySide6.QtWidgets import QApplication

from cpm_core.numerics import polyline
from cpm_core.shapes import (
    SEEDING_KINDS,
    Barrier,
    Charge,
    Circle,
    Ellipse,
    Everywhere,
    Grid,
    Points,
    Polygon,
    PolygonRegion,
    Stroke,
    Threshold,
)
from tests.app.reading import only_shape

pytestmark = pytest.mark.shared_window

KEY, MODIFIER = Qt.Key, Qt.KeyboardModifier
PIXEL = 0.5
CORNERS = ((10.0, 12.0), (12.0, 48.0), (50.0, 44.0), (46.0, 10.0))


def add(window, *shapes) -> None:
    for shape in shapes:
        window.session.edit("add", lambda document, shape=shape: edits.add_shape(document, shape))


def drag_with(hand, modifiers: MODIFIER, begin, end) -> None:
    """A drag with keys held, which the test library cannot hold while the pointer moves."""
    viewport, button, none = hand.canvas.viewport(), Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
    steps = (
        (QMouseEvent.Type.MouseButtonPress, begin, button, button),
        (QMouseEvent.Type.MouseMove, end, none, button),
    )
    for kind, at, changed, down in (*steps, (QMouseEvent.Type.MouseButtonRelease, end, button, none)):
        point = QPointF(hand.at(*at))
        there = QPointF(viewport.mapToGlobal(point))
        QApplication.sendEvent(viewport, QMouseEvent(kind, point, there, changed, down, modifiers))


def test_a_drag_with_the_ellipse_tool_draws_it_in_its_box_as_one_step_of_undo(window, hand) -> None:
    hand.key(KEY.Key_L)
    hand.drag((10, 12), (20, 30), (30, 52))
    ellipse = only_shape(window)
    assert isinstance(ellipse, Ellipse)
    assert ellipse.center == pytest.approx((20, 32), abs=PIXEL)
    assert ellipse.radii == pytest.approx((20, 10), abs=PIXEL)
    assert window.session.selected_shape == 0
    assert window.actions_by_name["undo"].text() == "Undo draw ellipse"
    hand.key(KEY.Key_Z, MODIFIER.ControlModifier)
    assert window.session.document.shapes == ()
    assert not window.actions_by_name["undo"].isEnabled()


def test_shift_makes_an_ellipse_round_and_ctrl_draws_it_from_its_center(window, hand) -> None:
    hand.key(KEY.Key_L)
    drag_with(hand, MODIFIER.ShiftModifier, (10, 10), (20, 40))
    drag_with(hand, MODIFIER.ControlModifier, (40, 30), (46, 40))
    drag_with(hand, MODIFIER.ControlModifier | MODIFIER.ShiftModifier, (30, 50), (25, 42))
    round_, central, both = window.session.document.shapes
    assert round_.radii == pytest.approx((15, 15), abs=PIXEL)
    assert round_.center == pytest.approx((25, 25), abs=PIXEL)
    assert central.center == pytest.approx((40, 30), abs=PIXEL)
    assert central.radii == pytest.approx((10, 6), abs=PIXEL)
    assert both.center == pytest.approx((30, 50), abs=PIXEL)
    assert both.radii == pytest.approx((8, 8), abs=PIXEL)


def test_shift_restricts_the_sides_of_a_path_to_eight_directions(window, hand) -> None:
    hand.key(KEY.Key_O)
    hand.click(10, 10)
    for end in ((12, 40), (43, 38), (30, 22)):
        drag_with(hand, MODIFIER.ShiftModifier, end, end)
    hand.canvas.setFocus()
    hand.key(KEY.Key_Return)
    points = np.array(only_shape(window).points)
    sides = np.degrees(np.arctan2(*np.diff(points, axis=0).T)) / 45.0
    np.testing.assert_allclose(sides, np.round(sides), atol=1e-6)
    assert tuple(points[1]) == pytest.approx((10, 40), abs=PIXEL)


def test_an_ellipse_is_resized_and_turned_by_its_handles_with_any_tool(window, hand) -> None:
    add(window, Ellipse((32.0, 32.0), (20.0, 10.0)))
    window.session.select_shape(0)
    hand.drag((32, 52), (32, 46), (35, 44))
    assert only_shape(window).radii == pytest.approx((12, 10), abs=PIXEL)
    turning = only_shape(window).handles()[-1]
    hand.drag(turning, (44, 44), (50, 32))
    turned = only_shape(window)
    assert turned.angle == pytest.approx(math.pi / 2, abs=0.05)
    assert turned.radii == pytest.approx((12, 10), abs=PIXEL)


SIZES = [
    (Circle((30.0, 30.0), 10.0), lambda shape: shape.radius),
    (Ellipse((30.0, 30.0), (10.0, 5.0)), lambda shape: shape.radii[0]),
    (Polygon(CORNERS), lambda shape: polyline.enclosed_area(shape.points)),
    (PolygonRegion(CORNERS), lambda shape: polyline.enclosed_area(shape.points)),
    (Grid(CORNERS), lambda shape: shape.spacing),
    (Threshold(CORNERS), lambda shape: shape.fraction),
    (Charge((30.0, 30.0), 2.0), lambda shape: shape.strength),
    (Charge((30.0, 30.0), -2.0), lambda shape: -shape.strength),
]
"""Shapes, and what is larger the larger they are."""


def test_less_and_greater_change_the_size_of_the_selected_shape_and_undo_brings_it_back(window, hand, cases) -> None:
    for shape, value in cases(SIZES):
        add(window, shape)
        window.session.select_shape(0)
        hand.canvas.setFocus()
        hand.key(KEY.Key_BracketRight)
        assert value(only_shape(window)) > value(shape)
        hand.key(KEY.Key_BracketLeft)
        hand.key(KEY.Key_BracketLeft)
        assert value(only_shape(window)) < value(shape)
        hand.key(KEY.Key_Z, MODIFIER.ControlModifier)
        assert only_shape(window) == shape


def test_spraying_scatters_points_in_the_ring_as_one_step_of_undo_and_never_two_in_one_place(window, hand) -> None:
    hand.key(KEY.Key_Y)
    assert "spray" in window.canvas_area.hint.text()
    way = [(20.0, 20.0), (20.0, 30.0), (30.0, 40.0), (40.0, 40.0)]
    hand.drag(*way)
    points = only_shape(window)
    assert isinstance(points, Points)
    radius = window.canvas_area.canvas.dispatcher.tool.radius
    positions = np.array(points.positions)
    assert len(positions) > 5
    assert polyline.distances_to_path(way, positions).max() <= radius + PIXEL
    between = np.hypot(*(positions[:, None] - positions[None]).transpose(2, 0, 1))
    assert between[np.triu_indices(len(positions), 1)].min() >= 2.0
    hand.key(KEY.Key_Z, MODIFIER.ControlModifier)
    assert window.session.document.shapes == ()
    assert "spray" in window.canvas_area.hint.text()  # not to draw a circle, which this tool does not
    hand.drag((1.0, 1.0), (0.0, 0.0), (-3.0, -3.0))
    assert (np.array(only_shape(window).positions) >= -0.5).all()


def test_the_eraser_deletes_single_points_and_other_shapes_that_it_touches_and_keeps_the_rest(window, hand) -> None:
    far = Circle((50.0, 50.0), 5.0)
    points = Points(((10.0, 10.0), (10.0, 20.0), (10.0, 30.0), (40.0, 10.0)))
    touched = (Barrier(((5.0, 15.0), (15.0, 15.0))), Stroke(((12.0, 25.0), (30.0, 25.0))), Charge((10.0, 27.0)))
    add(window, far, points, *touched)
    hand.key(KEY.Key_E)
    radius = hand.canvas.dispatcher.tool.radius
    assert radius < 6
    hand.drag((10, 8), (10, 32))
    assert window.session.document.shapes == (far, Points(((40.0, 10.0),)))
    assert window.actions_by_name["undo"].text() == "Undo erase"
    hand.key(KEY.Key_Z, MODIFIER.ControlModifier)
    assert window.session.document.shapes == (far, points, *touched)


@pytest.mark.parametrize(("key", "sign"), [(KEY.Key_A, 1), (KEY.Key_D, -1)])
def test_a_click_places_a_charge_and_a_drag_moves_it(window, hand, key, sign) -> None:
    hand.key(key)
    hand.click(20, 20)
    dropped = only_shape(window)
    assert isinstance(dropped, Charge)
    assert dropped.strength * sign > 0
    assert dropped.position == pytest.approx((20, 20), abs=PIXEL)
    assert window.session.selected_shape == 0
    hand.drag((20, 20), (30, 30), (40, 35))
    assert only_shape(window).position == pytest.approx((40, 35), abs=PIXEL)
    assert only_shape(window).strength == dropped.strength
    assert window.actions_by_name["undo"].text().startswith("Undo move")
    hand.key(KEY.Key_Z, MODIFIER.ControlModifier)
    assert only_shape(window) == dropped
    hand.key(KEY.Key_Z, MODIFIER.ControlModifier)
    assert window.session.document.shapes == ()


def test_every_tool_has_a_key_of_its_own_a_tip_and_an_icon(window) -> None:
    keys = [tool.shortcut for tool in TOOLS]
    assert len(set(keys)) == len(TOOLS)
    assert all(
        len(key.removeprefix("Shift+")) == 1 and tool.tip.endswith(".") for key, tool in zip(keys, TOOLS, strict=True)
    )
    for tool in TOOLS:
        assert insert_keys(tool.tip) in window.actions_by_name[tool.name].toolTip()
        assert not window.actions_by_name[tool.name].icon().isNull()


def test_ten_buttons_with_words_fit_and_open_all_tools_of_their_group(window, hand) -> None:
    palette = window.findChild(ToolPalette)
    assert [button.menu().actions()[0].iconText() for button in palette.buttons.values()] == list(TOOLS_BY_GROUP)
    assert len(TOOLS_BY_GROUP) == 10
    assert palette.width() <= 92
    buttons = palette.buttons.values()
    assert max(button.geometry().bottom() for button in buttons) - min(button.y() for button in buttons) <= 560
    offered = [action for button in buttons for action in button.menu().actions()]
    assert [action for action in offered if action.actionGroup()] == [
        window.actions_by_name[tool.name] for tool in TOOLS
    ]
    assert len(offered) == len(TOOLS) + len(SEEDING_KINDS)


def chosen_from_flyout(hand, button, name: str, place: QPoint, with_button: Qt.MouseButton) -> None:
    """Press a button of the palette and, in the menu that opens, choose an entry."""

    def choose() -> None:
        menu = button.menu()
        (entry,) = (action for action in menu.actions() if action.text().replace("&", "") == name)
        hand.qtbot.mouseClick(menu, Qt.MouseButton.LeftButton, pos=menu.actionGeometry(entry).center())

    QTimer.singleShot(50, choose)
    if with_button == Qt.MouseButton.RightButton:
        QApplication.sendEvent(
            button, QContextMenuEvent(QContextMenuEvent.Reason.Mouse, place, button.mapToGlobal(place))
        )
    else:
        hand.qtbot.mouseClick(button, with_button, pos=place)


def test_a_button_has_the_tool_of_its_group_that_was_used_last(window, hand, qtbot) -> None:
    buttons = window.findChild(ToolPalette).buttons
    circles, starts = buttons["Circle"], buttons[AUTO_GROUP]
    chosen_from_flyout(hand, circles, "Polygon", QPoint(circles.width() - 5, 20), Qt.MouseButton.LeftButton)
    assert (circles.text(), hand.canvas.dispatcher.tool.name, circles.isChecked()) == ("Polygon", "polygon", True)
    hand.canvas.setFocus()
    hand.key(KEY.Key_A)
    assert not circles.isChecked() and buttons["Charge"].isChecked()
    qtbot.mouseClick(circles, Qt.MouseButton.LeftButton, pos=QPoint(20, 20))
    assert hand.canvas.dispatcher.tool.name == "polygon"
    hand.canvas.setFocus()
    hand.key(KEY.Key_L)
    assert circles.text() == "Ellipse"
    chosen_from_flyout(hand, circles, "Circle", QPoint(20, 20), Qt.MouseButton.RightButton)
    assert (circles.text(), hand.canvas.dispatcher.tool.name) == ("Circle", "circle")
    chosen_from_flyout(hand, starts, "Centers", QPoint(starts.width() - 5, 20), Qt.MouseButton.LeftButton)
    assert starts.text() == "Centers" and window.session.document.shapes == (Everywhere("centers"),)
    qtbot.mouseClick(starts, Qt.MouseButton.LeftButton, pos=QPoint(20, 20))
    assert window.session.document.shapes == ()


def test_no_key_is_taken_twice(window) -> None:
    keys = [key for entry in window.actions_by_name.specs.values() for key in entry.shortcuts]
    keys += [action.shortcut().toString() for action in window.docks.actions]
    keys = [key for key in keys if key]
    assert sorted(keys) == sorted(set(keys))
