"""Frames: the layers of the canvas, drawn off-screen for any moment of the run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter

from app.session.scene import ReviewedContours, Scene
from app.session.worker.commands import Command
from app.session.worker.requests import FrameTaken
from app.views.canvas.canvas import Canvas
from app.views.canvas.image_view import ImageView
from app.views.canvas.items.item import image_rectangle
from cpm_core.numerics.types import Pixels

NARROWEST, WIDEST = 64, 3840
"""Smallest and largest width of a frame [px]."""


def seen_part(canvas: Canvas, shape: tuple[int, ...], zoomed: bool) -> QRectF:
    """Part of the image that a frame shows: all of it, or the visible part of the canvas."""
    whole = image_rectangle(shape)
    part = canvas.view.viewRect().intersected(whole) if zoomed else whole
    return whole if part.isEmpty() else part


def frame_size(part: QRectF, width: int) -> tuple[int, int]:
    """Width and height of a frame, both even as film formats need them [px]."""
    height = width * part.height() / max(part.width(), 1e-9)
    return max(2 * round(width / 2), 2), min(max(2 * round(height / 2), 2), 2 * WIDEST)


class NoRequests:
    """Ignores requests: the layers of the window have already made them."""

    def post(self, command: Command) -> None:
        """Do nothing."""

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Do nothing."""


class FrameRenderer:
    """An off-screen view with the present settings of the layers of a canvas.

    Parameters
    ----------
    scene : Scene
        The scene shown in addition to the moments of the run.
    canvas : Canvas
        The canvas whose layers are copied.
    part : QRectF
        Visible part of the image.
    size : tuple of int
        Width and height [px].
    """

    def __init__(self, scene: Scene, canvas: Canvas, part: QRectF, size: tuple[int, int]) -> None:
        self._size = size
        # selection and differences belong to the present contours, not to those of other moments
        self._scene = replace(scene, selected_contours=frozenset(), hovered_contour=None, differences=())
        self._view = ImageView(NoRequests())
        self._view.setAttribute(Qt.WidgetAttribute.WA_DontShowOnScreen)
        self._view.setMinimumSize(1, 1)
        self._view.setFrameStyle(0)
        self._view.resize(*size)
        self._view.show()
        # a new image resets the options of its layer; the moments are drawn later
        first = Scene(scene.image, scene.display, document=scene.document, selected=scene.selected)
        self._view.draw(replace(first, slices=scene.slices))
        for layer in canvas.layers:
            self._view.layers[layer.name].use_view_state(layer.view_state())
        self._view.view.setRange(part, padding=0.0)

    def draw(self, taken: FrameTaken) -> Pixels:
        """Draw a moment as RGB values, shape (H, W, 3)."""
        tracked = taken.contours.tracked if taken.contours is not None else None
        contours = ReviewedContours.of(tracked, self._scene.document.marks)
        self._view.draw(replace(self._scene, snapshot=taken.moment, reconstruction=taken.contours, contours=contours))
        picture = QImage(*self._size, QImage.Format.Format_RGB32)
        painter = QPainter(picture)
        self._view.render(painter)
        painter.end()
        return to_array(picture)

    def close(self) -> None:
        """Delete the view."""
        self._view.hide()  # close() would delete the graphics scene before its items
        self._view.deleteLater()


def to_array(picture: QImage) -> Pixels:
    """RGB values of a picture, shape (H, W, 3)."""
    plain = picture.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(plain.height(), plain.bytesPerLine())
    return rows[:, : 3 * plain.width()].reshape(plain.height(), plain.width(), 3).copy()


def to_picture(frame: Pixels) -> QImage:
    """Picture of RGB values, shape (H, W, 3)."""
    pixels = np.ascontiguousarray(frame)
    height, width = pixels.shape[:2]
    return QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()
