"""The chart of a run: stacked plots with the step as common axis, and a cursor that reads them."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QSize, Qt
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPaintEvent
from PySide6.QtWidgets import QWidget

from app.model.display.plots import PLOTS, Plot, RunMetrics, figure
from app.model.text.language import tr, written
from app.views.panels.run.chart_painter import ChartPainter, sides

_PAGE = 10
_LOWEST, _LOW = 96, 44
"""Minimum heights of the chart, and of a plot with its gap [px]."""


class Chart(QWidget):
    """Plots the metrics of a run; the pointer or the arrow keys choose the step whose values are read."""

    def __init__(self) -> None:
        super().__init__()
        self._metrics: RunMetrics | None = None
        self._plots: tuple[Plot, ...] = tuple(plot for plot in PLOTS if plot.first)
        self._read: int | None = None
        self.setMinimumHeight(_LOWEST)
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName(tr("Plot of the run over its steps"))

    def sizeHint(self) -> QSize:
        """Wide and low."""
        return QSize(300, 150)

    @property
    def reading(self) -> str:
        """The values at the step that is read; empty if there is none."""
        metrics, index = self._metrics, self._read
        if metrics is None or index is None:
            return ""
        values = [f"{one.title} {figure(float(one.of(metrics)[index]))}" for plot in self._plots for one in plot.series]
        return ", ".join([tr("step {step}").format(step=written(f"{metrics.step[index]:,.0f}")), *values])

    def show_metrics(self, metrics: RunMetrics | None) -> None:
        """Show a run, or none."""
        self._metrics = metrics if metrics is not None and len(metrics.step) else None
        last = len(self._metrics.step) - 1 if self._metrics is not None else -1
        if self._read is not None and self._read > last:
            self._read = None
        self.update()

    def show_plots(self, plots: Sequence[Plot]) -> None:
        """Show these plots."""
        self._plots = tuple(plots)
        self.setMinimumHeight(max(_LOWEST, _LOW * len(self._plots) + self.fontMetrics().height()))
        self.update()

    def read(self, index: int | None) -> None:
        """Read the values of one entry of the metrics, or of none."""
        if index is not None and self._metrics is not None:
            index = min(max(index, 0), len(self._metrics.step) - 1)
        self._read = index if self._metrics is not None else None
        self.setAccessibleDescription(self.reading)
        self.update()

    def point(self, index: int) -> QPointF:
        """Position of an entry of the metrics in the uppermost plot."""
        left, width = sides(self)
        last = len(self._metrics.step) - 1 if self._metrics is not None else 0
        return QPointF(left + width * index / max(last, 1), _LOW / 2)

    # Qt interface

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Read the step under the pointer."""
        if self._metrics is not None:
            left, width = sides(self)
            self.read(round((event.position().x() - left) / width * (len(self._metrics.step) - 1)))

    def leaveEvent(self, event: QEvent) -> None:
        """Stop reading."""
        self.read(None)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Stop reading."""
        self.read(None)
        super().focusOutEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the cursor by steps."""
        last = len(self._metrics.step) - 1 if self._metrics is not None else 0
        at = self._read if self._read is not None else last
        stride = _PAGE if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        targets = {
            Qt.Key.Key_Left: at - stride,
            Qt.Key.Key_Right: at + stride,
            Qt.Key.Key_Home: 0,
            Qt.Key.Key_End: last,
            Qt.Key.Key_Escape: None,
        }
        key = Qt.Key(event.key())
        if key in targets:
            self.read(targets[key])
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw all plots."""
        ChartPainter(self, self._plots, self._metrics, self._read).draw()
