"""Windows on small volumes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from tests.app.conftest import Hand

Button = Qt.MouseButton

SHAPE = (24, 28, 32)


def ball(radius: float = 7.0, shape: tuple[int, ...] = SHAPE) -> np.ndarray:
    """A bright ball in the middle of a dark volume, with a slope of one voxel."""
    away = np.sqrt(sum((at - (side - 1) / 2) ** 2 for at, side in zip(np.indices(shape), shape, strict=True)))
    return np.round(20.0 + 180.0 * np.clip(radius + 0.5 - away, 0.0, 1.0))


@pytest.fixture
def volume_file(tmp_path: Path) -> Path:
    """A file with a small ball."""
    path = tmp_path / "ball.npy"
    np.save(path, ball().astype(np.uint8))
    return path


def send(view: ImageView, kind: QEvent.Type, at: tuple[float, float], button: Button, held: Button, *,
         keys: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:  # fmt: skip
    """A mouse event over a position of a view."""
    to = view.map_from_image(at)
    event = QMouseEvent(kind, to, QPointF(view.viewport().mapToGlobal(to.toPoint())), button, held, keys)
    QApplication.sendEvent(view.viewport(), event)


def press(view: ImageView, at: tuple[float, float], button: Button = Button.LeftButton) -> None:
    """A button of the mouse goes down over a position of a view."""
    send(view, QEvent.Type.MouseButtonPress, at, button, button)


def move(view: ImageView, at: tuple[float, float], held: Button = Button.LeftButton) -> None:
    """The pointer moves to a position of a view."""
    send(view, QEvent.Type.MouseMove, at, Button.NoButton, held)


def release(view: ImageView, at: tuple[float, float], button: Button = Button.LeftButton) -> None:
    """The button goes up again."""
    send(view, QEvent.Type.MouseButtonRelease, at, button, Button.NoButton)


def drag(view: ImageView, *places: tuple[float, float]) -> None:
    """A drag of the left button in a view."""
    press(view, places[0])
    for at in places[1:]:
        move(view, at)
    release(view, places[-1])


def open_file(window: MainWindow, hand: Hand, path: Path) -> None:
    """Open a file, and wait for it and for the views of it."""
    window.open_image(str(path))
    hand.wait(lambda: window.session.document.image.name == path.name and window.session.idle and window.turns.is_idle)
    hand.qtbot.wait(1)  # the docks are fitted after Qt has laid them out


@pytest.fixture
def volume(window: MainWindow, hand: Hand, volume_file: Path) -> MainWindow:
    """A window on the ball, with nothing drawn."""
    open_file(window, hand, volume_file)
    return window
