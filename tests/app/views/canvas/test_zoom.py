"""The zoom: shown in percent, within bounds, around the pointer."""

from __future__ import annotations

import re

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

pytestmark = pytest.mark.shared_window


def test_the_status_bar_shows_the_zoom_in_percent(window, hand) -> None:
    hand.canvas.zoom_to(2.5)
    assert window.zoom_readout.text() == "Zoom 250 %"
    hand.canvas.zoom_to(0.5)
    assert window.zoom_readout.text() == "Zoom 50 %"


def test_the_wheel_keeps_what_is_under_the_pointer(window, hand) -> None:
    place = QPointF(hand.canvas.map_from_image((20.0, 12.0)).toPoint())
    before = hand.canvas.map_to_image(place)
    for _ in range(5):
        event = QWheelEvent(
            place, hand.canvas.mapToGlobal(place), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(hand.canvas.viewport(), event)
    assert hand.canvas.map_to_image(place) == pytest.approx(before, abs=0.2)


def test_the_zoom_stays_within_bounds(window, hand) -> None:
    for factor in (1e9, 1e-9):
        hand.canvas.zoom_by(factor)
        assert 0.0099 <= hand.canvas.magnification <= 64.1


def test_the_status_bar_tells_the_pixel_of_the_present_image(window, hand, tmp_path) -> None:
    hand.move(20.0, 20.0)
    assert "row 20" in window.pointer_readout.text()
    np.save(tmp_path / "other.npy", np.eye(48))
    window.session.open_file(tmp_path / "other.npy")
    hand.wait(lambda: window.session.document.image.name == "other.npy")
    row, col = (int(word) for word in re.findall(r"\d+", window.pointer_readout.text())[:2])
    assert window.pointer_readout.text() == f"row {row}, col {col}:  {float(row == col):g}"
    assert max(row, col) < 48
