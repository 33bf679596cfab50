"""A slider over a range of numbers, with a mark at the default."""

from __future__ import annotations

from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPalette, QPolygonF, QWheelEvent
from PySide6.QtWidgets import QSlider, QStyle, QStyleOptionSlider

_MARK = 3.5


class MarkedSlider(QSlider):
    """Slider in steps of a given size; a double click restores the default.

    Parameters
    ----------
    low, high, step : float
        Range and increment.
    default : float or None
        Position of the mark; None for no mark.
    """

    moved_to = Signal(float)
    """The user has moved it to a value."""
    restored = Signal()
    """The user has asked for the default."""

    def __init__(self, low: float, high: float, step: float, default: float | None) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self._default = default
        self.exact = low
        """The value that it was last given, which may lie between two steps."""
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.set_range(low, high, step)
        self.valueChanged.connect(self._moved)

    def set_range(self, low: float, high: float, step: float) -> None:
        """Change range and increment; call `show_value` afterwards."""
        self._low, self._step = low, step
        self.blockSignals(True)
        count = max(1, round((high - low) / step))
        self.setRange(0, count)
        self.setPageStep(max(1, count // 10))
        self.blockSignals(False)
        self.update()

    def move_to(self, value: float) -> None:
        """Move it to a value, as if the user had moved it."""
        if value != self.exact:
            self.show_value(value)
            self.moved_to.emit(value)

    def show_value(self, value: float) -> None:
        """Show a value without emitting a signal; one outside the range is shown at its end."""
        self.exact = value
        self.blockSignals(True)
        self.setValue(round((value - self._low) / self._step))
        self.blockSignals(False)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Change the value only while the slider has the focus; otherwise the column scrolls."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Restore the default."""
        event.accept()
        self.restored.emit()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the mark below the groove."""
        super().paintEvent(event)
        if self._default is None:
            return
        option = QStyleOptionSlider()
        self.initStyleOption(option)
        handle = self.style().subControlRect(
            QStyle.ComplexControl.CC_Slider, option, QStyle.SubControl.SC_SliderHandle, self
        )
        room = self.width() - handle.width()
        fraction = (self._default - self._low) / (self._step * max(1, self.maximum()))
        if not 0.0 <= fraction <= 1.0:
            return
        x, y = handle.width() / 2 + fraction * room, self.height() - 1.0
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.palette().color(QPalette.ColorRole.PlaceholderText))
        painter.drawPolygon(QPolygonF([QPointF(x, y - _MARK), QPointF(x - _MARK, y), QPointF(x + _MARK, y)]))
        painter.end()

    def _moved(self, value: int) -> None:
        self.exact = round(self._low + value * self._step, 9)
        self.moved_to.emit(self.exact)
