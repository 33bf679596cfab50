"""Pens and caching for items on the canvas."""

from __future__ import annotations

from PySide6.QtGui import QColor, QPen
from PySide6.QtWidgets import QGraphicsItem


def line_pen(colour: str, width: float) -> QPen:
    """A pen whose width does not change with the zoom."""
    pen = QPen(QColor(colour), width)
    pen.setCosmetic(True)
    return pen


def cached(item: QGraphicsItem) -> None:
    """Keep what an item looks like until it changes, for what lies above it changes much more often."""
    item.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)
