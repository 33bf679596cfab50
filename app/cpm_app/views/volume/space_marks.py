"""What is written over the view in space, and pictures of it for files: one, or those of a full turn."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen

from cpm_app.model.display.lengths import bar
from cpm_app.model.space.camera import Camera
from cpm_app.model.space.view_in_space import AXIS_COLORS, Look, ViewInSpace
from cpm_app.model.volume.slices import ends_of
from cpm_app.views.theme import theme
from cpm_core.numerics.types import Pixels

LOOK = Look(background=(0x14, 0x16, 0x1A))
"""With the background of the canvas."""

_LONGEST, _MARGIN, _TICK = 120.0, 14.0, 4.0
"""Largest length of the scale bar, its distance from the corner, and the height of its ends [px of the screen]."""

_BEYOND = 12.0
"""Distance of a name from the end of its axis [px of the screen]."""


def draw_marks(painter: QPainter, view: ViewInSpace, camera: Camera, size: QSize) -> None:
    """Draw names at both ends of each axis, and a bar in the volume's unit, over a picture that a camera has taken."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for axis, names in enumerate(ends_of(view.image) if view.shown.box else ()):
        ends = np.zeros((2, 3))
        ends[1, axis] = view.lengths[axis]
        seen = camera.seen(ends, (size.height(), size.width()))[:, :2].astype(float)
        way = seen[1] - seen[0]
        length = float(np.hypot(*way))
        if length < 2.0 * _BEYOND:  # the axis points to the viewer
            continue
        painter.setPen(QColor(*AXIS_COLORS[axis]).lighter(130))
        for place, side, name in ((seen[0], -1.0, names[0]), (seen[1], 1.0, names[1])):
            col, row = place + side * _BEYOND * way / length
            write(painter, QPointF(col, row), name)
    scaled = bar(_LONGEST / camera.scale, 1.0, view.image.unit)
    length = scaled.pixels * camera.scale
    left, y = _MARGIN, size.height() - _MARGIN
    painter.setPen(QPen(QColor(theme.DRAWING), 2.0))
    painter.drawLine(QPointF(left, y), QPointF(left + length, y))
    for x in (left, left + length):
        painter.drawLine(QPointF(x, y - _TICK), QPointF(x, y + _TICK))
    write(painter, QPointF(left + 0.5 * length, y - _MARGIN), scaled.label)


def write(painter: QPainter, center: QPointF, text: str) -> None:
    """A text with its middle at a point."""
    metrics = painter.fontMetrics()
    room = QSizeF(metrics.horizontalAdvance(text) + 4.0, metrics.height())
    corner = center - QPointF(0.5 * room.width(), 0.5 * room.height())
    painter.drawText(QRectF(corner, room), Qt.AlignmentFlag.AlignCenter, text)


FRAMES, FRAMES_PER_SECOND = 120, 25.0
"""Frames of a turn, and their speed."""

_LONGEST_FRAME = 720
"""Longer side of the frames of an animation [px]."""


def picture_of(view: ViewInSpace, camera: Camera, size: tuple[int, int]) -> Pixels:
    """The view in a picture of so many rows and columns, with names and scale bar; on any thread."""
    colors = np.ascontiguousarray(view.drawn(camera, size, LOOK).colors)
    rows, cols = size
    image = QImage(colors.data, cols, rows, 3 * cols, QImage.Format.Format_RGB888)
    painter = QPainter(image)
    draw_marks(painter, view, camera, QSize(cols, rows))
    painter.end()
    return colors


def animation_size(size: tuple[int, int]) -> tuple[int, int]:
    """Rows and columns of the frames of an animation of a view of this size: even, as films need."""
    factor = min(1.0, _LONGEST_FRAME / max(size))
    rows, cols = (max(2, 2 * round(0.5 * factor * side)) for side in size)
    return rows, cols


def turn(view: ViewInSpace, camera: Camera, size: tuple[int, int]) -> Iterator[Pixels]:
    """The frames of a full turn, drawn one by one."""
    for frame in range(FRAMES):
        yield picture_of(view, camera.turned(2.0 * pi * frame / FRAMES, 0.0), size)
