"""The brush for objects: what it goes over is added to an object or taken away from it, and nothing else changes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.document.objects import accept_objects
from PySide6.QtCore import Qt
from PySide6.QtGui import QCursor

from cpm_core.numerics import polyline
from tests.app.reading import accepted_items

pytestmark = pytest.mark.shared_window

KEY, SHIFT, CONTROL = Qt.Key, Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
ROW, COL = np.indices((64, 64))
PIXELS = np.stack([ROW, COL], axis=-1).reshape(-1, 2).astype(float)


@pytest.fixture
def brush(hand):
    """The tool in use."""
    hand.key(KEY.Key_J)
    assert hand.canvas.dispatcher.tool.name == "mend"
    return hand.canvas.dispatcher.tool


def stroke(hand, *places: tuple[float, float], away: bool = False, anew: bool = False) -> None:
    """A stroke through places; `away` with Shift held, `anew` with Ctrl."""
    modifier = SHIFT if away else CONTROL if anew else Qt.KeyboardModifier.NoModifier
    viewport, left = hand.canvas.viewport(), Qt.MouseButton.LeftButton
    hand.qtbot.mousePress(viewport, left, modifier, hand.at(*places[0]))
    for place in places[1:]:
        hand.move(*place)
    hand.qtbot.mouseRelease(viewport, left, modifier, hand.at(*places[-1]))


def near(path: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Distance of each pixel from a path."""
    if len(path) == 1:
        return np.hypot(ROW - path[0][0], COL - path[0][1])
    return polyline.distances_to_path(path, PIXELS).reshape(ROW.shape)


def differ(found: np.ndarray, expected: np.ndarray, edge: np.ndarray, tolerance: float = 0.6) -> int:
    """Pixels in which two masks differ, without those whose center lies at the edge of the brush."""
    return int(np.count_nonzero((found != expected) & (edge > tolerance)))


def test_a_stroke_beside_all_objects_paints_a_new_one_as_wide_as_the_ring(window, hand, brush) -> None:
    stroke(hand, (30, 20), (30, 30), (30, 40))
    (item,) = accepted_items(window)
    radius = brush.radius
    assert item.region.size == pytest.approx(2 * radius * 20 + math.pi * radius**2, rel=0.02)
    away = near(((30, 20), (30, 40)))
    assert differ(item.region.paste((64, 64)), away <= radius, np.abs(away - radius)) == 0
    assert window.workspace.object_list.selected_numbers == {item.number}
    assert window.session.document.shapes == ()
    assert window.actions_by_name["undo"].text() == "Undo paint object"
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert accepted_items(window) == ()


def test_a_stroke_from_an_object_adds_to_it_and_leaves_the_rest_of_its_boundary_as_it_was(window, hand, brush) -> None:
    stroke(hand, (20, 20), (20, 24))
    (before,) = accepted_items(window)
    stroke(hand, (20, 24), (20, 44))
    (after,) = accepted_items(window)
    assert after.number == before.number
    expected = near(((20, 20), (20, 44)))
    assert differ(after.region.paste((64, 64)), expected <= brush.radius, np.abs(expected - brush.radius)) == 0
    far = {corner for corner in before.region.boundary[0] if corner[1] < 19}
    assert len(far) > 10
    assert far <= set(after.region.boundary[0])


def test_a_painted_object_has_no_confidence_any_more(window, hand, brush) -> None:
    stroke(hand, (20, 20), (20, 24))
    (made,) = accepted_items(window)
    found = replace(made, confidence=0.9)
    window.session.edit("", lambda document: accept_objects(document, [found]))
    stroke(hand, (20, 24), (20, 44))
    assert [item.confidence for item in accepted_items(window)] == [0.0]


def test_the_selected_object_is_painted_wherever_a_stroke_begins_and_without_one_a_new_object_is(
    window, hand, brush
) -> None:
    stroke(hand, (12, 12), (12, 20))
    stroke(hand, (50, 40), (50, 50))
    (item,) = accepted_items(window)
    assert len(item.region.outer_curves) == 2
    assert item.region.encloses(np.array([(12.0, 16.0), (50.0, 45.0)])).all()
    hand.key(KEY.Key_Escape)
    stroke(hand, (30, 12), (30, 20))
    assert [each.number for each in accepted_items(window)] == [1, 2]
    assert accepted_items(window)[0] == item
    window.workspace.object_list.select_objects((1,))
    stroke(hand, (30, 60), away=True)
    stroke(hand, (30, 12), away=True)
    assert accepted_items(window)[0] == item
    assert accepted_items(window)[1].region.encloses(np.array([(30.0, 12.0)])).all(), (
        "only the selected one is erased from"
    )


def test_a_stroke_does_not_run_over_other_objects_unless_they_may_overlap(window, hand, brush) -> None:
    stroke(hand, (30, 20), (30, 30))
    stroke(hand, (20, 30), (44, 30), anew=True)
    first, second = (item.region.paste((64, 64)) for item in accepted_items(window))
    assert not (first & second).any()
    assert second[20, 30] and second[44, 30]
    hand.key(KEY.Key_Escape)
    steps = window.session.history.undo_name
    hand.move(30, 22)
    assert hand.canvas.viewport().cursor().shape() == Qt.CursorShape.ForbiddenCursor
    stroke(hand, (30, 22), (30, 24))
    assert (len(accepted_items(window)), window.session.history.undo_name) == (2, steps)
    assert "belongs to object 1" in window.canvas_area.messages.text
    window.actions_by_name["objects_overlap"].trigger()
    stroke(hand, (30, 22), (30, 24))
    assert (accepted_items(window)[2].region.paste((64, 64)) & first).any()
    window.workspace.object_list.select_objects((1,))
    window.workspace.object_commands.toggle_state("frozen")
    hand.key(KEY.Key_Escape)
    stroke(hand, (30, 22), (30, 24))
    assert len(accepted_items(window)) == 3
    assert "frozen" in window.canvas_area.messages.text


def test_a_new_object_may_be_painted_inside_another_one(window, hand, brush) -> None:
    stroke(hand, (20, 20), (20, 44), (44, 44), (44, 20), (32, 32))
    for _ in range(6):
        hand.key(KEY.Key_BracketLeft)
    stroke(hand, (20, 30), (20, 32), anew=True)
    outer, inner = (item.region.paste((64, 64)) for item in accepted_items(window))
    assert inner.any() and (inner & outer).sum() == inner.sum()


def test_with_alt_the_brush_takes_away_makes_holes_and_parts_an_object_in_two(window, hand, brush) -> None:
    for _ in range(4):
        hand.key(KEY.Key_BracketRight)
    large = brush.radius
    stroke(hand, (30, 20), (30, 44))
    for _ in range(8):
        hand.key(KEY.Key_BracketLeft)
    small = brush.radius
    assert small < large / 2
    stroke(hand, (30, 32), away=True)
    (item,) = accepted_items(window)
    assert len(item.region.boundary) == 2
    assert item.region.size == pytest.approx(2 * large * 24 + math.pi * (large**2 - small**2), rel=0.02)
    stroke(hand, (15, 32), (45, 32), away=True)
    (item,) = accepted_items(window)
    assert len(item.region.outer_curves) == 2
    whole, cut = near(((30, 20), (30, 44))), near(((15, 32), (45, 32)))
    edge = np.minimum(np.abs(whole - large), np.abs(cut - small))
    assert differ(item.region.paste((64, 64)), (whole <= large) & (cut > small), edge) == 0


def test_escape_in_a_stroke_brings_the_objects_back(window, hand, brush) -> None:
    stroke(hand, (20, 20), (20, 30))
    before = window.session.document
    hand.press(20, 30)
    hand.move(40, 30)
    assert window.session.document != before
    hand.qtbot.keyClick(hand.canvas, KEY.Key_Escape)
    hand.release(40, 30)
    assert accepted_items(window) == before.objects.items
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert accepted_items(window) == ()


def test_enter_and_arrow_keys_paint_and_with_alt_take_away(window, hand, brush) -> None:
    hand.canvas.setFocus()
    QCursor.setPos(hand.canvas.viewport().mapToGlobal(hand.at(32.0, 32.0)))
    hand.key(KEY.Key_Return)  # shows the cross-hair under the pointer
    hand.key(KEY.Key_Return)
    for _ in range(5):
        hand.key(KEY.Key_Right)
    hand.key(KEY.Key_Return)
    (item,) = accepted_items(window)
    rows, cols = np.ptp(np.concatenate([np.array(curve) for curve in item.region.boundary]), axis=0)
    assert rows == pytest.approx(2 * brush.radius, rel=0.02)
    assert cols > rows + 2
    hand.key(KEY.Key_Return, SHIFT)
    hand.key(KEY.Key_Return)
    (less,) = accepted_items(window)
    assert less.region.size < item.region.size - 0.9 * math.pi * brush.radius**2 / 2
