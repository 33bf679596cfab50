"""An image on the canvas that draws only its visible part, in about as many pixels as the screen has for it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter, qRgba
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem

from cpm_app.model.display.display_image import DisplayImage
from cpm_app.views.items.item import OverImage
from cpm_core.numerics.types import Pixels

_BLOCK = 256
"""Parts of a level begin and end at multiples of this, so that a small move of the view needs no other part [px]."""

_SMOOTH = 2.0
"""Pixels of the screen for each of the image below which neighbors are blended: single pixels are not seen yet."""

Part = tuple[int, int, int, int, int]
"""A level, and first row, first column, end of rows and end of columns of a part of it."""


class TiledImage(OverImage):
    """Draws a display image from the level whose pixels are the largest that the screen does not enlarge.

    Gray shades can be given colors by a table, colored ones brightness and contrast by a curve. Nothing of the size of
    the image is made here.
    """

    def __init__(self, z: float) -> None:
        super().__init__(z, 0.0)
        self.display: DisplayImage | None = None
        """The image that is drawn."""
        self._colors: list[int] | None = None
        self._curve: Pixels | None = None
        self._made: tuple[Part, QImage] | None = None
        self.setFlag(QGraphicsItem.GraphicsItemFlag.ItemUsesExtendedStyleOption)

    def show_image(self, display: DisplayImage) -> None:
        """Draw another image."""
        if display is self.display:
            return
        if self.display is None or display.shape != self.display.shape:
            self.use_shape(display.shape)
        self.display = display
        self._renew()

    def use_table(self, table: NDArray[np.uint8] | None) -> None:
        """Draw gray shades in the colors of a table, shape (256, 3) or (256, 4) with opacity; None for gray."""
        self._colors = None if table is None else [qRgba(*(int(c) for c in (*row, 255)[:4])) for row in table]
        self._renew()

    def use_curve(self, curve: Pixels | None) -> None:
        """Draw each channel of colored shades by a curve of 256 values; None leaves them as they are."""
        self._curve = curve
        self._renew()

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, *_: Any) -> None:
        """Draw the part that is seen; all that is exposed may be the whole image."""
        if self.display is None:
            return
        device = painter.device()
        screen = painter.combinedTransform().inverted()[0].mapRect(QRectF(0.0, 0.0, device.width(), device.height()))
        seen = QRectF(option.exposedRect).intersected(self.boundingRect()).intersected(screen)
        zoom = math.sqrt(abs(painter.deviceTransform().determinant()))
        if seen.isEmpty() or zoom <= 0.0:
            return
        part = part_of(self.display, seen, zoom)
        if self._made is None or self._made[0] != part:
            self._made = (part, self._picture(part))
        level, top, left, bottom, right = part
        size = 2.0**level
        place = QRectF(left * size - 0.5, top * size - 0.5, (right - left) * size, (bottom - top) * size)
        painter.save()
        painter.setClipRect(self.boundingRect(), Qt.ClipOperation.IntersectClip)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, zoom * size < _SMOOTH)
        painter.drawImage(place, self._made[1])
        painter.restore()

    def _renew(self) -> None:
        self._made = None
        self.update()

    def _picture(self, part: Part) -> QImage:
        """The pixels of a part, as the screen has them."""
        assert self.display is not None
        level, top, left, bottom, right = part
        shades: Pixels = self.display.levels[level - self.display.finest][top:bottom, left:right]
        if shades.ndim == 3 and self._curve is not None:
            shades = self._curve[shades]
        if shades.ndim == 3:
            picture = _view(shades, QImage.Format.Format_RGB888)
        elif self._colors is None:
            picture = _view(shades, QImage.Format.Format_Grayscale8)
        else:
            picture = _view(shades, QImage.Format.Format_Indexed8)
            picture.setColorTable(self._colors)
        opaque = self._colors is None or shades.ndim == 3
        screen = QImage.Format.Format_RGB32 if opaque else QImage.Format.Format_ARGB32_Premultiplied
        return picture.convertToFormat(screen)


def _view(shades: Pixels, kind: QImage.Format) -> QImage:
    """Rows of an image, whose bytes stay where they are as long as it is used."""
    rows, cols = shades.shape[:2]
    last = (rows - 1) * shades.strides[0] + cols * shades.strides[1]
    flat = np.lib.stride_tricks.as_strided(shades, (last,), (1,), writeable=False)
    return QImage(flat.data, cols, rows, shades.strides[0], kind)


def part_of(display: DisplayImage, seen: QRectF, zoom: float) -> Part:
    """The part of a display image that is drawn for a visible rectangle [px of the image].

    `zoom` is the number of pixels of the screen for each of the image.
    """
    coarsest = display.finest + len(display.levels) - 1
    level = min(max(math.floor(-math.log2(zoom) + 1e-6), display.finest), coarsest)
    size = 2.0**level
    rows, cols = display.levels[level - display.finest].shape[:2]
    top, left = (max(int((first + 0.5) / size) // _BLOCK * _BLOCK, 0) for first in (seen.top(), seen.left()))
    ends = ((seen.bottom(), rows), (seen.right(), cols))
    bottom, right = (min(-(-math.ceil((end + 0.5) / size) // _BLOCK) * _BLOCK, most) for end, most in ends)
    return level, top, left, bottom, right
