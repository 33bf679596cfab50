"""Discs on the canvas: seeds of starts, and particles, which change in every frame."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pyqtgraph.Qt import internals
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QPixmap
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from cpm_app.views.items.item import ImageOverlay, to_xy
from cpm_app.views.theme.theme import get_canvas_style
from cpm_core.numerics import Array
from cpm_core.numerics.types import NO_POINTS

_MIN_DISC_DIAMETER = 2.4
"""Minimum diameter of a disc [px of the screen]."""

_DISC_SPAN = 2.4
"""Diameter of a disc [px of the image], slightly larger than the spacing of the particles."""

Marks = NDArray[np.uint8]

_DISC_RIM = 16.0
"""Margin around the image for particles on its border [px of the image]."""


class Discs(ImageOverlay):
    """Discs of one color or of a palette; their size follows the zoom within bounds.

    A single call of the painter draws all discs from one pixmap with the colors side by side. A pyqtgraph scatter plot
    does the same, but spends several milliseconds on preparation because its symbols may differ.

    Parameters
    ----------
    color : str
        Color.
    diameter : float
        Largest diameter [px of the screen].
    z : float
        Place in the stack of layers.

    Attributes
    ----------
    position : ndarray, shape (N, 2)
        Centers (row, col) [px of the image].
    """

    count = 0

    def __init__(self, color: str, diameter: float, z: float) -> None:
        super().__init__(z, _DISC_RIM)
        self._default_palette = (color,)
        self._colors: Sequence[str] = self._default_palette
        self._diameter = diameter
        self._size_factor = 1.0
        self.position: Array = NO_POINTS
        self._marks: Marks | None = None
        self._opacity: Array | None = None
        self._stamps = internals.PrimitiveArray(QPainter.PixmapFragment, 10)
        self._stamp = QImage()
        self._stamped: tuple[object, ...] = ()

    def set_palette(self, colors: Sequence[str]) -> None:
        """Set the palette; an empty one is the color of the item; call `show_discs` afterwards."""
        self._colors = tuple(colors) or self._default_palette
        self.update()

    def set_size_factor(self, factor: float) -> None:
        """Scale the diameter of the discs by a factor."""
        if factor != self._size_factor:
            self._size_factor = factor
            self.update()

    def show_discs(self, position: Array, color: Marks | None = None, opacity: Array | None = None) -> None:
        """Show discs, unless nothing has changed, as in slices far from moving particles.

        Parameters
        ----------
        position : ndarray, shape (N, 2)
            Centers (row, col) [px of the image].
        color : ndarray of uint8, shape (N,), optional
            Indices into the palette, by default 0.
        opacity : ndarray, shape (N,), optional
            Opacities from 0 to 1, by default 1.
        """
        shown = zip((position, color, opacity), (self.position, self._marks, self._opacity), strict=True)
        if all(one is other or np.array_equal(one, other) for one, other in shown):  # type: ignore[arg-type]  # None
            return
        self.position, self._marks, self._opacity = position, color, opacity
        self.update_count(len(position))

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw all discs."""
        device = painter.device()
        ratio = device.devicePixelRatioF()
        transform = painter.worldTransform()
        stamp = self._stamp_for(ratio, abs(transform.m11()))
        origin = transform.map(QPointF(0.0, 0.0))
        x, y = to_xy(self.position)
        x, y = origin.x() + x * transform.m11(), origin.y() + y * transform.m22()
        # The painter spends as much time on a disc outside the visible part as on one inside.
        side = stamp.height()
        reach = side / ratio
        seen = (x > -reach) & (x < device.width() + reach) & (y > -reach) & (y < device.height() + reach)
        marks, opacity = self._marks, self._opacity
        if not seen.all():
            x, y, marks = x[seen], y[seen], marks if marks is None else marks[seen]
            opacity = opacity if opacity is None else opacity[seen]
        self._stamps.resize(len(x))
        table = self._stamps.ndarray()
        table[:, 0] = x
        table[:, 1] = y
        table[:, 2] = 0.0 if marks is None else marks * float(side)
        table[:, 3] = 0.0
        table[:, 4:6] = side
        table[:, 6:8] = 1.0 / ratio
        table[:, 8] = 0.0
        table[:, 9] = 1.0 if opacity is None else opacity
        painter.save()
        painter.resetTransform()
        painter.drawPixmapFragments(*self._stamps.drawargs(), QPixmap(stamp))  # type: ignore[call-arg]  # pointer and length
        painter.restore()

    def _stamp_for(self, ratio: float, zoom: float) -> QImage:
        """Draw the discs of all colors side by side, for `ratio` device pixels per point, at magnification `zoom`."""
        diameter = round(
            ratio
            * self._size_factor
            * get_canvas_style().points
            * min(self._diameter, max(_MIN_DISC_DIAMETER, _DISC_SPAN * zoom)),
            1,
        )
        colors = tuple(get_canvas_style().resolve_color(color) for color in self._colors)
        if self._stamped != (diameter, ratio, colors):
            self._stamped = (diameter, ratio, colors)
            side = math.ceil(diameter + 2.0 * ratio)
            self._stamp = QImage(side * len(colors), side, QImage.Format.Format_ARGB32_Premultiplied)
            self._stamp.fill(Qt.GlobalColor.transparent)
            painter = QPainter(self._stamp)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            # A rim separates large discs; around small ones it would hide the color.
            strength = round(190 * min(1.0, max(0.0, (diameter / ratio - _MIN_DISC_DIAMETER) / 3.0)))
            painter.setPen(QPen(QColor(0, 0, 0, strength), 0.9 * ratio) if strength else Qt.PenStyle.NoPen)
            for index, color in enumerate(colors):
                painter.setBrush(QColor(color))
                painter.drawEllipse(QPointF((index + 0.5) * side, side / 2), diameter / 2, diameter / 2)
            painter.end()
        return self._stamp
