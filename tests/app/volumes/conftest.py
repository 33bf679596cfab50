"""Windows on small volumes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.views.main_window import MainWindow
from tests.app.conftest import Hand

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


def open_file(window: MainWindow, hand: Hand, path: Path) -> None:
    """Open a file, and wait for it."""
    window.open_image(str(path))
    hand.wait(lambda: window.session.document.image.name == path.name and window.session.idle)


@pytest.fixture
def volume(window: MainWindow, hand: Hand, volume_file: Path) -> MainWindow:
    """A window on the ball, with nothing drawn."""
    open_file(window, hand, volume_file)
    return window
