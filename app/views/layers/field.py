"""The layer of the electric field."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QRectF

from app.model.language import tr
from app.session.messages import Overlays
from app.session.session import Session
from app.views import theme
from app.views.coordinates import to_xy
from app.views.layers.layer import Layer
from app.views.pens import cached, line_pen

Array = NDArray[np.float64]

ARROW_SPACING = 22.0
"""Least distance between two arrows of the field [px of the screen]."""


class FieldLayer(Layer):
    """Arrows along the Lorentz force, as many as the zoom leaves room for."""

    name = "field"
    title = tr("Field")
    tip = tr("Direction in which edges pull.")
    shortcut = "Ctrl+5"
    initially = False
    colours = (theme.FIELD,)

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._item = pg.PlotCurveItem(pen=line_pen(theme.FIELD, 1.0), antialias=True)
        self._item.setZValue(2)
        cached(self._item)
        self.add(self._item)
        self._field: Array | None = None
        view.sigRangeChanged.connect(self._draw)
        session.overlays_changed.connect(self._show)
        session.image_changed.connect(lambda *_: self._use(None))

    def show_or_hide(self) -> None:
        """Ask for the field only while it is seen."""
        self.session.want_overlay("field", self.shown)
        if not self.shown:
            self._use(None)

    def _show(self, overlays: Overlays) -> None:
        field = overlays.arrays.get("field")
        self._use(np.asarray(field, dtype=float) if self.shown and field is not None else None)

    def _use(self, field: Array | None) -> None:
        self._field = field
        self._draw()

    def _draw(self) -> None:
        self._item.setVisible(self._field is not None)
        if self._field is None:
            return
        starts, ends = arrows(self._field, self.view.viewRect(), self.view.viewPixelSize()[0])
        lines = arrow_lines(starts, ends)
        x, y = to_xy(lines)
        self._item.setData(x, y, connect="pairs")


def arrows(field: Array, seen: QRectF, pixel: float) -> tuple[Array, Array]:
    """Where arrows begin and end so that they neither crowd nor lie outside what is seen.

    Parameters
    ----------
    field : ndarray, shape (2, H, W)
        Vectors of at most unit length.
    seen : QRectF
        Part of the canvas that is seen.
    pixel : float
        Size of a pixel of the screen [px of the image].

    Returns
    -------
    starts, ends : ndarray, shape (N, 2)
        (row, col).
    """
    stride = max(1, int(np.ceil(ARROW_SPACING * pixel)))
    rows = np.arange(stride // 2, field.shape[1], stride)
    cols = np.arange(stride // 2, field.shape[2], stride)
    rows = rows[(rows >= seen.top()) & (rows <= seen.bottom())]
    cols = cols[(cols >= seen.left()) & (cols <= seen.right())]
    grid = np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1).reshape(-1, 2)
    vectors = field[:, grid[:, 0], grid[:, 1]].T * (0.85 * stride)
    starts = grid - 0.5 * vectors
    return starts, starts + vectors


def arrow_lines(starts: Array, ends: Array) -> Array:
    """Pairs of points, shape (6 N, 2), that draw a shaft and two barbs for each arrow."""
    vectors = ends - starts
    across = np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)
    left = ends - 0.30 * vectors + 0.18 * across
    right = ends - 0.30 * vectors - 0.18 * across
    return np.stack([starts, ends, left, ends, right, ends], axis=1).reshape(-1, 2)
