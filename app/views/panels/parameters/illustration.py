"""The small animated illustration of the effect of a parameter at its value."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QSize, Qt, QTimer
from PySide6.QtGui import QColor, QHideEvent, QImage, QPainter, QPaintEvent, QShowEvent
from PySide6.QtWidgets import QWidget

from app.views.panels.parameters.illustrations import ILLUSTRATIONS
from app.views.panels.parameters.illustrations.sketch import HEIGHT, WIDTH, Sketch
from app.views.theme import theme

_EVERY, _LOOP = 40, 4000
"""Time between two frames, and duration of the loop [ms]."""

_HELD = 0.15
"""Fraction of the loop for which its last frame is held."""

STILL = 0.72
"""Time in the loop, from 0 to 1, that is shown without animation."""

_AUTOMATIC = 2.0
"""Value drawn for ``"auto"``."""


class Illustration(QWidget):
    """Shows one control; animated only while visible, and never if the user has turned animation off."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedSize(QSize(round(WIDTH), round(HEIGHT)))
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent, False)
        self._name = next(iter(ILLUSTRATIONS))
        self._value = 0.0
        self._animated = True
        self._clock = QElapsedTimer()
        self._clock.start()
        self._timer = QTimer(self)
        self._timer.setInterval(_EVERY)
        self._timer.timeout.connect(self.update)

    @property
    def moving(self) -> bool:
        """Whether it is animated; not behind another panel, where Qt still counts it as visible."""
        return self._timer.isActive() and not self.visibleRegion().isEmpty()

    def show_control(self, name: str, value: float | str) -> None:
        """Show the control of this name at a value; a different control starts its loop again."""
        if name != self._name:
            self._name = name
            self._clock.restart()
        self._value = _AUTOMATIC if isinstance(value, str) else float(value)
        self.update()

    def set_animated(self, animated: bool) -> None:
        """Turn animation on or off."""
        self._animated = animated
        self._update_timer()
        self.update()

    def picture(self, time: float) -> QImage:
        """The frame at a time of the loop, from 0 to 1."""
        image = QImage(self.size(), QImage.Format.Format_ARGB32_Premultiplied)
        image.fill(QColor(theme.CANVAS))
        painter = QPainter(image)
        self._draw(painter, time)
        painter.end()
        return image

    def showEvent(self, event: QShowEvent) -> None:
        """Start the animation."""
        super().showEvent(event)
        self._update_timer()

    def hideEvent(self, event: QHideEvent) -> None:
        """Stop the animation."""
        super().hideEvent(event)
        self._timer.stop()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the present frame."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.CANVAS))
        painter.drawRoundedRect(self.rect(), 6, 6)
        self._draw(painter, self._time() if self._animated else STILL)
        painter.end()

    def _draw(self, painter: QPainter, time: float) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        ILLUSTRATIONS[self._name](Sketch(painter), self._value, time)

    def _time(self) -> float:
        share = (self._clock.elapsed() % _LOOP) / _LOOP
        return min(1.0, share / (1.0 - _HELD))

    def _update_timer(self) -> None:
        wanted = self._animated and self.isVisible()
        if wanted != self._timer.isActive():
            (self._timer.start if wanted else self._timer.stop)()
