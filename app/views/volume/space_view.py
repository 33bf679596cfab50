"""The view in space: a volume with its particles and surface, which the mouse turns."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import pi, radians

import numpy as np
from PySide6.QtCore import QPointF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
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

from app.model.display.space.camera import Camera
from app.model.display.space.picture import FAR, Picture
from app.model.display.space.view_in_space import Look, ViewInSpace
from app.model.text.language import tr
from app.session.features.background import LatestOnlyWorker
from app.session.session import Session
from app.views.theme import theme
from app.views.volume.space_marks import SpaceMarks
from cpm_core.numerics.types import Array

Gesture = Callable[[Camera, float, float, int], Camera]
"""Follows the pointer, which moves to the right and down [px], in a picture whose shorter side is given [px]."""

WHOLE = (Qt.Key.Key_0, Qt.Key.Key_Home)
"""Keys that show everything."""

_STEP, _KEY_ZOOM = radians(5.0), 1.2
"""What a press of a key turns and enlarges."""

_TURNS = {
    Qt.Key.Key_Left: (-_STEP, 0.0),
    Qt.Key.Key_Right: (_STEP, 0.0),
    Qt.Key.Key_Up: (0.0, -_STEP),
    Qt.Key.Key_Down: (0.0, _STEP),
}


def turn(camera: Camera, right: float, down: float, side: int) -> Camera:
    """Turn: a drag across the picture by half a turn."""
    return camera.turned(pi * right / side, pi * down / side)


def move(camera: Camera, right: float, down: float, side: int) -> Camera:
    """Move with the pointer."""
    return camera.moved(right, down)


def roll(camera: Camera, right: float, down: float, side: int) -> Camera:
    """Roll: a drag across the picture by half a turn."""
    return camera.rolled(pi * right / side)


def gesture(button: Qt.MouseButton, keys: Qt.KeyboardModifier) -> Gesture:
    """What a drag with this button and these keys does."""
    if button != Qt.MouseButton.LeftButton or keys & Qt.KeyboardModifier.ShiftModifier:
        return move
    return roll if keys & Qt.KeyboardModifier.ControlModifier else turn


def by_key(camera: Camera, key: int, directions: Sequence[Array]) -> Camera | None:
    """The camera after a press of a key: turned, enlarged, or along an axis; None for any other key.

    `directions` are the axes of cameras that look along those of the volume.
    """
    if key in _TURNS:
        return camera.turned(*_TURNS[Qt.Key(key)])
    if key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal):
        return camera.zoomed(_KEY_ZOOM)
    if key == Qt.Key.Key_Minus:
        return camera.zoomed(1.0 / _KEY_ZOOM)
    if key in (Qt.Key.Key_1, Qt.Key.Key_2, Qt.Key.Key_3):
        return camera.along(directions[key - Qt.Key.Key_1])
    return None


_STILL = 150
"""Time without a change after which the picture is drawn at full size [ms]."""

_SMOOTH = 0.02
"""Time that a picture may take while the view turns [s]; a slower one is drawn coarser."""

_COARSEST = 4

_WHEEL = 1.0015
"""What an eighth of a degree of the wheel enlarges."""

_CLICK = 4.0
"""Distance within which a press and a release are a click [px of the screen]."""


@dataclass(frozen=True, eq=False, slots=True)
class _Frame:
    """A picture that has been drawn, and how."""

    picture: Picture
    camera: Camera
    coarseness: int
    number: int
    seconds: float

    def position(self, spacing: tuple[float, ...], right: float, down: float) -> tuple[float, float, float] | None:
        """Position [voxels] of what is seen at fractions of width and height, None where nothing is."""
        rows, cols = self.picture.size
        row, col = min(max(int(down * rows), 0), rows - 1), min(max(int(right * cols), 0), cols - 1)
        depth = float(self.picture.depths[row, col])
        if depth >= float(FAR):
            return None
        place = self.camera.corner((rows, cols)) + np.array([col, row, depth]) @ self.camera.axes / self.camera.scale
        plane, along_rows, along_cols = (place / np.array(spacing)).tolist()
        return plane, along_rows, along_cols


class SpaceView(QWidget):
    """Draws a view on a thread of its own, the newest first; coarser while something moves, in full once it is still.

    Drag to turn, with Shift or the middle button to move, with Ctrl to roll; the wheel enlarges; a double click shows
    everything again. A click on something picks the place, one with the right button opens the menu.
    """

    picked = Signal(object)
    """Position (plane, row, col) [voxels] that the user has clicked."""

    drawn = Signal()
    """A new picture is shown."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setAccessibleName(tr("View in space"))
        self.marks = SpaceMarks()
        self.camera: Camera | None = None
        self._view: ViewInSpace | None = None
        self._frame: _Frame | None = None
        self._image = QImage()
        self.look = Look(background=_rgb(theme.CANVAS))
        self._seconds, self._asked = 0.0, 0
        self._pressed: QPointF | None = None
        self._last = QPointF()
        self._gesture: Gesture = turn
        self._painter = LatestOnlyWorker(session, "cpm-space", tr("drawing the view in space"))
        self._painter.done.connect(self._take)
        self._still = QTimer(self, interval=_STILL, singleShot=True)
        self._still.timeout.connect(partial(self._ask, 1))

    def sizeHint(self) -> QSize:
        """A square."""
        return QSize(420, 420)

    def show_view(self, view: ViewInSpace | None) -> None:
        """Show something else; one of another size is seen as a whole, otherwise the camera stays."""
        before, self._view = self._view, view
        if view is None:
            self._frame, self.camera = None, None
            self.update()
            return
        if before is None or self.camera is None or before.lengths != view.lengths:
            self.show_all()
        else:
            self._changed()

    @property
    def idle(self) -> bool:
        """Whether the picture shows all that was asked for, in full."""
        shown = 0 if self._frame is None else self._frame.number
        return not self._still.isActive() and (self._view is None or shown == self._asked)

    @property
    def room(self) -> tuple[int, int]:
        """Rows and columns of the picture in full."""
        ratio = self.devicePixelRatioF()
        return max(1, round(self.height() * ratio)), max(1, round(self.width() * ratio))

    def show_all(self) -> None:
        """See the whole volume from where it is seen first."""
        if self._view is not None:
            self.use(Camera.on(self._view.lengths, self.room, self._view.directions[self._view.front]))

    def look_along(self, axis: int) -> None:
        """See the volume as its slices across an axis lie."""
        if self._view is not None and self.camera is not None:
            self.use(self.camera.along(self._view.directions[axis]))

    def use(self, camera: Camera) -> None:
        """See the volume from elsewhere."""
        self.camera = camera
        self._changed()

    def picture(self) -> QImage:
        """The picture as it is seen, with its marks."""
        return self.grab().toImage()

    def close_thread(self) -> None:
        """End the thread that draws."""
        self._still.stop()
        self._painter.close()

    # Qt interface

    def paintEvent(self, event: QPaintEvent) -> None:
        """Show the picture that was drawn last."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), theme.CANVAS)
        if self._frame is not None and self._view is not None:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, self._frame.coarseness > 1)
            painter.drawImage(self.rect(), self._image)
            camera = self._frame.camera.enlarged(self.width() / self._frame.picture.size[1])
            self.marks.draw(painter, self._view, camera, self.size())
        elif self._view is not None:
            self.marks.wait(painter, self.size())
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
        self._gesture = gesture(event.button(), event.modifiers())
        self._pressed = self._last = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn, move or roll."""
        if self._pressed is not None and self.camera is not None:
            way, self._last = event.position() - self._last, event.position()
            ratio = self.devicePixelRatioF()
            self.use(self._gesture(self.camera, way.x() * ratio, way.y() * ratio, min(self.room)))

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
        """Turn, enlarge, or look along an axis."""
        view, now = self._view, self.camera
        camera = None if view is None or now is None else by_key(now, event.key(), view.directions)
        if camera is not None:
            self.use(camera)
        elif event.key() in WHOLE:
            self.show_all()
        else:
            super().keyPressEvent(event)

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
        size = self.room
        coarse = max(1, size[0] // coarseness), max(1, size[1] // coarseness)
        self._asked += 1
        self._painter.ask(partial(_draw, self._view, self.camera, coarse, coarseness, self.look, self._asked))

    def _take(self, frame: _Frame) -> None:
        """Show a picture that has been drawn."""
        if self._view is None:
            return
        self._frame = frame
        if frame.coarseness == 1:
            self._seconds = frame.seconds
        colors = frame.picture.colors
        self._image = QImage(
            colors.data, colors.shape[1], colors.shape[0], 3 * colors.shape[1], QImage.Format.Format_RGB888
        )
        self.update()
        self.drawn.emit()

    def showEvent(self, event: object) -> None:
        """Draw what was not drawn while it was hidden."""
        self._ask(1)

    def _at(self, point: QPointF) -> tuple[float, float, float] | None:
        """Position [voxels] of what is seen at a point, None where nothing is."""
        if self._frame is None or self._view is None:
            return None
        return self._frame.position(self._view.spacing, point.x() / self.width(), point.y() / self.height())


def _draw(view: ViewInSpace, camera: Camera, size: tuple[int, int], coarseness: int, look: Look, number: int) -> _Frame:
    """Draw on the thread."""
    begin = time.perf_counter()
    seen = camera.enlarged(1.0 / coarseness)
    finer = Look(look.background, look.edges, look.outside, look.inside, max(look.radius / coarseness, 0.6))
    return _Frame(view.drawn(seen, size, finer), seen, coarseness, number, time.perf_counter() - begin)


def _rgb(color: str) -> tuple[int, int, int]:
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
