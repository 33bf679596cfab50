"""Pictures of the view in space for files: one, or those of a full turn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from PySide6.QtCore import QSize
from PySide6.QtGui import QImage, QPainter

from app.model.display.space.camera import Camera, turntable
from app.model.display.space.picture import Colors
from app.model.display.space.view_in_space import Look, ViewInSpace
from app.views.volume.space_marks import SpaceMarks

FRAMES, FRAMES_PER_SECOND = 120, 25.0
"""Frames of a turn, and their speed."""

_LONGEST = 720
"""Longer side of the frames of an animation [px]."""


def picture_of(view: ViewInSpace, camera: Camera, size: tuple[int, int], look: Look, marks: SpaceMarks) -> Colors:
    """The view in a picture of so many rows and columns, with names and scale bar; on any thread."""
    colors = np.ascontiguousarray(view.drawn(camera, size, look).colors)
    rows, cols = size
    image = QImage(colors.data, cols, rows, 3 * cols, QImage.Format.Format_RGB888)
    painter = QPainter(image)
    marks.draw(painter, view, camera, QSize(cols, rows))
    painter.end()
    return colors


def animation_size(size: tuple[int, int]) -> tuple[int, int]:
    """Rows and columns of the frames of an animation of a view of this size: even, as films need."""
    factor = min(1.0, _LONGEST / max(size))
    rows, cols = (max(2, 2 * round(0.5 * factor * side)) for side in size)
    return rows, cols


def turn(view: ViewInSpace, camera: Camera, size: tuple[int, int], look: Look, marks: SpaceMarks) -> Iterator[Colors]:
    """The frames of a full turn, drawn one by one."""
    for one in turntable(camera, FRAMES):
        yield picture_of(view, one, size, look, marks)
