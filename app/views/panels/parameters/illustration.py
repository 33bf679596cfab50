"""The small animated illustration that shows what a parameter does at the value that it has."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QSize, Qt, QTimer
from PySide6.QtGui import QColor, QHideEvent, QImage, QPainter, QPaintEvent, QShowEvent
from PySide6.QtWidgets import QWidget

from app.views.panels.parameters.illustrations import ILLUSTRATIONS
from app.views.panels.parameters.illustrations.sketch import HEIGHT, WIDTH, Sketch
from app.views.theme import theme

_EVERY, _LOOP = 40, 4000
"""Time between two pictures, and of the whole loop [ms]."""

_HELD = 0.15
"""Share of the loop for which its end is held, so that it can be looked at."""

STILL = 0.72
"""Moment that is shown where nothing is to move."""

_AUTOMATIC = 2.0
"""Value drawn for one that is left to the program."""


class Illustration(QWidget):
    """Draws one control; it moves only while it is seen, and not at all where a person prefers so."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedSize(QSize(round(WIDTH), round(HEIGHT)))
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent, False)
        self._name = next(iter(ILLUSTRATIONS))
        self._value = 0.0
        self._moves = True
        self._clock = QElapsedTimer()
        self._clock.start()
        self._timer = QTimer(self)
        self._timer.setInterval(_EVERY)
        self._timer.timeout.connect(self.update)

    @property
    def moving(self) -> bool:
        """Whether it is being drawn again and again; behind another panel nothing is, though it counts as shown."""
        return self._timer.isActive() and not self.visibleRegion().isEmpty()

    def show_control(self, name: str, value: float | str) -> None:
        """Draw the control of this name at a value; another control begins its loop anew."""
        if name != self._name:
            self._name = name
            self._clock.restart()
        self._value = _AUTOMATIC if isinstance(value, str) else float(value)
        self.update()

    def set_motion(self, moves: bool) -> None:
        """Let it move, or not."""
        self._moves = moves
        self._beat()
        self.update()

    def picture(self, moment: float) -> QImage:
        """What it shows at a moment of its loop, from 0 to 1."""
        image = QImage(self.size(), QImage.Format.Format_ARGB32_Premultiplied)
        image.fill(QColor(theme.CANVAS))
        painter = QPainter(image)
        self._draw(painter, moment)
        painter.end()
        return image

    def showEvent(self, event: QShowEvent) -> None:
        """Begin to move."""
        super().showEvent(event)
        self._beat()

    def hideEvent(self, event: QHideEvent) -> None:
        """Rest: nobody looks."""
        super().hideEvent(event)
        self._timer.stop()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw what is seen now."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.CANVAS))
        painter.drawRoundedRect(self.rect(), 6, 6)
        self._draw(painter, self._moment() if self._moves else STILL)
        painter.end()

    def _draw(self, painter: QPainter, moment: float) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        ILLUSTRATIONS[self._name](Sketch(painter), self._value, moment)

    def _moment(self) -> float:
        share = (self._clock.elapsed() % _LOOP) / _LOOP
        return min(1.0, share / (1.0 - _HELD))

    def _beat(self) -> None:
        wanted = self._moves and self.isVisible()
        if wanted != self._timer.isActive():
            (self._timer.start if wanted else self._timer.stop)()
