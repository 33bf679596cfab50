"""Conversions between positions (row, col) and points (x, y) of the canvas."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF

from cpm_core.numerics.types import Position


def to_xy(positions: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """X and y on the canvas of positions (row, col), shape (N, 2)."""
    return positions[:, 1], positions[:, 0]


def to_position(point: QPointF) -> Position:
    """Position (row, col) of a point on the canvas."""
    return (point.y(), point.x())


def image_rectangle(shape: tuple[int, ...]) -> QRectF:
    """Rectangle of an image on the canvas; it begins half a pixel before the center of the first pixel."""
    rows, cols = shape
    return QRectF(-0.5, -0.5, cols, rows)
