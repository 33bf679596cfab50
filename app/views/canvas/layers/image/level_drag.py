"""A drag with the right button and Ctrl that changes the window of gray values: to the right wider, up to darker."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QCursor, QMouseEvent
from PySide6.QtWidgets import QWidget

from app.views.canvas.layers.image.image import ImageLayer

_REACH = 400.0
"""A drag by so much changes width or middle by the whole range [px of the screen]."""

_NARROWEST = 1e-3
"""Least width of the window, as a part of the range."""

Window = tuple[float, float]


def dragged(window: Window, ends: Window, right: float, down: float) -> Window:
    """The window of gray values after a drag to the right and down [px of the screen], within the whole range."""
    span = ends[1] - ends[0]
    width = window[1] - window[0] + span * right / _REACH
    width = min(max(width, _NARROWEST * span), span)
    middle = 0.5 * (window[0] + window[1]) - span * down / _REACH
    middle = min(max(middle, ends[0]), ends[1])
    return max(middle - 0.5 * width, ends[0]), min(middle + 0.5 * width, ends[1])


class LevelDrag(QObject):
    """Takes such drags from a widget, and others that it watches, and moves the window of a layer."""

    moved = Signal()
    """The window follows the pointer."""
    ended = Signal()
    """The button has been released."""

    def __init__(self, layer: ImageLayer, widget: QWidget) -> None:
        super().__init__(widget)
        self.watch(widget)
        self._layer = layer
        self._from: QPointF | None = None
        self._window: Window = (0.0, 1.0)
        self._cursor = QCursor()

    def watch(self, widget: QWidget) -> None:
        """Take the drags of a widget that shows the image."""
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Begin, follow and end a drag."""
        if not isinstance(event, QMouseEvent) or not isinstance(watched, QWidget):
            return False
        kind, right = event.type(), Qt.MouseButton.RightButton
        begins = event.button() == right and bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        if kind == QEvent.Type.MouseButtonPress and begins and self._layer.scene.image is not None:
            self._from, self._window = event.position(), self._layer.window
            self._cursor = watched.cursor()
            watched.setCursor(Qt.CursorShape.SizeAllCursor)
            return True
        if self._from is None:
            return False
        if kind == QEvent.Type.MouseMove:
            way = event.position() - self._from
            self._layer.choose_window(*dragged(self._window, self._layer.ends, way.x(), way.y()))
            self.moved.emit()
            return True
        if kind == QEvent.Type.MouseButtonRelease and event.button() == right:
            self._from = None
            watched.setCursor(self._cursor)
            self.ended.emit()
            return True
        return False
