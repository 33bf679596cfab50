"""Contours edited by hand with pointer and keys, on the outline of a disk whose area is known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt

from cpm_core.formats.sessions.session_file import load_session
from tests.app.conftest import Hand

pytestmark = pytest.mark.shared_window

KEY, SHIFT = Qt.Key, Qt.KeyboardModifier.ShiftModifier
CONTROL = Qt.KeyboardModifier.ControlModifier
CENTER, RADIUS = (32.0, 32.0), 18.0
AREA = math.pi * RADIUS**2


def at(angle: float, radius: float = RADIUS) -> tuple[float, float]:
    return CENTER[0] + radius * math.sin(angle), CENTER[1] + radius * math.cos(angle)


def settle(window: MainWindow, hand: Hand) -> None:
    """Wait until the contours shown are those of the document."""
    hand.wait(lambda: window.session.idle)


def contours(window: MainWindow):
    return [item.contour for item in window.workspace.review.items]


@pytest.fixture
def outlined(ready: MainWindow, hand: Hand) -> MainWindow:
    """The disk with its closed contour, and the edges at hand."""
    ready.canvas_area.use_tool("mend")
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.workspace.hand_editing.edges is not None)
    settle(ready, hand)
    assert [contour.closed for contour in contours(ready)] == [True]
    return ready


@pytest.fixture
def gap(outlined: MainWindow, hand: Hand) -> MainWindow:
    """The same with a stretch between two clicks deleted."""
    hand.click(*at(-0.5))
    hand.click(*at(0.5))
    hand.key(KEY.Key_Delete)
    settle(outlined, hand)
    return outlined


def preview(hand: Hand) -> np.ndarray:
    """Places (row, col) of the line that shows what a release would do, shape (K, 2)."""
    x, y = hand.canvas.layers.drawing._draft.path.getData()
    return np.empty((0, 2)) if x is None else np.stack([y, x], axis=1)


def test_delete_removes_the_stretch_between_two_clicks(gap, hand) -> None:
    (rest,) = contours(gap)
    assert not rest.closed and rest.length == pytest.approx((2.0 * math.pi - 1.0) * RADIUS, rel=0.05)
    assert np.linalg.norm(rest.points - at(0.0), axis=1).min() > 6.0


def test_a_drag_from_end_to_end_closes_the_contour_along_the_edge(gap, hand) -> None:
    hand.press(*at(0.5))
    for angle in (0.3, 0.1, -0.2, -0.5):
        hand.move(*at(angle))
    shown = preview(hand)
    assert np.linalg.norm(shown - at(0.0), axis=1).min() < 1.0, "the line follows the edge before the button is let go"
    hand.release(*at(-0.5))
    settle(gap, hand)
    (closed,) = contours(gap)
    assert closed.closed and closed.area == pytest.approx(AREA, rel=0.04)
    assert closed.length_by_hand == pytest.approx(RADIUS, rel=0.1)
    assert len(preview(hand)) == 0
    assert hand.canvas.layers.contours.by_hand.count == 1
    assert gap.session.history.undo_name == "join contours"


def test_merging_open_contours_joins_them(gap, hand) -> None:
    hand.qtbot.mouseClick(hand.canvas.viewport(), Qt.MouseButton.LeftButton, SHIFT, hand.at(*at(math.pi)))
    settle(gap, hand)
    assert len(contours(gap)) == 2
    hand.click(*at(2.0))
    hand.qtbot.mouseClick(hand.canvas.viewport(), Qt.MouseButton.LeftButton, CONTROL, hand.at(*at(-2.0)))
    assert len(gap.workspace.review.selected_keys) == 2
    hand.key(KEY.Key_M)
    settle(gap, hand)
    assert len(contours(gap)) == 1 and not contours(gap)[0].closed


def test_closing_waits_for_the_edges_and_is_done_once(gap, hand) -> None:
    hand.click(*at(math.pi))
    editing = gap.workspace.hand_editing
    editing._on_image_changed()
    for _ in range(2):
        hand.key(KEY.Key_C, SHIFT)
    assert len(gap.session.document.hand_edits) == 1
    hand.wait(lambda: editing.edges is not None)
    settle(gap, hand)
    assert len(gap.session.document.hand_edits) == 2 and contours(gap)[0].closed
    assert not gap.canvas_area.messages.text


def test_undo_takes_edits_back_one_by_one_and_redo_brings_them_again(gap, hand) -> None:
    hand.click(*at(math.pi))
    hand.key(KEY.Key_C, SHIFT)
    closed = []
    for step in (gap.session.undo, gap.session.undo, gap.session.redo, gap.session.redo):
        settle(gap, hand)
        closed.append(contours(gap)[0].closed)
        step()
    settle(gap, hand)
    assert [*closed, contours(gap)[0].closed] == [True, False, True, False, True]
    assert len(contours(gap)) == 1


def test_a_click_with_shift_cuts(outlined, hand) -> None:
    hand.move(*at(1.0))
    assert "Shift-click to cut" in outlined.canvas_area.strip.hint.text()
    hand.qtbot.mouseClick(hand.canvas.viewport(), Qt.MouseButton.LeftButton, SHIFT, hand.at(*at(1.0)))
    settle(outlined, hand)
    (one,) = contours(outlined)
    assert not one.closed and np.linalg.norm(one.points[[0, -1]] - at(1.0), axis=1).max() < 1.0
    hand.qtbot.mouseClick(hand.canvas.viewport(), Qt.MouseButton.LeftButton, SHIFT, hand.at(*at(3.0)))
    settle(outlined, hand)
    lengths = [contour.length for contour in contours(outlined)]
    assert lengths == pytest.approx([(2.0 * math.pi - 2.0) * RADIUS, 2.0 * RADIUS], rel=0.05)


def test_a_stretch_is_pulled_and_with_shift_not_snapped(outlined, hand) -> None:
    hand.press(*at(0.0))
    hand.qtbot.keyPress(hand.canvas, KEY.Key_Shift)
    hand.canvas.dispatcher.set_modifiers(SHIFT)
    hand.canvas.move_pointer_to(at(0.0, RADIUS + 3.0))
    hand.canvas.move_pointer_to(at(0.0, RADIUS + 6.0))
    assert np.linalg.norm(preview(hand) - at(0.0, RADIUS + 6.0), axis=1).min() < 0.5
    hand.canvas.dispatcher.release_button()
    settle(outlined, hand)
    (one,) = contours(outlined)
    assert one.closed and np.hypot(*(one.points - CENTER).T).max() == pytest.approx(RADIUS + 6.0, abs=0.6)
    hand.canvas.dispatcher.set_modifiers(Qt.KeyboardModifier.NoModifier)
    hand.press(*at(0.0, RADIUS + 6.0))
    hand.move(*at(0.0, RADIUS + 3.0))
    hand.move(*at(0.0, RADIUS + 1.0))
    hand.release(*at(0.0, RADIUS + 1.0))
    settle(outlined, hand)
    (one,) = contours(outlined)
    assert one.closed and one.area == pytest.approx(AREA, rel=0.04), "it snaps back to the edge"


def test_edits_are_carried_out_again_after_another_run(gap, hand) -> None:
    hand.click(*at(math.pi))
    hand.key(KEY.Key_Escape)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: gap.session.status.phase == "running")
    hand.wait_for_phase("finished")
    settle(gap, hand)
    (rest,) = contours(gap)
    assert not rest.closed and np.linalg.norm(rest.points - at(0.0), axis=1).min() > 6.0
    assert gap.workspace.hand_editing.unmatched_edits == ()


def draw_outline(hand: Hand) -> None:
    for angle in (0.0, 2.0, 4.0, 0.0):
        hand.move(*at(angle))
        hand.click(*at(angle))


def test_an_outline_along_the_edge_is_an_object_before_any_run(window, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_U)
    hand.wait(lambda: window.workspace.hand_editing.edges is not None)
    draw_outline(hand)
    (one,) = window.session.document.objects.items
    assert one.area == pytest.approx(AREA, rel=0.04) and one.measure_gap_length() < 3.0
    assert window.workspace.object_list.selected_numbers == {1}
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert window.session.document.objects.items == () and contours(window) == []


def test_an_outline_between_two_places_of_a_contour_redraws_the_stretch(outlined, hand) -> None:
    hand.key(KEY.Key_U)
    hand.click(*at(-0.4))
    hand.canvas.dispatcher.set_modifiers(SHIFT)
    hand.canvas.dispatcher.press_button(hand.canvas, at(0.0, RADIUS + 8.0))
    hand.canvas.dispatcher.release_button()
    hand.canvas.move_pointer_to(at(0.4))
    hand.canvas.dispatcher.set_modifiers(Qt.KeyboardModifier.NoModifier)
    hand.canvas.dispatcher.press_button(hand.canvas, at(0.4))
    hand.canvas.dispatcher.release_button()
    hand.key(KEY.Key_Return)
    settle(outlined, hand)
    (one,) = contours(outlined)
    assert one.closed and np.hypot(*(one.points - CENTER).T).max() == pytest.approx(RADIUS + 8.0, abs=1.0)


def test_a_freehand_outline_snaps_and_closes_where_it_began(window, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_U)
    hand.wait(lambda: window.workspace.hand_editing.edges is not None)
    hand.drag(*(at(angle, RADIUS + 1.0) for angle in np.linspace(0.0, 2.0 * math.pi, 40)))
    (one,) = window.session.document.objects.items
    assert one.area == pytest.approx(AREA, rel=0.04)


def test_edits_by_hand_are_saved_and_come_back(gap, hand, tmp_path: Path) -> None:
    path = tmp_path / "work.cpm"
    edits = gap.session.document.hand_edits
    assert gap.get_feature(OpenSaveFeature).document_file.save_and_wait(path)
    assert load_session(path).hand_edits == edits
    shown = gap.workspace.review.result
    gap.session.open_file(path)
    hand.wait(lambda: gap.session.idle and gap.workspace.review.result not in (None, shown))
    assert gap.session.document.hand_edits == edits
    settle(gap, hand)
    assert [contour.closed for contour in contours(gap)] == [False]
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    settle(gap, hand)
    assert [contour.closed for contour in contours(gap)] == [False]
