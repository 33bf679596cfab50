"""A threshold on the contours: a slider below the histogram of their values."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QRectF, QSize, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from app.model.display.filter_counts import Distribution
from app.model.parameters.controls import Control
from app.model.text.language import written
from app.views.widgets.fields.marked_slider import MarkedSlider

_BINS = 40
_STEP = 1 / 200
_LEAST = 10.0


class Histogram(QWidget):
    """A histogram; bars below the threshold are pale."""

    def __init__(self) -> None:
        super().__init__()
        self._counts = np.zeros(_BINS, int)
        self._threshold = 0.0
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """About two lines of text high."""
        return QSize(160, 30)

    def show(self, shares: np.ndarray, threshold: float) -> None:  # type: ignore[override]  # shows values, not itself
        """Show values, each as its position along the slider from 0 to 1."""
        self._counts = np.histogram(shares, _BINS, (0.0, 1.0))[0]
        self._threshold = threshold
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw a bar for each bin that is not empty."""
        painter = QPainter(self)
        palette = self.palette()
        # The groove of the slider below starts and ends half a handle from its sides.
        inset = 6.0
        width, height = (self.width() - 2 * inset) / _BINS, self.height() - 1.0
        most = max(1, int(self._counts.max()))
        for index, count in enumerate(self._counts.tolist()):
            if count:
                role = QPalette.ColorRole.Highlight if (index + 1) / _BINS > self._threshold else QPalette.ColorRole.Mid
                # the root keeps a single value visible beside hundreds
                tall = max(3.0, height * math.sqrt(count / most))
                painter.fillRect(
                    QRectF(inset + index * width, height - tall, max(1.5, width - 1), tall), palette.color(role)
                )
        painter.setPen(palette.color(QPalette.ColorRole.Mid))
        painter.drawLine(int(inset), self.height() - 1, self.width() - int(inset), self.height() - 1)
        painter.end()


class Threshold(QWidget):
    """Lower limit of a measure of contours, set by a slider that is finer for small values."""

    moved_to = Signal(float)
    """The user has moved the slider to a value."""
    released = Signal()
    """The user has released the slider."""

    def __init__(self, control: Control) -> None:
        super().__init__()
        self.title, self._unit = control.title, control.unit
        self._top = _LEAST
        self._value = 0.0
        self._distribution = Distribution()
        self.histogram = Histogram()
        self.slider = MarkedSlider(0.0, 1.0, _STEP, None)
        self.slider.setAccessibleName(self.title)
        self.label = QLabel()
        self.setToolTip(f"{control.meaning} {control.acts}")
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(0)
        grid.addWidget(QLabel(self.title), 0, 0)
        grid.addWidget(self.label, 0, 1)
        grid.addWidget(self.histogram, 1, 0, 1, 2)
        grid.addWidget(self.slider, 2, 0, 1, 2)
        grid.setColumnStretch(0, 1)
        self.slider.moved_to.connect(lambda share: self._report(self._top * share**2))
        self.slider.restored.connect(lambda: self._report(0.0))
        self.slider.sliderReleased.connect(self.released)
        self._show()

    def show_values(self, moment: object, values: Sequence[float]) -> None:
        """Show the values of the present contours.

        `moment` identifies the state that the contours were reconstructed from. While it stays the same, values that
        the threshold has excluded are remembered, so that the user sees the whole distribution.
        """
        self._distribution.update(moment, self._value, values)
        self._show()

    def show_value(self, value: float) -> None:
        """Show the present threshold."""
        if value != self._value:
            self._value = value
            self._show()

    def _report(self, value: float) -> None:
        self.moved_to.emit(float(f"{value:.3g}"))

    def _show(self) -> None:
        values = self._distribution.values
        self._top = _nice(max([_LEAST, self._value, *values[-1:].tolist()]))
        share = math.sqrt(self._value / self._top)
        if not self.slider.isSliderDown():
            self.slider.show_value(share)
        self.histogram.show(np.sqrt(values / self._top), share)
        self.label.setText(written(f"{self._value:.3g} {self._unit}"))


def _nice(value: float) -> float:
    """Round up to the next of 1, 2, 5, 10, 20, …, so that the range rarely changes."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value)
