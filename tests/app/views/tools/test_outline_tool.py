"""Objects outlined by hand with pointer and keys, on a disk whose area is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt

from tests.app.conftest import Hand
from tests.app.reading import accepted_items

pytestmark = pytest.mark.shared_window

KEY, SHIFT = Qt.Key, Qt.KeyboardModifier.ShiftModifier
CENTER, RADIUS = (32.0, 32.0), 18.0
AREA = math.pi * RADIUS**2


def at(angle: float, radius: float = RADIUS) -> tuple[float, float]:
    return CENTER[0] + radius * math.sin(angle), CENTER[1] + radius * math.cos(angle)


@pytest.fixture
def drawing(window: MainWindow, hand: Hand) -> MainWindow:
    """The disk, the tool in use and the edges at hand, before any run."""
    hand.canvas.setFocus()
    hand.key(KEY.Key_U)
    hand.wait(lambda: window.workspace.outline_editing.edges is not None)
    return window


@pytest.fixture
def outlined(ready: MainWindow, hand: Hand) -> MainWindow:
    """The disk with its closed contour, no object, the tool in use and the edges at hand."""
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.key(KEY.Key_U)
    hand.wait(lambda: ready.workspace.outline_editing.edges is not None and ready.session.idle)
    (contour,) = ready.session.scene.contours
    assert contour.closed and accepted_items(ready) == ()
    return ready


def click_along(hand: Hand, *angles: float) -> None:
    for angle in angles:
        hand.move(*at(angle))
        hand.click(*at(angle))


def redraw_stretch(hand: Hand) -> None:
    """Draw a straight line between two places on the outline, by way of a place away from it."""
    hand.click(*at(-0.4))
    hand.canvas.dispatcher.set_modifiers(SHIFT)
    hand.canvas.dispatcher.press_button(hand.canvas, at(0.0, RADIUS + 8.0))
    hand.canvas.dispatcher.release_button()
    hand.canvas.move_pointer_to(at(0.4))
    hand.canvas.dispatcher.set_modifiers(Qt.KeyboardModifier.NoModifier)
    hand.canvas.dispatcher.press_button(hand.canvas, at(0.4))
    hand.canvas.dispatcher.release_button()
    hand.key(KEY.Key_Return)


def farthest(item) -> float:
    return float(np.hypot(*(np.concatenate(item.paths) - CENTER).T).max())


def test_a_closed_line_along_the_edge_is_an_object_before_any_run(drawing, hand) -> None:
    click_along(hand, 0.0, 2.0, 4.0, 0.0)
    (one,) = accepted_items(drawing)
    assert one.region.size == pytest.approx(AREA, rel=0.04) and one.measure_gap_length() < 3.0
    assert drawing.workspace.object_list.selected_numbers == {1}
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert accepted_items(drawing) == ()


def test_an_open_line_along_the_edge_is_an_open_object_with_a_length_and_no_area(drawing, hand) -> None:
    click_along(hand, 0.0, 1.0, 2.0)
    hand.key(KEY.Key_Return)
    (one,) = accepted_items(drawing)
    assert (one.region.size, one.region.boundary) == (0.0, ())
    assert one.measure_perimeter() == pytest.approx(2.0 * RADIUS, rel=0.04)
    assert np.abs(np.hypot(*(np.array(one.line) - CENTER).T) - RADIUS).max() < 1.0
    assert drawing.session.history.undo_name == "draw line"
    assert drawing.workspace.object_list.selected_numbers == {1}


def test_delete_removes_the_line_that_was_just_drawn(drawing, hand) -> None:
    click_along(hand, 0.0, 1.0, 2.0)
    hand.key(KEY.Key_Return)
    assert len(accepted_items(drawing)) == 1
    hand.key(KEY.Key_Delete)
    assert accepted_items(drawing) == ()


def test_a_freehand_line_snaps_and_closes_where_it_began(drawing, hand) -> None:
    hand.drag(*(at(angle, RADIUS + 1.0) for angle in np.linspace(0.0, 2.0 * math.pi, 40)))
    (one,) = accepted_items(drawing)
    assert one.region.size == pytest.approx(AREA, rel=0.04)


def test_a_line_between_two_places_of_an_object_redraws_the_stretch(drawing, hand) -> None:
    click_along(hand, 0.0, 2.0, 4.0, 0.0)
    before = accepted_items(drawing)[0].region.size
    redraw_stretch(hand)
    (one,) = accepted_items(drawing)
    assert one.number == 1 and farthest(one) == pytest.approx(RADIUS + 8.0, abs=1.0)
    assert before < one.region.size < before + 60.0


def test_a_line_between_two_places_of_a_contour_makes_an_object_of_it_in_one_step(outlined, hand) -> None:
    redraw_stretch(hand)
    (one,) = accepted_items(outlined)
    assert farthest(one) == pytest.approx(RADIUS + 8.0, abs=1.0)
    (contour,) = outlined.session.scene.contours
    assert np.hypot(*(contour.points - CENTER).T).max() < RADIUS + 1.0, "the run is as it was"
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert accepted_items(outlined) == ()
