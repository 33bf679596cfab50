"""Axis names and scale bar over the view in space, and its pictures for files: one, or a full turn."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen

from cpm_app.model.display.lengths import find_scale_bar
from cpm_app.model.space.camera import Camera
from cpm_app.model.space.view_in_space import AXIS_COLORS, ViewInSpace
from cpm_app.model.volume.slices import axis_labels
from cpm_app.views.theme import theme
from cpm_core.numerics.types import Pixels

_MAX_BAR_LENGTH = 120.0
"""Maximum length of the scale bar [px of the screen]."""

_BAR_MARGIN = 14.0
"""Distance of the scale bar from the corner [px of the screen]."""

_BAR_TICK = 4.0
"""Half height of the ends of the scale bar [px of the screen]."""

_AXIS_NAME_GAP = 12.0
"""Distance of a name from the end of its axis [px of the screen]."""


def draw_marks(painter: QPainter, view: ViewInSpace, camera: Camera, size: QSize) -> None:
    """Draw names at both ends of each axis, and a scale bar in the unit of the volume, over a picture of a camera."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for axis, names in enumerate(axis_labels(view.image) if view.shown.box else ()):
        ends = np.zeros((2, 3))
        ends[1, axis] = view.lengths[axis]
        seen = camera.project(ends, (size.height(), size.width()))[:, :2].astype(float)
        way = seen[1] - seen[0]
        length = float(np.hypot(*way))
        if length < 2.0 * _AXIS_NAME_GAP:  # the axis points to the viewer
            continue
        painter.setPen(QColor(*AXIS_COLORS[axis]).lighter(130))
        for place, side, name in ((seen[0], -1.0, names[0]), (seen[1], 1.0, names[1])):
            col, row = place + side * _AXIS_NAME_GAP * way / length
            draw_text(painter, QPointF(col, row), name)
    scaled = find_scale_bar(_MAX_BAR_LENGTH / camera.scale, 1.0, view.image.unit)
    length = scaled.pixels * camera.scale
    left, y = _BAR_MARGIN, size.height() - _BAR_MARGIN
    painter.setPen(QPen(QColor(theme.DRAWING_COLOR), 2.0))
    painter.drawLine(QPointF(left, y), QPointF(left + length, y))
    for x in (left, left + length):
        painter.drawLine(QPointF(x, y - _BAR_TICK), QPointF(x, y + _BAR_TICK))
    draw_text(painter, QPointF(left + 0.5 * length, y - _BAR_MARGIN), scaled.label)


def draw_text(painter: QPainter, center: QPointF, text: str) -> None:
    """Draw a text centered on a point."""
    metrics = painter.fontMetrics()
    room = QSizeF(metrics.horizontalAdvance(text) + 4.0, metrics.height())
    corner = center - QPointF(0.5 * room.width(), 0.5 * room.height())
    painter.drawText(QRectF(corner, room), Qt.AlignmentFlag.AlignCenter, text)


TURN_FRAMES = 120
"""Number of frames of a full turn."""

FRAMES_PER_SECOND = 25.0
"""Frame rate of the animation of a turn [1/s]."""

_MAX_FRAME_SIDE = 720
"""Longer side of the frames of an animation [px]."""


def render_picture(view: ViewInSpace, camera: Camera, size: tuple[int, int]) -> Pixels:
    """Render the view with names and scale bar; safe on any thread.

    Returns
    -------
    ndarray of uint8, shape (rows, cols, 3)
        RGB colors, where `size` is (rows, cols).
    """
    colors = np.ascontiguousarray(view.render_picture(camera, size).colors)
    rows, cols = size
    image = QImage(colors.data, cols, rows, 3 * cols, QImage.Format.Format_RGB888)
    painter = QPainter(image)
    draw_marks(painter, view, camera, QSize(cols, rows))
    painter.end()
    return colors


def animation_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return rows and columns of the frames of an animation of a view of this size; even, as video codecs need."""
    factor = min(1.0, _MAX_FRAME_SIDE / max(size))
    rows, cols = (max(2, 2 * round(0.5 * factor * side)) for side in size)
    return rows, cols


def render_turn(view: ViewInSpace, camera: Camera, size: tuple[int, int]) -> Iterator[Pixels]:
    """Render the frames of a full turn one by one, each of shape (rows, cols, 3), uint8."""
    for frame in range(TURN_FRAMES):
        yield render_picture(view, camera.rotated(2.0 * pi * frame / TURN_FRAMES, 0.0), size)
