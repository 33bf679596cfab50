"""Every tool works without a pointer: arrow keys move a cross-hair, and Enter is the button."""

from __future__ import annotations

import math

import pytest
from cpm_app.model.document import edits
from cpm_app.views.tools import TOOLS
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QCursor

from cpm_core.shapes import Barrier, Circle, Ellipse, Grid, Polygon, PolygonRegion, Stroke, Threshold

pytestmark = pytest.mark.shared_window

KEY, MODIFIER = Qt.Key, Qt.KeyboardModifier
KEYS = {tool.name: getattr(KEY, f"Key_{tool.shortcut}") for tool in TOOLS if len(tool.shortcut) == 1}


@pytest.fixture
def keys(window, hand):
    """Keys in a row on the image; the cross-hair begins in the center of the visible part."""
    QCursor.setPos(window.mapToGlobal(QPoint(2, 2)))  # off the image, wherever it was left
    hand.canvas.setFocus()
    names = {"^": KEY.Key_Up, "v": KEY.Key_Down, "<": KEY.Key_Left, ">": KEY.Key_Right, "!": KEY.Key_Return}

    def press(text: str) -> None:
        """Arrows by 10 px, with a dot behind them by one; ! is Enter."""
        for place, sign in enumerate(text):
            fine = text[place + 1 : place + 2] == "."
            if sign != ".":
                held = MODIFIER.NoModifier if fine or sign == "!" else MODIFIER.ShiftModifier
                hand.key(names[sign], held)

    return press


def drawn(window):
    return window.session.document.shapes


def test_enter_shows_the_cross_hair_in_the_center_and_arrows_move_it(window, hand, keys) -> None:
    crosshair = window.canvas_area.crosshair
    assert crosshair.position is None
    keys("!")
    assert crosshair.position == pytest.approx((32, 32), abs=1)
    row, col = crosshair.position
    keys("v>.>.^.")
    assert crosshair.position == (row + 9, col + 2)
    assert window.pointer_readout.text().startswith(f"row {row + 9:.0f}, col {col + 2:.0f}:")
    assert "cross-hair" in window.canvas_area.hint.text()
    hand.key(KEY.Key_Escape)
    assert crosshair.position is None
    assert "cross-hair" not in window.canvas_area.hint.text()


PATHS = {"polygon": Polygon, "stroke": Stroke, "grid_area": Grid, "threshold": Threshold, "region": PolygonRegion}


@pytest.mark.parametrize("name", [*PATHS, "barrier"])
def test_paths_are_drawn_corner_by_corner_and_ended_by_a_second_enter(window, hand, keys, name) -> None:
    hand.key(KEYS[name])
    keys("!")
    row, col = window.canvas_area.crosshair.position
    keys("!v!>!!")
    (shape,) = drawn(window)
    assert type(shape) is {**PATHS, "barrier": Barrier}[name]
    assert shape.points == ((row, col), (row + 10, col), (row + 10, col + 10))


@pytest.mark.parametrize(("name", "kind"), [("circle", Circle), ("ellipse", Ellipse)])
def test_circles_and_ellipses_are_dragged(window, hand, keys, name, kind) -> None:
    hand.key(KEYS[name])
    keys("!")
    row, col = window.canvas_area.crosshair.position
    keys("!>v!>")
    (shape,) = drawn(window)
    assert shape == (
        Circle((row, col), math.hypot(10, 10)) if kind is Circle else Ellipse((row + 5, col + 5), (5.0, 5.0))
    )


@pytest.mark.parametrize("name", ["attract", "repel"])
def test_a_charge_is_placed_dragged_released_and_dragged_again(window, hand, keys, name) -> None:
    hand.key(KEYS[name])
    keys("!")
    row, col = window.canvas_area.crosshair.position
    keys("!>>!v")
    (charge,) = drawn(window)
    assert charge.position == (row, col + 20)
    keys("^!<!")
    (charge,) = drawn(window)
    assert charge.position == (row, col + 10)
    keys("v!")
    assert len(drawn(window)) == 2


def test_a_shape_and_its_handle_are_dragged_with_the_select_tool(window, hand, keys) -> None:
    keys("!")
    row, col = window.canvas_area.crosshair.position
    window.session.edit("add", lambda document: edits.add_shape(document, Circle((row, col), 10.0)))
    hand.key(KEYS["select"])
    keys("!!>!")
    assert drawn(window) == (Circle((row, col + 10), 10.0),)
    keys(">!>.>.>.!")
    assert drawn(window) == (Circle((row, col + 10), 13.0),)


def test_another_tool_mode_or_image_hides_the_cross_hair(window, hand, keys, image_file) -> None:
    crosshair, opened = window.canvas_area.crosshair, window.session.image
    for change in (
        lambda: hand.key(KEYS["barrier"]),
        lambda: hand.key(KEY.Key_F2, MODIFIER.ControlModifier),
        lambda: window.open_image(image_file),
    ):
        keys("!")
        assert crosshair.position is not None
        change()
        hand.wait(lambda: crosshair.position is None)
    hand.wait(lambda: window.session.image is not opened and window.session.idle)


def test_the_cross_hair_gives_way_to_the_objects_that_a_run_offers(window, hand, keys) -> None:
    window.session.edit("add", lambda document: edits.add_shape(document, Circle((32.0, 32.0), 10.0)))
    window.session.select_shape(None)
    keys("!")
    hand.key(KEY.Key_Space)
    hand.wait(lambda: bool(window.workspace.object_selection.proposals))
    assert window.canvas_area.crosshair.position is None
    hand.wait(lambda: window.canvas_area.hint.text().startswith("1 proposal"))
    keys("!")
    assert len(window.session.document.objects.items) == 1


def test_a_press_of_the_pointer_hides_the_cross_hair(window, hand, keys) -> None:
    keys("!")
    hand.move(5, 5)
    assert window.canvas_area.crosshair.position == pytest.approx((32, 32), abs=1)
    hand.drag((20, 20), (20, 25), (20, 28))
    assert window.canvas_area.crosshair.position is None
    (circle,) = drawn(window)
    assert circle.radius == pytest.approx(8, abs=0.5)
