"""The tool that mends: what it will do is said before the press, on outlines of objects, contours and elsewhere."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QCursor

from cpm_core.contours.contour import Contour
from cpm_core.image.region import Region
from cpm_core.objects.segmented import SegmentedObject
from tests.app.conftest import show_contours

pytestmark = pytest.mark.shared_window

KEY, CONTROL, SHIFT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
CENTER, TRUE, DRAWN = (32.0, 32.0), 18.0, 23.0
"""The object is drawn larger than the disk in the image."""


def at(angle: float, radius: float) -> tuple[float, float]:
    return CENTER[0] + radius * math.sin(angle), CENTER[1] + radius * math.cos(angle)


@pytest.fixture
def mended(window, hand):
    """An object whose boundary lies next to the edge, an open contour of a run in a corner, and the tool in use."""
    ring = tuple(at(0.05 * math.pi * k, DRAWN) for k in range(40))
    bone = SegmentedObject(1, (), Region((ring,)), name="bone")
    window.session.edit("bone", lambda d: replace(d, objects=replace(d.objects, items=(bone,))))
    show_contours(window, Contour(np.array([(3.0, float(col)) for col in range(4, 16)]), False))
    hand.canvas.setFocus()
    hand.key(KEY.Key_J)
    hand.move(32, 32)
    hand.wait(lambda: window.workspace.outline_editing.edges is not None and window.session.idle)
    return window


def bone(window) -> SegmentedObject:
    return window.session.document.objects[1]


def radii(item: SegmentedObject) -> np.ndarray:
    (curve,) = item.region.boundary
    return np.hypot(*(np.array(curve) - CENTER).T)


def shape(hand) -> Qt.CursorShape:
    return hand.canvas.viewport().cursor().shape()


def ring(hand) -> np.ndarray:
    """The line of the ring, shape (2, K)."""
    x, y = hand.canvas.layers.drawing._draft._ring.getData()
    return np.empty((2, 0)) if x is None else np.stack([y, x])


def test_words_and_pointer_say_before_a_press_what_it_will_do(mended, hand) -> None:
    words = mended.canvas_area.strip.hint
    for place, said, alone, pointer in (
        (at(0.0, DRAWN), "pull the boundary of bone", "bend the boundary of bone", Qt.CursorShape.OpenHandCursor),
        ((3, 9), "becomes an object", "becomes an object", Qt.CursorShape.OpenHandCursor),
        ((32, 32), "belongs to bone: select it", "erase from bone", Qt.CursorShape.ForbiddenCursor),
        ((60, 3), "paint a new object", "over an object", Qt.CursorShape.CrossCursor),
        ("select", "", "", None),
        ((32, 32), "add to bone", "erase from bone", Qt.CursorShape.CrossCursor),
        ((60, 3), "add to bone", "erase from bone", Qt.CursorShape.CrossCursor),
    ):
        if place == "select":
            mended.workspace.object_list.select_objects((1,))
            continue
        hand.move(*place)
        assert said in words.text()
        assert shape(hand) == pointer
        hand.qtbot.keyPress(hand.canvas, KEY.Key_Shift)
        assert alone in words.text(), "without a move of the pointer"
        if pointer == Qt.CursorShape.ForbiddenCursor:
            assert shape(hand) == Qt.CursorShape.CrossCursor
        hand.qtbot.keyRelease(hand.canvas, KEY.Key_Shift)
        assert said in words.text()
    hand.qtbot.keyPress(hand.canvas, KEY.Key_Control)
    assert words.text().startswith("Drag to paint a new object")
    hand.qtbot.keyRelease(hand.canvas, KEY.Key_Control)
    assert "add to bone" in words.text()
    center, reach = ring(hand).mean(axis=1), np.ptp(ring(hand), axis=1) / 2
    assert center == pytest.approx((60, 3), abs=0.5)
    assert reach == pytest.approx(2 * [mended.workspace.object_brush.radius], rel=0.02), "the brush in its true size"


def test_a_boundary_is_pulled_onto_the_edge_in_one_step_of_undo(mended, hand) -> None:
    hand.drag(at(0.0, DRAWN), at(0.0, 21.0), at(0.0, 19.0))
    item = bone(mended)
    assert radii(item).min() == pytest.approx(TRUE, abs=0.7)
    assert radii(item).max() == pytest.approx(DRAWN, abs=0.3), "the rest of it stays"
    by_hand = np.concatenate([np.array(gap) for gap in item.gaps])
    assert np.median(np.hypot(*(by_hand - CENTER).T)) > TRUE + 1.0, "what follows the edge is no gap"
    assert mended.session.history.undo_name == "redraw boundary of bone"
    hand.key(KEY.Key_Z, CONTROL)
    assert radii(bone(mended)) == pytest.approx(DRAWN)


def test_with_shift_it_bends_and_what_is_bent_is_a_gap(mended, hand) -> None:
    viewport, left = hand.canvas.viewport(), Qt.MouseButton.LeftButton
    hand.qtbot.mousePress(viewport, left, SHIFT, hand.at(*at(1.0, DRAWN)))
    for radius in (25.0, 28.0):
        hand.qtbot.keyPress(hand.canvas, KEY.Key_Shift)
        hand.canvas.move_pointer_to(at(1.0, radius))
    hand.qtbot.mouseRelease(viewport, left, SHIFT, hand.at(*at(1.0, 28.0)))
    item = bone(mended)
    assert radii(item).max() == pytest.approx(28.0, abs=0.5)
    assert len(item.gaps) == 1 and len(item.gaps[0]) > 10


def test_a_frozen_object_is_not_pulled_and_a_click_chooses(mended, hand) -> None:
    hand.click(*at(0.0, DRAWN))
    assert mended.workspace.object_list.selected_numbers == {1}
    mended.workspace.object_commands.toggle_state("frozen")
    hand.drag(at(0.0, DRAWN), at(0.0, 21.0), at(0.0, 19.0))
    assert radii(bone(mended)) == pytest.approx(DRAWN)
    assert "frozen" in mended.canvas_area.messages.text


def test_away_from_lines_it_paints_and_keys_do_the_same(mended, hand) -> None:
    before = bone(mended).region.size
    mended.workspace.object_list.select_objects((1,))
    hand.drag((32, 32), (32, 50), (32, 58))
    assert bone(mended).region.size > before + 5
    QCursor.setPos(mended.mapToGlobal(QPoint(2, 2)))
    mended.actions_by_name["cross_hair"].trigger()
    crosshair = mended.canvas_area.crosshair
    crosshair.move_by(*(np.array(at(-2.0, DRAWN)) - crosshair.position))
    hand.key(KEY.Key_Return)
    crosshair.move_by(*(np.array(at(-2.0, TRUE + 1)) - crosshair.position))
    hand.key(KEY.Key_Return)
    assert radii(bone(mended)).min() == pytest.approx(TRUE, abs=1.0), "pulled by keys"
    hand.key(KEY.Key_Escape)
    size = mended.workspace.object_brush.radius
    hand.key(KEY.Key_BracketRight)
    assert mended.workspace.object_brush.radius == pytest.approx(1.2 * size)


def test_a_contour_that_is_pulled_becomes_an_object_in_one_step_and_the_run_stays(mended, hand) -> None:
    hand.drag((3, 9), (5, 9), (7, 9))
    _, line = mended.session.document.objects.items
    assert line.region.size == 0.0 and np.array(line.line)[:, 0].max() == pytest.approx(7.0, abs=1.0)
    np.testing.assert_allclose(np.array(line.line)[[0, -1]], [(3.0, 4.0), (3.0, 15.0)], atol=1.5)
    (contour,) = mended.session.scene.contours
    assert (contour.points[:, 0] == 3.0).all()
    hand.key(KEY.Key_Z, CONTROL)
    assert [item.name for item in mended.session.document.objects.items] == ["bone"]


def test_a_click_on_a_contour_selects_it_and_enter_makes_an_open_object_that_can_be_pulled(mended, hand) -> None:
    hand.click(3, 9)
    assert mended.session.scene.selected_contours == {0}
    hand.key(KEY.Key_Return)
    _, line = mended.session.document.objects.items
    assert line.measure_perimeter() == pytest.approx(11.0)
    hand.drag((3, 9), (5, 9), (7, 9))
    _, pulled = mended.session.document.objects.items
    assert pulled.number == line.number and pulled.measure_perimeter() > 13.0


def test_a_contour_in_hand_is_pulled_even_if_the_run_has_others_meanwhile(mended, hand) -> None:
    hand.press(3, 9)
    hand.move(5, 9)
    show_contours(mended)
    hand.move(7, 9)
    hand.release(7, 9)
    _, line = mended.session.document.objects.items
    assert np.array(line.line)[:, 0].max() == pytest.approx(7.0, abs=1.0)
