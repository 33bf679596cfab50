"""An image item that draws only its visible part, at about the resolution of the screen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter, qRgba
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem

from cpm_app.model.display.display_image import DisplayImage
from cpm_app.views.items.item import ImageOverlay
from cpm_app.views.theme.color_maps import ramp_table
from cpm_core.numerics.types import Pixels

_TILE_BLOCK_SIZE = 256
"""Grid on which parts of a level begin and end [px], so that small moves of the view reuse the same part."""

_SMOOTHING_LIMIT = 2.0
"""Magnification below which neighboring pixels are blended; above it, single pixels become visible."""

ColoredImages = tuple[tuple[DisplayImage, str], ...]
"""Images in gray, and their colors."""

LevelPart = tuple[int, int, int, int, int]
"""Level, first row, first column, end of rows and end of columns of a part."""


class TiledImage(ImageOverlay):
    """Draws a display image from the coarsest level that still fills the resolution of the screen.

    A table gives colors to gray shades, a curve brightness and contrast to colored ones. The light of other images of
    the same shape can be added. Nothing of the size of the image is allocated here.
    """

    def __init__(self, z: float) -> None:
        super().__init__(z, 0.0)
        self.display: DisplayImage | None = None
        """Image that is drawn."""
        self._others: ColoredImages = ()
        self._colors: list[int] | None = None
        self._curve: Pixels | None = None
        self._rendered: tuple[LevelPart, QImage] | None = None
        self.setFlag(QGraphicsItem.GraphicsItemFlag.ItemUsesExtendedStyleOption)

    def show_image(self, display: DisplayImage, others: ColoredImages = ()) -> None:
        """Draw another image, and add the light of `others`."""
        if display is self.display and others == self._others:
            return
        self._others = others
        if self.display is None or display.shape != self.display.shape:
            self.set_image_shape(display.shape)
        self.display = display
        self._discard_rendered()

    def set_color_table(self, table: NDArray[np.uint8] | None) -> None:
        """Draw gray shades in the colors of a table, shape (256, 3) or (256, 4) with opacity; None for gray."""
        self._colors = None if table is None else _pack_colors(table)
        self._discard_rendered()

    def set_tone_curve(self, curve: Pixels | None) -> None:
        """Draw each channel of colored shades by a curve of 256 values; None leaves them as they are."""
        self._curve = curve
        self._discard_rendered()

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, *_: Any) -> None:
        """Draw the visible part; the exposed rectangle may be the whole image."""
        if self.display is None:
            return
        device = painter.device()
        screen = painter.combinedTransform().inverted()[0].mapRect(QRectF(0.0, 0.0, device.width(), device.height()))
        seen = QRectF(option.exposedRect).intersected(self.boundingRect()).intersected(screen)
        zoom = math.sqrt(abs(painter.deviceTransform().determinant()))
        if seen.isEmpty() or zoom <= 0.0:
            return
        coarsest = max((self.display, *(other for other, _ in self._others)), key=lambda shown: shown.finest)
        part = visible_part(coarsest, seen, zoom)
        if self._rendered is None or self._rendered[0] != part:
            self._rendered = (part, self._render_part(part))
        level, top, left, bottom, right = part
        size = 2.0**level
        place = QRectF(left * size - 0.5, top * size - 0.5, (right - left) * size, (bottom - top) * size)
        painter.save()
        painter.setClipRect(self.boundingRect(), Qt.ClipOperation.IntersectClip)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, zoom * size < _SMOOTHING_LIMIT)
        painter.drawImage(place, self._rendered[1])
        painter.restore()

    def _discard_rendered(self) -> None:
        self._rendered = None
        self.update()

    def _render_part(self, part: LevelPart) -> QImage:
        """Render the pixels of a part in the format of the screen."""
        assert self.display is not None
        picture = self._render_shades(self.display, part, self._colors)
        if self._others:
            painter = QPainter(picture)
            painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_Plus)
            for other, color in self._others:
                painter.drawImage(0, 0, self._render_shades(other, part, _pack_colors(ramp_table(color))))
            painter.end()
        return picture

    def _render_shades(self, display: DisplayImage, part: LevelPart, colors: list[int] | None) -> QImage:
        level, top, left, bottom, right = part
        shades: Pixels = display.levels[level - display.finest][top:bottom, left:right]
        if shades.ndim == 3 and self._curve is not None:
            shades = self._curve[shades]
        if shades.ndim == 3:
            picture = _wrap_pixels(shades, QImage.Format.Format_RGB888)
        elif colors is None:
            picture = _wrap_pixels(shades, QImage.Format.Format_Grayscale8)
        else:
            picture = _wrap_pixels(shades, QImage.Format.Format_Indexed8)
            picture.setColorTable(colors)
        opaque = colors is None or shades.ndim == 3
        screen = QImage.Format.Format_RGB32 if opaque else QImage.Format.Format_ARGB32_Premultiplied
        return picture.convertToFormat(screen)


def _pack_colors(table: NDArray[np.uint8]) -> list[int]:
    """Pack a table, shape (256, 3) or (256, 4) with opacity, as Qt takes it."""
    return [qRgba(*(int(c) for c in (*row, 255)[:4])) for row in table]


def _wrap_pixels(shades: Pixels, kind: QImage.Format) -> QImage:
    """Wrap shades, shape (H, W) or (H, W, 3), in a QImage without a copy; keep them alive while it is used."""
    rows, cols = shades.shape[:2]
    last = (rows - 1) * shades.strides[0] + cols * shades.strides[1]
    flat = np.lib.stride_tricks.as_strided(shades, (last,), (1,), writeable=False)
    return QImage(flat.data, cols, rows, shades.strides[0], kind)


def visible_part(display: DisplayImage, seen: QRectF, zoom: float) -> LevelPart:
    """Find the part of a display image to draw for a visible rectangle [px of the image].

    `zoom` is the number of pixels of the screen per pixel of the image.
    """
    coarsest = display.finest + len(display.levels) - 1
    level = min(max(math.floor(-math.log2(zoom) + 1e-6), display.finest), coarsest)
    size = 2.0**level
    rows, cols = display.levels[level - display.finest].shape[:2]
    top, left = (
        max(int((first + 0.5) / size) // _TILE_BLOCK_SIZE * _TILE_BLOCK_SIZE, 0) for first in (seen.top(), seen.left())
    )
    ends = ((seen.bottom(), rows), (seen.right(), cols))
    bottom, right = (
        min(-(-math.ceil((end + 0.5) / size) // _TILE_BLOCK_SIZE) * _TILE_BLOCK_SIZE, most) for end, most in ends
    )
    return level, top, left, bottom, right
