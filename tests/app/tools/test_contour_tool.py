"""The contour tool: clicks, frames and strokes select contours; Shift adds, Ctrl removes, Esc cancels."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from app.model.document import edits
from app.views.window.window import MainWindow
from cpm_core.shapes import Grid
from tests.app.conftest import Hand

pytestmark = pytest.mark.shared_window

KEY, LEFT = Qt.Key, Qt.MouseButton.LeftButton
SHIFT, CONTROL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
ALT, NONE = Qt.KeyboardModifier.AltModifier, Qt.KeyboardModifier.NoModifier
PLACES = [(20, 20), (20, 60), (20, 100), (60, 20), (60, 60), (60, 100)]


@pytest.fixture
def found(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window in which six discs have been found, and the contour tool is in use."""
    row, col = np.indices((84, 124))
    values = np.full(row.shape, 20.0)
    for place in PLACES:
        values[np.hypot(row - place[0], col - place[1]) < 11] = 180.0
    path = tmp_path / "discs.npy"
    np.save(path, values)
    session = window.session
    session.open(path)
    hand.wait(lambda: session.document.image is not None and session.document.image.name == "discs.npy")
    whole = Grid(((2.0, 2.0), (2.0, 121.0), (81.0, 121.0), (81.0, 2.0)))
    session.edit("draw", lambda document: edits.add_shape(document, whole))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    assert len(window.workspace.review.items) == 6
    hand.key(KEY.Key_V)
    return window


def drag(hand: Hand, *places: tuple[float, float], held: Qt.KeyboardModifier = NONE, release: bool = True) -> None:
    view = hand.canvas.viewport()
    hand.qtbot.mousePress(view, LEFT, held, hand.at(*places[0]))
    for start, end in pairwise(places):
        for share in (0.5, 1.0):
            at = tuple(np.array(start) + share * (np.array(end) - start))
            move(hand, at, held)
    if release:
        hand.qtbot.mouseRelease(view, LEFT, held, hand.at(*places[-1]))


def move(hand: Hand, at: tuple[float, ...], held: Qt.KeyboardModifier) -> None:
    """A move of the pointer with modifier keys, which `qtbot.mouseMove` cannot hold."""
    view, place = hand.canvas.viewport(), hand.at(*at)
    kind, on_screen = QMouseEvent.Type.MouseMove, view.mapToGlobal(place).toPointF()
    event = QMouseEvent(kind, place.toPointF(), on_screen, Qt.MouseButton.NoButton, LEFT, held)
    QApplication.sendEvent(view, event)


def selected(window: MainWindow) -> set[tuple[int, int]]:
    centers = [np.mean(item.contour.points, axis=0) for item in window.workspace.review.chosen]
    return {min(PLACES, key=lambda place: float(np.hypot(*(center - place)))) for center in centers}


@pytest.mark.parametrize("removing", [CONTROL, ALT])
def test_a_frame_selects_what_lies_in_it_shift_adds_and_ctrl_or_alt_removes(found, hand, removing) -> None:
    drag(hand, (3.0, 3.0), (40.0, 80.0))
    assert selected(found) == {(20, 20), (20, 60)}
    drag(hand, (40.0, 80.0), (3.0, 118.0), held=SHIFT)
    assert selected(found) == {(20, 20), (20, 60), (20, 100)}
    drag(hand, (3.0, 40.0), (40.0, 80.0), held=removing)
    assert selected(found) == {(20, 20), (20, 100)}
    drag(hand, (40.0, 3.0), (80.0, 40.0))
    assert selected(found) == {(60, 20)}
    assert hand.canvas.layers.contours._chosen.count == 1


def test_a_drag_from_a_contour_selects_all_that_it_crosses(found, hand) -> None:
    drag(hand, (20.0, 31.0), (20.0, 60.0), (60.0, 60.0))
    assert selected(found) == {(20, 20), (20, 60), (60, 60)}
    drag(hand, (60.0, 49.0), (60.0, 60.0), held=CONTROL)
    assert selected(found) == {(20, 20), (20, 60)}
    drag(hand, (60.0, 89.0), (60.0, 96.0), held=SHIFT)
    assert selected(found) == {(20, 20), (20, 60), (60, 100)}


@pytest.mark.parametrize("removing", [CONTROL, ALT])
def test_a_click_removes_a_contour_and_one_away_from_all_of_them_clears_the_selection(found, hand, removing) -> None:
    drag(hand, (3.0, 3.0), (80.0, 118.0))
    assert len(selected(found)) == 6
    drag(hand, (20.0, 31.0), held=removing)
    assert selected(found) == {*PLACES} - {(20, 20)}
    drag(hand, (40.0, 40.0), held=SHIFT)
    assert len(selected(found)) == 5
    drag(hand, (40.0, 40.0))
    assert selected(found) == set()
