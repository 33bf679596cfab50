"""The view in space: a volume with its particles and surface, which the mouse turns."""

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
from cpm_app.model.space.picture import FAR, Picture
from cpm_app.model.space.view_in_space import Particles, ViewInSpace
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import directions_of, first_seen
from cpm_app.session.features.background import IdentityCache, LatestOnlyWorker
from cpm_app.session.session import Session
from cpm_app.views.theme import theme
from cpm_app.views.volume.space_marks import LOOK, draw_marks, write
from cpm_core.numerics import Array, Place
from cpm_core.numerics.types import record

_STEP, _ZOOM = radians(5.0), 1.2
"""What a press of a key turns and enlarges."""

_TURNS = {
    Qt.Key.Key_Left: (-_STEP, 0.0),
    Qt.Key.Key_Right: (_STEP, 0.0),
    Qt.Key.Key_Up: (0.0, -_STEP),
    Qt.Key.Key_Down: (0.0, _STEP),
}
_ZOOMS = {Qt.Key.Key_Plus: _ZOOM, Qt.Key.Key_Equal: _ZOOM, Qt.Key.Key_Minus: 1.0 / _ZOOM}
_AXES = {Qt.Key.Key_1: 0, Qt.Key.Key_2: 1, Qt.Key.Key_3: 2}
_WHOLE = (Qt.Key.Key_0, Qt.Key.Key_Home)

_STILL = 150
"""Time without a change after which the picture is drawn at full size [ms]."""

_SMOOTH = 0.02
"""Time that a picture may take while the view turns [s]; a slower one is drawn coarser."""

_COARSEST = 4

_WHEEL = 1.0015
"""What an eighth of a degree of the wheel enlarges."""

_CLICK = 4.0
"""Distance within which a press and a release are a click [px of the screen]."""


@record
class _Frame:
    """A picture that has been drawn, of which particles, and how."""

    picture: Picture
    particles: Particles | None
    camera: Camera
    coarseness: int
    number: int
    seconds: float


class SpaceView(QWidget):
    """Draws a view on a thread of its own, the newest first; coarser while something moves, in full once it is still.

    Drag to turn, with Shift or the middle button to move, with Ctrl to roll; the wheel enlarges; a double click shows
    everything again. A click on something picks the place, one with the right button opens the menu.
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
        self._frame: _Frame | None = None
        self._seconds, self._asked = 0.0, 0
        self._pressed: QPointF | None = None
        self._last = QPointF()
        self._drag = (Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier)
        self._painter = LatestOnlyWorker(session, "cpm-space", tr("drawing the view in space"))
        self._still = QTimer(self, interval=_STILL, singleShot=True)
        self._still.timeout.connect(partial(self._ask, 1))
        self._parts = IdentityCache()

    def sizeHint(self) -> QSize:
        """A square."""
        return QSize(420, 420)

    def show_view(self, view: ViewInSpace | None) -> None:
        """Show something else; one of another size is seen as a whole, otherwise the camera stays."""
        before, self._view = self._view, view
        if view is None:
            self._frame, self.camera = None, None
            self.update()
        elif before is None or self.camera is None or before.lengths != view.lengths:
            self.show_all()
        else:
            self._changed()

    @property
    def idle(self) -> bool:
        """Whether the picture shows all that was asked for, in full."""
        shown = 0 if self._frame is None else self._frame.number
        return not self._still.isActive() and (self._view is None or shown == self._asked)

    @property
    def positions(self) -> Array | None:
        """Positions of the particles in the picture [voxels]; None without any."""
        return None if self._frame is None or self._frame.particles is None else self._frame.particles.positions

    @property
    def room(self) -> tuple[int, int]:
        """Rows and columns of the picture in full."""
        ratio = self.devicePixelRatioF()
        return max(1, round(self.height() * ratio)), max(1, round(self.width() * ratio))

    def show_all(self) -> None:
        """See the whole volume from where it is seen first."""
        if self._view is not None:
            image = self._view.image
            self.use(Camera.on(self._view.lengths, self.room, directions_of(image)[first_seen(image)]))

    def look_along(self, axis: int) -> None:
        """See the volume as its slices across an axis lie."""
        if self._view is not None and self.camera is not None:
            self.use(replace(self.camera, axes=directions_of(self._view.image)[axis]))

    def use(self, camera: Camera) -> None:
        """See the volume from elsewhere."""
        self.camera = camera
        self._changed()

    def close_thread(self) -> None:
        """End the thread that draws."""
        self._still.stop()
        self._painter.close()

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Its menu; see `MenuOwner`."""
        return "" if self._view is None else "space", point or self.rect().center()

    # Qt interface

    def paintEvent(self, event: QPaintEvent) -> None:
        """Show the picture that was drawn last."""
        painter, frame = QPainter(self), self._frame
        painter.fillRect(self.rect(), theme.CANVAS)
        if frame is not None and self._view is not None:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, frame.coarseness > 1)
            colors = frame.picture.colors
            rows, cols = frame.picture.size
            painter.drawImage(self.rect(), QImage(colors.data, cols, rows, 3 * cols, QImage.Format.Format_RGB888))
            draw_marks(painter, self._view, frame.camera.enlarged(self.width() / cols), self.size())
        elif self._view is not None:
            painter.setPen(QColor(theme.DRAWING))
            write(painter, QPointF(self.rect().center()), tr("The picture is being prepared."))
        painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the volume as large in the view as it was."""
        before = min(event.oldSize().width(), event.oldSize().height())
        if self.camera is not None and before > 0:
            self.camera = self.camera.enlarged(max(min(self.width(), self.height()), 1) / before)
        elif self.camera is not None:
            self.show_all()
        self._changed()

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
        half_turn = pi / min(self.room)
        if button != Qt.MouseButton.LeftButton or keys & Qt.KeyboardModifier.ShiftModifier:
            self.use(camera.moved(way.x(), way.y()))
        elif keys & Qt.KeyboardModifier.ControlModifier:
            self.use(camera.rolled(half_turn * way.x()))
        else:
            self.use(camera.turned(half_turn * way.x(), half_turn * way.y()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Pick what was clicked; a click of the right button opens the menu."""
        begin, self._pressed = self._pressed, None
        if begin is None or (event.position() - begin).manhattanLength() > _CLICK:
            return
        if event.button() == Qt.MouseButton.RightButton:
            reason, point = QContextMenuEvent.Reason.Other, event.position().toPoint()
            QApplication.postEvent(self, QContextMenuEvent(reason, point, event.globalPosition().toPoint()))
        elif event.button() == Qt.MouseButton.LeftButton:
            position = self._at(event.position())
            if position is not None:
                self.picked.emit(position)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Leave the menu to the window; the right button opens it when it is released without a drag."""
        event.setAccepted(event.reason() == QContextMenuEvent.Reason.Mouse)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """See everything."""
        self.show_all()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Enlarge at the pointer."""
        if self.camera is not None:
            off = (event.position() - QPointF(self.rect().center())) * self.devicePixelRatioF()
            self.use(self.camera.zoomed(_WHEEL ** event.angleDelta().y(), off.x(), off.y()))
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Turn, enlarge, look along an axis, or see everything."""
        key, camera = Qt.Key(event.key()), self.camera
        if camera is not None and key in _TURNS:
            self.use(camera.turned(*_TURNS[key]))
        elif camera is not None and key in _ZOOMS:
            self.use(camera.zoomed(_ZOOMS[key]))
        elif key in _AXES:
            self.look_along(_AXES[key])
        elif key in _WHOLE:
            self.show_all()
        else:
            super().keyPressEvent(event)

    def showEvent(self, event: object) -> None:
        """Draw what was not drawn while it was hidden."""
        self._ask(1)

    def _changed(self) -> None:
        self._ask(min(_COARSEST, max(1, round((self._seconds / _SMOOTH) ** 0.5))))

    def _ask(self, coarseness: int) -> None:
        """Draw with one pixel for so many of the screen; in full after a while without a change."""
        if self._view is None or self.camera is None or not self.isVisible():
            return
        if coarseness > 1:
            self._still.start()
        else:
            self._still.stop()
        rows, cols = (max(1, side // coarseness) for side in self.room)
        self._asked += 1
        given = self._view, self.camera, (rows, cols), coarseness, self._asked
        self._painter.ask(partial(_draw, self._parts, *given), self._take)

    def _take(self, frame: _Frame) -> None:
        """Show a picture that has been drawn."""
        if self._view is None:
            return
        self._frame = frame
        if frame.coarseness == 1:
            self._seconds = frame.seconds
        self.update()

    def _at(self, point: QPointF) -> Place | None:
        """Position [voxels] of what is seen at a point, None where nothing is."""
        frame, view = self._frame, self._view
        if frame is None or view is None:
            return None
        rows, cols = frame.picture.size
        row = min(max(int(point.y() / self.height() * rows), 0), rows - 1)
        col = min(max(int(point.x() / self.width() * cols), 0), cols - 1)
        depth = float(frame.picture.depths[row, col])
        if depth >= float(FAR):
            return None
        camera = frame.camera
        place = camera.corner((rows, cols)) + np.array([col, row, depth]) @ camera.axes / camera.scale
        return tuple((place / np.array(view.image.spacing)).tolist())


def _draw(
    parts: IdentityCache,
    view: ViewInSpace,
    camera: Camera,
    size: tuple[int, int],
    coarseness: int,
    number: int,
) -> _Frame:
    """Draw on the thread."""
    begin, particles = time.perf_counter(), view.particles
    look, seen = replace(LOOK, radius=max(LOOK.radius / coarseness, 0.6)), camera.enlarged(1.0 / coarseness)
    if view.shown.opacity < 1.0:
        picture = view.drawn(seen, size, look)
    else:  # what does not flow is drawn only once
        still = replace(view, particles=None)
        made_of = *(getattr(still, one.name) for one in fields(still)), camera, size
        picture = parts.named("still", lambda: still.drawn(seen, size, look), *made_of).copy()
        view.draw_particles(picture, particles, seen, look)
    return _Frame(picture, particles, seen, coarseness, number, time.perf_counter() - begin)
