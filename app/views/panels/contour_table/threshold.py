"""A threshold on the contours: a slider below the histogram of what it chooses among."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QRectF, QSize, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from app.views.widgets.marked_slider import MarkedSlider

_BINS = 40
_STEP = 1 / 200
_LEAST = 10.0


class Histogram(QWidget):
    """Bars that tell how many values there are of which size; those below the threshold are pale."""

    def __init__(self) -> None:
        super().__init__()
        self._counts = np.zeros(_BINS, int)
        self._threshold = 0.0
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """As high as two lines of text."""
        return QSize(160, 30)

    def show(self, shares: np.ndarray, threshold: float) -> None:  # type: ignore[override]  # of values, not of itself
        """Show values, each as its share of the way along the slider."""
        self._counts = np.histogram(shares, _BINS, (0.0, 1.0))[0]
        self._threshold = threshold
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw a bar for each size that there is."""
        painter = QPainter(self)
        palette = self.palette()
        # The groove of the slider below begins and ends half a handle inside.
        inset = 6.0
        width, height = (self.width() - 2 * inset) / _BINS, self.height() - 1.0
        most = max(1, int(self._counts.max()))
        for index, count in enumerate(self._counts.tolist()):
            if count:
                role = QPalette.ColorRole.Highlight if (index + 1) / _BINS > self._threshold else QPalette.ColorRole.Mid
                tall = max(3.0, height * math.sqrt(count / most))  # the root lets a single one be seen beside hundreds
                painter.fillRect(
                    QRectF(inset + index * width, height - tall, max(1.5, width - 1), tall), palette.color(role)
                )
        painter.setPen(palette.color(QPalette.ColorRole.Mid))
        painter.drawLine(int(inset), self.height() - 1, self.width() - int(inset), self.height() - 1)
        painter.end()


class Threshold(QWidget):
    """Least value of contours, set by a slider with more room for small values."""

    moved_to = Signal(float)
    """The user has moved it to a value."""
    settled = Signal()
    """The user has let go of it."""

    def __init__(self, title: str, unit: str, tip: str) -> None:
        super().__init__()
        self._unit = unit
        self._top = _LEAST
        self._value = 0.0
        self._known: tuple[object, float, np.ndarray] = (None, 0.0, np.empty(0))
        self.histogram = Histogram()
        self.slider = MarkedSlider(0.0, 1.0, _STEP, None)
        self.slider.setAccessibleName(title)
        self.label = QLabel()
        self.setToolTip(tip)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(0)
        grid.addWidget(QLabel(title), 0, 0)
        grid.addWidget(self.label, 0, 1)
        grid.addWidget(self.histogram, 1, 0, 1, 2)
        grid.addWidget(self.slider, 2, 0, 1, 2)
        grid.setColumnStretch(0, 1)
        self.slider.moved_to.connect(lambda share: self._tell(self._top * share**2))
        self.slider.restored.connect(lambda: self._tell(0.0))
        self.slider.sliderReleased.connect(self.settled)
        self._show()

    def show_values(self, moment: object, values: Sequence[float]) -> None:
        """Show the values of the present contours.

        As long as `moment`, which identifies what the contours were made from, stays the same, values that the threshold
        has excluded are remembered, so that the user sees the whole distribution.
        """
        known, below, before = self._known
        now = np.asarray(values, dtype=float)
        if moment is not None and moment == known and below < self._value:
            # What the newest threshold leaves out may still be there: contours follow a moment later.
            left_out = (before < self._value) & ~np.isin(before, now)
            now = np.concatenate([now, before[left_out]])
            self._known = (moment, below, np.sort(now))
        else:
            self._known = (moment, self._value, np.sort(now))
        self._show()

    def show_value(self, value: float) -> None:
        """Show the threshold that is in force."""
        if value != self._value:
            self._value = value
            self._show()

    def _tell(self, value: float) -> None:
        self.moved_to.emit(float(f"{value:.3g}"))

    def _show(self) -> None:
        values = self._known[2]
        self._top = _nice(max([_LEAST, self._value, *values[-1:].tolist()]))
        share = math.sqrt(self._value / self._top)
        if not self.slider.isSliderDown():
            self.slider.show_value(share)
        self.histogram.show(np.sqrt(values / self._top), share)
        self.label.setText(f"{self._value:.3g} {self._unit}")


def _nice(value: float) -> float:
    """The next of 1, 2, 5, 10, 20, … that is no smaller, so that the range seldom changes."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value)
