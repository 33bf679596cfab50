"""Filled areas on the canvas, cached until they change."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.item import OverImage, cached
from app.views.theme.look import look
from cpm_core.numerics.types import Array

_RIM = 4.0

Area = tuple[Sequence[Array], str, float]
"""Closed curves, each of shape (K, 2), with color and opacity; a place is inside if an odd number encloses it."""


class Fills(OverImage):
    """Translucent areas with holes; `z` is the place in the stack of layers."""

    def __init__(self, z: float) -> None:
        super().__init__(z, _RIM)
        self._areas: list[tuple[QPainterPath, str, float]] = []
        self.setVisible(False)
        cached(self)

    @property
    def count(self) -> int:
        """Number of areas."""
        return len(self._areas)

    @property
    def empty(self) -> bool:
        """Whether there are no areas."""
        return not self._areas

    def show(self, areas: Sequence[Area]) -> None:
        """Show areas, in the order in which they lie over each other."""
        if areas or self._areas:
            self._areas = [(_path(curves), color, opacity) for curves, color, opacity in areas]
            self.update()
            self.set_shown(self._shown)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the areas."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for path, color, opacity in self._areas:
            tint = QColor(look().color(color))
            tint.setAlphaF(opacity)
            painter.fillPath(path, tint)


def _path(curves: Sequence[Array]) -> QPainterPath:
    path = QPainterPath()
    for curve in curves:
        closed = np.concatenate([curve, curve[:1]])
        path.addPath(pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(closed))))
    path.setFillRule(Qt.FillRule.OddEvenFill)
    return path
