"""The view in space: a volume with its particles and surface, turned by the mouse."""

from __future__ import annotations

import time
from dataclasses import fields, replace
from functools import partial
from math import pi, radians

import numpy as np
from PySide6.QtCore import QPoint, QPointF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
    QColor,
    QContextMenuEvent,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QApplication, QSizePolicy, QWidget

from cpm_app.model.space.camera import Camera
from cpm_app.model.space.picture import EMPTY_DEPTH, Picture
from cpm_app.model.space.view_in_space import ShownParticles, ViewInSpace
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import find_front_axis, slice_directions
from cpm_app.session.features.background import IdentityCache, LatestOnlyWorker
from cpm_app.session.session import Session
from cpm_app.views.theme import theme
from cpm_app.views.volume.space_marks import draw_marks, draw_text
from cpm_core.numerics import Array, Place
from cpm_core.numerics.types import record

_KEY_TURN_ANGLE = radians(5.0)
"""Angle that a key press turns [rad]."""

_KEY_ZOOM_FACTOR = 1.2
"""Factor that a key press enlarges."""

_TURN_KEYS = {
    Qt.Key.Key_Left: (-_KEY_TURN_ANGLE, 0.0),
    Qt.Key.Key_Right: (_KEY_TURN_ANGLE, 0.0),
    Qt.Key.Key_Up: (0.0, -_KEY_TURN_ANGLE),
    Qt.Key.Key_Down: (0.0, _KEY_TURN_ANGLE),
}
"""Angles (to the right, down) of the keys that turn [rad]."""

_ZOOM_KEYS = {
    Qt.Key.Key_Plus: _KEY_ZOOM_FACTOR,
    Qt.Key.Key_Equal: _KEY_ZOOM_FACTOR,
    Qt.Key.Key_Minus: 1.0 / _KEY_ZOOM_FACTOR,
}
"""Factors of the keys that zoom."""

_AXIS_KEYS = {Qt.Key.Key_1: 0, Qt.Key.Key_2: 1, Qt.Key.Key_3: 2}
"""Axes of the keys that look along one."""

_WHOLE_VIEW_KEYS = (Qt.Key.Key_0, Qt.Key.Key_Home)
"""Keys that show the whole volume."""

_STILL_DELAY = 150
"""Time without a change after which the picture is drawn at full size [ms]."""

_MAX_TURNING_TIME = 0.02
"""Time that a picture may take while the view turns [s]; slower ones are drawn coarser."""

_MAX_COARSENESS = 4
"""Largest pixel of a coarse picture [px of the screen]."""

_WHEEL_FACTOR = 1.0015
"""Factor that an eighth of a degree of the wheel enlarges."""

_MAX_CLICK_MOVE = 4.0
"""Largest distance between press and release of a click [px of the screen]."""


@record
class _SpaceFrame:
    """A picture, and the particles, camera and settings it was drawn with."""

    picture: Picture
    particles: ShownParticles | None
    camera: Camera
    coarseness: int
    request_number: int
    seconds: float


class SpaceView(QWidget):
    """Draws the newest view on its own thread: coarsely while it moves, at full resolution once it is still.

    Drag to turn, with Shift or the middle button to move, with Ctrl to roll; the wheel zooms; a double click shows
    everything again. A click on an item selects its position, a right click opens the menu.
    """

    picked = Signal(object)
    """Position (plane, row, col) [voxels] that the user has clicked."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setAccessibleName(tr("View in space"))
        self.camera: Camera | None = None
        self._view: ViewInSpace | None = None
        self._frame: _SpaceFrame | None = None
        self._seconds, self._asked = 0.0, 0
        self._pressed: QPointF | None = None
        self._last = QPointF()
        self._drag = (Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier)
        self._painter = LatestOnlyWorker(session, "cpm-space", tr("drawing the view in space"))
        self._still = QTimer(self, interval=_STILL_DELAY, singleShot=True)
        self._still.timeout.connect(partial(self._request_picture, 1))
        self._parts = IdentityCache()

    def sizeHint(self) -> QSize:
        """Return the size of a square."""
        return QSize(420, 420)

    def show_view(self, view: ViewInSpace | None) -> None:
        """Show another view; keep the camera unless the volume has another size."""
        before, self._view = self._view, view
        if view is None:
            self._frame, self.camera = None, None
            self.update()
        elif before is None or self.camera is None or before.lengths != view.lengths:
            self.show_all()
        else:
            self._draw_coarsely()

    @property
    def is_idle(self) -> bool:
        """Whether the picture shows the last request at full resolution."""
        shown = 0 if self._frame is None else self._frame.request_number
        return not self._still.isActive() and (self._view is None or shown == self._asked)

    @property
    def positions(self) -> Array | None:
        """Positions of the particles in the picture [voxels], shape (N, 3); None without any."""
        return None if self._frame is None or self._frame.particles is None else self._frame.particles.positions

    @property
    def picture_size(self) -> tuple[int, int]:
        """Rows and columns of the picture at full resolution."""
        ratio = self.devicePixelRatioF()
        return max(1, round(self.height() * ratio)), max(1, round(self.width() * ratio))

    def show_all(self) -> None:
        """Show the whole volume from the initial direction."""
        if self._view is not None:
            image = self._view.image
            self.set_camera(
                Camera.facing_box(
                    self._view.lengths, self.picture_size, slice_directions(image)[find_front_axis(image)]
                )
            )

    def look_along(self, axis: int) -> None:
        """Look along an axis, in the orientation of the slices across it."""
        if self._view is not None and self.camera is not None:
            self.set_camera(replace(self.camera, axes=slice_directions(self._view.image)[axis]))

    def set_camera(self, camera: Camera) -> None:
        """Show the volume from another camera."""
        self.camera = camera
        self._draw_coarsely()

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Return the menu of the view; see `MenuOwner`."""
        return "" if self._view is None else "space", point or self.rect().center()

    # Qt interface

    def paintEvent(self, event: QPaintEvent) -> None:
        """Show the picture that was drawn last."""
        painter, frame = QPainter(self), self._frame
        painter.fillRect(self.rect(), theme.CANVAS_COLOR)
        if frame is not None and self._view is not None:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, frame.coarseness > 1)
            colors = frame.picture.colors
            rows, cols = frame.picture.size
            painter.drawImage(self.rect(), QImage(colors.data, cols, rows, 3 * cols, QImage.Format.Format_RGB888))
            draw_marks(painter, self._view, frame.camera.enlarged(self.width() / cols), self.size())
        elif self._view is not None:
            painter.setPen(QColor(theme.DRAWING_COLOR))
            draw_text(painter, QPointF(self.rect().center()), tr("The picture is being prepared."))
        painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the size of the volume relative to the view."""
        before = min(event.oldSize().width(), event.oldSize().height())
        if self.camera is not None and before > 0:
            self.camera = self.camera.enlarged(max(min(self.width(), self.height()), 1) / before)
        elif self.camera is not None:
            self.show_all()
        self._draw_coarsely()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin to turn, move or roll, until the button is released."""
        self._drag = event.button(), event.modifiers()
        self._pressed = self._last = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn, move or roll; a drag across the picture is half a turn."""
        camera = self.camera
        if self._pressed is None or camera is None:
            return
        way, self._last = (event.position() - self._last) * self.devicePixelRatioF(), event.position()
        button, keys = self._drag
        half_turn = pi / min(self.picture_size)
        if button != Qt.MouseButton.LeftButton or keys & Qt.KeyboardModifier.ShiftModifier:
            self.set_camera(camera.translated(way.x(), way.y()))
        elif keys & Qt.KeyboardModifier.ControlModifier:
            self.set_camera(camera.rolled(half_turn * way.x()))
        else:
            self.set_camera(camera.rotated(half_turn * way.x(), half_turn * way.y()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Pick the clicked place; a right click opens the menu."""
        begin, self._pressed = self._pressed, None
        if begin is None or (event.position() - begin).manhattanLength() > _MAX_CLICK_MOVE:
            return
        if event.button() == Qt.MouseButton.RightButton:
            reason, point = QContextMenuEvent.Reason.Other, event.position().toPoint()
            QApplication.postEvent(self, QContextMenuEvent(reason, point, event.globalPosition().toPoint()))
        elif event.button() == Qt.MouseButton.LeftButton:
            position = self._find_position(event.position())
            if position is not None:
                self.picked.emit(position)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Leave the menu to the window; the right button opens it when released without a drag."""
        event.setAccepted(event.reason() == QContextMenuEvent.Reason.Mouse)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Show the whole volume."""
        self.show_all()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Enlarge at the pointer."""
        if self.camera is not None:
            off = (event.position() - QPointF(self.rect().center())) * self.devicePixelRatioF()
            self.set_camera(self.camera.zoomed(_WHEEL_FACTOR ** event.angleDelta().y(), off.x(), off.y()))
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Turn, zoom, look along an axis, or show the whole volume."""
        key, camera = Qt.Key(event.key()), self.camera
        if camera is not None and key in _TURN_KEYS:
            self.set_camera(camera.rotated(*_TURN_KEYS[key]))
        elif camera is not None and key in _ZOOM_KEYS:
            self.set_camera(camera.zoomed(_ZOOM_KEYS[key]))
        elif key in _AXIS_KEYS:
            self.look_along(_AXIS_KEYS[key])
        elif key in _WHOLE_VIEW_KEYS:
            self.show_all()
        else:
            super().keyPressEvent(event)

    def showEvent(self, event: object) -> None:
        """Draw the view, which is not drawn while hidden."""
        self._request_picture(1)

    def _draw_coarsely(self) -> None:
        self._request_picture(min(_MAX_COARSENESS, max(1, round((self._seconds / _MAX_TURNING_TIME) ** 0.5))))

    def _request_picture(self, coarseness: int) -> None:
        """Request a picture with pixels of `coarseness` px of the screen, and later one at full resolution."""
        if self._view is None or self.camera is None or not self.isVisible():
            return
        if coarseness > 1:
            self._still.start()
        else:
            self._still.stop()
        rows, cols = (max(1, side // coarseness) for side in self.picture_size)
        self._asked += 1
        given = self._view, self.camera, (rows, cols), coarseness, self._asked
        self._painter.submit(partial(_draw_frame, self._parts, *given), self._on_picture_drawn)

    def _on_picture_drawn(self, frame: _SpaceFrame) -> None:
        """Show a finished picture."""
        if self._view is None:
            return
        self._frame = frame
        if frame.coarseness == 1:
            self._seconds = frame.seconds
        self.update()

    def _find_position(self, point: QPointF) -> Place | None:
        """Find the position [voxels] of the item seen at a point; None where there is none."""
        frame, view = self._frame, self._view
        if frame is None or view is None:
            return None
        rows, cols = frame.picture.size
        row = min(max(int(point.y() / self.height() * rows), 0), rows - 1)
        col = min(max(int(point.x() / self.width() * cols), 0), cols - 1)
        depth = float(frame.picture.depths[row, col])
        if depth >= float(EMPTY_DEPTH):
            return None
        camera = frame.camera
        place = camera.first_pixel_position((rows, cols)) + np.array([col, row, depth]) @ camera.axes / camera.scale
        return tuple((place / np.array(view.image.spacing)).tolist())


def _draw_frame(
    parts: IdentityCache,
    view: ViewInSpace,
    camera: Camera,
    size: tuple[int, int],
    coarseness: int,
    number: int,
) -> _SpaceFrame:
    """Draw a frame on the drawing thread."""
    begin, particles, seen = time.perf_counter(), view.particles, camera.enlarged(1.0 / coarseness)
    if view.is_translucent:
        picture = view.render_picture(seen, size, coarseness)
    else:  # everything except the particles is drawn only once
        still = replace(view, particles=None)
        made_of = *(getattr(still, one.name) for one in fields(still)), camera, size
        picture = parts.get_named("still", lambda: still.render_picture(seen, size, coarseness), *made_of).copy()
        view.draw_particles(picture, particles, seen, coarseness)
    return _SpaceFrame(picture, particles, seen, coarseness, number, time.perf_counter() - begin)
