"""The zoom: shown in percent, chosen, typed, and fitted to what is selected."""

from __future__ import annotations

import re

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CTRL = Qt.KeyboardModifier.ControlModifier


def test_a_zoom_can_be_typed_and_the_canvas_has_the_keyboard_again(window, hand, qtbot) -> None:
    field = window.zoom_field
    qtbot.mouseClick(field.lineEdit(), Qt.MouseButton.LeftButton)
    field.lineEdit().selectAll()
    qtbot.keyClicks(field.lineEdit(), "250")
    qtbot.keyClick(field.lineEdit(), KEY.Key_Return)
    assert hand.canvas.magnification == pytest.approx(2.5)
    assert field.currentText() == "250 %"
    assert hand.canvas.hasFocus()
    qtbot.mouseClick(field.lineEdit(), Qt.MouseButton.LeftButton)
    qtbot.keyClicks(field.lineEdit(), "9")
    qtbot.keyClick(field.lineEdit(), KEY.Key_Escape)
    assert hand.canvas.magnification == pytest.approx(2.5)
    assert field.currentText() == "250 %"


def test_the_wheel_keeps_what_is_under_the_pointer(window, hand) -> None:
    place = QPointF(hand.canvas.point((20.0, 12.0)).toPoint())
    before = hand.canvas.position(place)
    for _ in range(5):
        event = QWheelEvent(
            place, hand.canvas.mapToGlobal(place), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(hand.canvas.viewport(), event)
    assert hand.canvas.position(place) == pytest.approx(before, abs=0.2)


def test_the_zoom_stays_within_bounds(window, hand) -> None:
    for factor in (1e9, 1e-9):
        hand.canvas.zoom(factor)
        assert 0.0099 <= hand.canvas.magnification <= 64.1


def test_the_selection_can_fill_the_canvas_by_key_and_by_a_double_click_in_the_table(ready, hand, qtbot) -> None:
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle and bool(ready.workspace.review.items))
    item = ready.workspace.review.items[0]
    low, high = item.contour.points.min(axis=0), item.contour.points.max(axis=0)

    def fills() -> bool:
        seen = hand.canvas.view.viewRect()
        inside = seen.left() < low[1] and seen.right() > high[1] and seen.top() < low[0] and seen.bottom() > high[0]
        return inside and seen.height() < 1.6 * float(np.max(high - low))

    hand.canvas.zoom_to(1.0)
    assert not fills()
    ready.workspace.review.select((item.key,))
    hand.key(KEY.Key_F, Qt.KeyboardModifier.ShiftModifier)
    assert fills()
    hand.canvas.zoom_to(1.0)
    hand.key(KEY.Key_T, CTRL)
    table = ready.panels["contours"].table
    hand.wait(lambda: table.isVisible() and table.model().rowCount() > 0)
    spot = table.visualRect(table.model().index(0, 0)).center()
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=spot)
    qtbot.mouseDClick(table.viewport(), Qt.MouseButton.LeftButton, pos=spot)
    assert fills()


def test_the_status_bar_tells_the_pixel_of_the_present_image(window, hand, tmp_path) -> None:
    hand.move(20.0, 20.0)
    assert "row 20" in window.pointer_readout.text()
    np.save(tmp_path / "other.npy", np.eye(48))
    window.session.open(tmp_path / "other.npy")
    hand.wait(lambda: window.session.document.image.name == "other.npy")
    row, col = (int(word) for word in re.findall(r"\d+", window.pointer_readout.text())[:2])
    assert window.pointer_readout.text() == f"row {row}, col {col}:  {float(row == col):g}"
    assert max(row, col) < 48
