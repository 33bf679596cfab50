"""Frames: the layers as they are on the canvas, drawn off the screen for any moment of the run."""

from __future__ import annotations

from typing import cast

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter

from app.session.session import Session
from app.session.worker.commands.frames import FrameTaken
from app.views.canvas.canvas import Canvas
from app.views.canvas.coordinates import image_rectangle
from app.views.film.understudy import Told, Understudy
from cpm_core.numerics.types import Pixels

NARROWEST, WIDEST = 64, 3840
"""Widths that a frame may have [px]."""


def seen_part(canvas: Canvas, shape: tuple[int, ...], zoomed: bool) -> QRectF:
    """What of the image a frame shows: all of it, or what the canvas shows of it."""
    whole = image_rectangle(shape)
    part = canvas.view.viewRect().intersected(whole) if zoomed else whole
    return whole if part.isEmpty() else part


def frame_size(part: QRectF, width: int) -> tuple[int, int]:
    """Width and height of a frame, both even as films want them [px]."""
    height = width * part.height() / max(part.width(), 1e-9)
    return max(2 * round(width / 2), 2), min(max(2 * round(height / 2), 2), 2 * WIDEST)


class FrameRenderer:
    """A second canvas that nobody sees, with the layers of the first as they are when it is made.

    Parameters
    ----------
    session : Session
        What it belongs to.
    canvas : Canvas
        The canvas that it looks like.
    told : Told
        What the layers must know.
    part : QRectF
        What of the image is seen.
    size : tuple of int
        Width and height [px].
    """

    def __init__(self, session: Session, canvas: Canvas, told: Told, part: QRectF, size: tuple[int, int]) -> None:
        self._size = size
        self._understudy = Understudy(session)
        self._canvas = Canvas(cast(Session, self._understudy))
        self._canvas.setAttribute(Qt.WidgetAttribute.WA_DontShowOnScreen)
        self._canvas.setMinimumSize(1, 1)
        self._canvas.setFrameStyle(0)
        self._canvas.resize(*size)
        self._canvas.show()
        told.tell(self._understudy)
        for layer in canvas.layers:
            self._canvas.layers[layer.name].use_view_state(layer.view_state())
        told.tell_what_lies_over(self._understudy)
        self._canvas.view.setRange(part, padding=0.0)

    def draw(self, taken: FrameTaken) -> Pixels:
        """Draw a moment: red, green and blue, shape (H, W, 3)."""
        self._understudy.show_snapshot(taken.moment)
        self._understudy.show_contours(taken.contours)
        if taken.compared is not None:
            self._understudy.reported.emit(taken.compared)
        picture = QImage(*self._size, QImage.Format.Format_RGB32)
        painter = QPainter(picture)
        self._canvas.render(painter)
        painter.end()
        return to_array(picture)

    def close(self) -> None:
        """Take it down."""
        self._canvas.hide()  # its own close() takes the scene from under items that still live
        self._canvas.deleteLater()
        self._understudy.deleteLater()


def to_array(picture: QImage) -> Pixels:
    """Pixels of a picture, shape (H, W, 3)."""
    plain = picture.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(plain.height(), plain.bytesPerLine())
    return rows[:, : 3 * plain.width()].reshape(plain.height(), plain.width(), 3).copy()


def to_picture(frame: Pixels) -> QImage:
    """A picture of pixels, shape (H, W, 3)."""
    pixels = np.ascontiguousarray(frame)
    height, width = pixels.shape[:2]
    return QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()
