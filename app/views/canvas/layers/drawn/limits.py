"""Limits of the particles: regions of interest, dimmed outside, and barriers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.item import OverImage, cached
from app.views.theme import theme
from cpm_core.numerics.types import Array
from cpm_core.shapes import Barrier, Limit, Region

_DIM_Z, _LINE_Z = 2.5, 6.5
"""Places in the stack: the veil lies below particles and contours, the lines above them."""


class Limits:
    """Regions of interest and barriers of a document; also visible during a run, because they always act."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._dim = Dim()
        self._regions = Curves(theme.REGION, _LINE_Z, width=1.8, kind="shapes")
        self._barriers = Curves(theme.BARRIER, _LINE_Z + 0.1, width=3.6, halo=5.6, kind="shapes")
        self._chosen = Curves(theme.CHOSEN, _LINE_Z + 0.2, width=1.8, halo=0.0, kind="shapes")
        self._lines = (self._regions, self._barriers, self._chosen)
        for item in (self._dim, *self._lines):
            view.addItem(item, ignoreBounds=True)

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Cover an image of this shape."""
        self._dim.use_shape(shape)
        for item in self._lines:
            item.use_shape(shape, rim=float(max(shape)))

    def show(self, limits: list[Limit], chosen: Limit | None) -> None:
        """Show limits, one of them as selected."""
        regions = [limit for limit in limits if isinstance(limit, Region)]
        barriers = [limit for limit in limits if isinstance(limit, Barrier)]
        self._dim.show(regions)
        self._regions.show(_outlines(regions))
        self._barriers.show(_outlines(barriers))
        self._chosen.show(_outlines([] if chosen is None else [chosen]))

    def set_visible(self, visible: bool) -> None:
        """Show or hide all items."""
        for item in (self._dim, *self._lines):
            item.set_shown(visible)


class Dim(OverImage):
    """A veil over the image outside the regions of interest."""

    def __init__(self) -> None:
        super().__init__(_DIM_Z, 0.0)
        self._veil = QPainterPath()
        self.setVisible(False)
        cached(self)

    def show(self, regions: list[Region]) -> None:
        """Dim everything outside the regions; without regions, nothing."""
        if not regions and self._veil.isEmpty():
            return
        self._veil = QPainterPath()
        if regions:
            self._veil.addRect(self._room)
            for outline in _outlines(regions):
                inside = pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(outline)))
                # A path that crosses itself has no holes: with this rule, all that it winds around is inside.
                inside.setFillRule(Qt.FillRule.WindingFill)
                self._veil = self._veil.subtracted(inside)
        self.update()
        self.set_shown(self._shown)

    @property
    def empty(self) -> bool:
        """Whether nothing is dimmed."""
        return self._veil.isEmpty()

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the veil."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillPath(self._veil, QColor(theme.DIMMED))


def _outlines(limits: Sequence[Limit]) -> list[Array]:
    """The lines of limits; a region that lies in other slices of a volume has none."""
    return [np.array(limit.outline) for limit in limits if len(limit.outline)]
