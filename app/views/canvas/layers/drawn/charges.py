"""Placed charges: discs with a plus or a minus, and rings that show how far they act."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QBrush, QColor, QPainterPath, QPen

from app.model.volume.shape_sections import ChargeSection
from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.item import Markers
from app.views.theme import theme
from cpm_core.field.placed_charges import RADIUS, REACH
from cpm_core.shapes import Charge, Circle

_Z = 7.6
_DISC, _STRONGER, _SIGN = 18.0, 2.0, 11.0
"""Diameter of a disc of strength 0, increase per unit of strength, and diameter of a sign [px of the screen]."""


class Charges:
    """The placed charges of a document; also visible during a run, because they always act.

    The disc grows with the strength. A thin ring shows where the force is largest; a dashed one, around the selected
    charge, where it vanishes.
    """

    def __init__(self, view: pg.ViewBox) -> None:
        self._rings = (
            Curves(theme.ATTRACTING, _Z - 0.2, width=1.8, kind="shapes"),
            Curves(theme.REPELLING, _Z - 0.2, width=1.8, kind="shapes"),
        )
        self._reach = Curves(theme.CHOSEN, _Z - 0.1, width=1.2, halo=2.6, dashed=True, kind="shapes")
        self._discs = Markers(size=_DISC, pxMode=True)
        self._signs = Markers(size=_SIGN, pxMode=True, pen=None, brush=pg.mkBrush("w"))
        self._marks = (self._discs, self._signs)
        for index, item in enumerate(self._marks):
            item.setZValue(_Z + 0.1 * index)
        for item in (*self._rings, self._reach, *self._marks):
            view.addItem(item, ignoreBounds=True)

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Cover an image of this shape."""
        for curves in (*self._rings, self._reach):
            curves.use_shape(shape, rim=float(max(shape)) + REACH)

    def show(self, charges: Sequence[Charge], chosen: Charge | None) -> None:
        """Show charges, one of them as selected."""
        for curves, sign in zip(self._rings, (1.0, -1.0), strict=True):
            curves.show([_ring(charge, RADIUS) for charge in charges if sign * charge.strength > 0.0])
        self._reach.show([_ring(chosen, REACH)] if chosen is not None else [])
        charges = [charge for charge in charges if not isinstance(charge, ChargeSection) or charge.in_slice]
        x, y = to_xy(np.array([charge.position for charge in charges], dtype=float).reshape(-1, 2))
        colors = [theme.ATTRACTING if charge.strength > 0.0 else theme.REPELLING for charge in charges]
        rims = [(theme.CHOSEN, 2.6) if charge is chosen else (theme.HALO, 1.4) for charge in charges]
        self._discs.setData(
            x=x,
            y=y,
            size=[_DISC + _STRONGER * abs(charge.strength) for charge in charges],
            brush=[_brush(color) for color in colors],
            pen=[_pen(color, width) for color, width in rims],
        )
        self._signs.setData(x=x, y=y, symbol=[_PLUS if charge.strength > 0.0 else _MINUS for charge in charges])

    def set_visible(self, visible: bool) -> None:
        """Show or hide all items."""
        for curves in (*self._rings, self._reach):
            curves.set_shown(visible)
        for item in self._marks:
            item.setVisible(visible)


@lru_cache
def _brush(color: str) -> QBrush:
    """The same object for the same color: pyqtgraph keeps a picture of a symbol for every brush and pen."""
    return QBrush(QColor(color))


@lru_cache
def _pen(color: str, width: float) -> QPen:
    pen = QPen(QColor(color), width)
    pen.setCosmetic(True)
    return pen


def _ring(charge: Charge, radius: float) -> np.ndarray:
    return charge.ring(radius) if isinstance(charge, ChargeSection) else Circle(charge.position, radius).outline


def _bars(*bars: QRectF) -> QPainterPath:
    path = QPainterPath()
    for bar in bars:
        path.addRect(bar)
    return path.simplified()


_ACROSS, _DOWN = QRectF(-0.5, -0.12, 1.0, 0.24), QRectF(-0.12, -0.5, 0.24, 1.0)
_PLUS, _MINUS = _bars(_ACROSS, _DOWN), _bars(_ACROSS)
