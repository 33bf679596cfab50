"""The chart of a run: plots above each other with the step as their common axis, and a line that reads them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from app.model.display.plots import PLOTS, Axis, Plot, figure
from app.model.text.language import tr
from app.session.exchange.messages import RunMetrics
from cpm_core.numerics.types import Array

_GAP, _RIGHT = 9.0, 8.0
_PAGE = 10
_LOWEST, _LOW = 96, 36
"""Least heights of the chart, and of a plot with its gap [px]."""


class Chart(QWidget):
    """Draws a trace; pointer or arrow keys choose the step whose figures are read."""

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
        """The figures at the step that is read, empty when none is."""
        metrics, index = self._metrics, self._read
        if metrics is None or index is None:
            return ""
        figures = [
            f"{one.title} {figure(float(one.of(metrics)[index]))}" for plot in self._plots for one in plot.series
        ]
        return ", ".join([tr("step {step}").format(step=f"{metrics.step[index]:,.0f}"), *figures])

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
        """Read the figures of an entry of the trace, or none."""
        if index is not None and self._metrics is not None:
            index = min(max(index, 0), len(self._metrics.step) - 1)
        self._read = index if self._metrics is not None else None
        self.setAccessibleDescription(self.reading)
        self.update()

    # What Qt calls

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Read the step under the pointer."""
        if self._metrics is not None:
            left, width = self._sides()
            self.read(round((event.position().x() - left) / width * (len(self._metrics.step) - 1)))

    def leaveEvent(self, event: QEvent) -> None:
        """Read no more."""
        self.read(None)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Read no more."""
        self.read(None)
        super().focusOutEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Lead the line step by step."""
        last = len(self._metrics.step) - 1 if self._metrics is not None else 0
        at = self._read if self._read is not None else last
        stride = _PAGE if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        ways = {
            Qt.Key.Key_Left: at - stride,
            Qt.Key.Key_Right: at + stride,
            Qt.Key.Key_Home: 0,
            Qt.Key.Key_End: last,
            Qt.Key.Key_Escape: None,
        }
        key = Qt.Key(event.key())
        if key in ways:
            self.read(ways[key])
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw all plots."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        font = painter.font()
        font.setPointSizeF(max(6.5, font.pointSizeF() - 1.5))
        painter.setFont(font)
        left, width = self._sides()
        below = painter.fontMetrics().height() + 2.0
        count = max(len(self._plots), 1)
        height = (self.height() - below - 2.0 - (count - 1) * _GAP) / count
        box = QRectF()
        for index, plot in enumerate(self._plots):
            box = QRectF(left, 2.0 + index * (height + _GAP), width, height)
            self._draw_plot(painter, box, plot, first=index == 0)
        if self._plots:
            self._draw_steps(painter, box)
        painter.end()

    # Inside

    def _sides(self) -> tuple[float, float]:
        """Left side and width of the plots."""
        left = self.fontMetrics().horizontalAdvance("10000") + 4.0
        return left, max(self.width() - left - _RIGHT, 1.0)

    def _draw_plot(self, painter: QPainter, box: QRectF, plot: Plot, first: bool) -> None:
        axis = plot.axis(self._metrics)
        painter.setPen(self._colour(QPalette.ColorRole.Mid))
        painter.setBrush(self._colour(QPalette.ColorRole.Base))
        painter.drawRect(box)
        self._draw_labels(painter, box, plot, axis)
        if self._metrics is not None:
            self._draw_scales(painter, box, self._metrics, first)
            for series in plot.series:
                self._curve(painter, box, axis.fractions(series.of(self._metrics)), self._own(series.colours))
            if self._read is not None:
                x = self._x(box, self._read)
                painter.setPen(QPen(self._colour(QPalette.ColorRole.Text), 1.0))
                painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
        self._draw_names(painter, box, plot)

    def _draw_labels(self, painter: QPainter, box: QRectF, plot: Plot, axis: Axis) -> None:
        low, high = axis.labels
        line = painter.fontMetrics().height()
        self._label(painter, box, 1.0, high)
        at = float(axis.fractions(np.array([plot.line]))[0]) if plot.line is not None else 0.0
        if plot.line is not None and 0.0 <= at <= 1.0:
            if (1.0 - at) * box.height() > line:
                self._label(painter, box, at, f"{plot.line:g}")
            y = box.bottom() - at * box.height()
            painter.setPen(QPen(self._colour(QPalette.ColorRole.PlaceholderText), 1, Qt.PenStyle.DashLine))
            painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))
        if box.height() > 2 * line and (plot.line is None or at * box.height() > 1.7 * line):
            self._label(painter, box, 0.0, low)

    def _draw_scales(self, painter: QPainter, box: QRectF, metrics: RunMetrics, named: bool) -> None:
        """Mark where the run went on to a finer scale."""
        changes = np.flatnonzero(np.diff(metrics.scale)) + 1
        pen = QPen(self._colour(QPalette.ColorRole.PlaceholderText), 1, Qt.PenStyle.DotLine)
        font = painter.fontMetrics()
        right = box.left()
        for index in changes:
            painter.setPen(pen)
            x = self._x(box, int(index))
            painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
            text = tr("scale {scale}").format(scale=f"{metrics.scale[index]:.0f}")
            room = font.horizontalAdvance(text) + 4.0
            # names that would lie upon each other are left out but for the first
            if named and box.height() > 3 * font.height() and x + room <= box.right() and x >= right:
                right = x + room
                place = QRectF(x + 3.0, box.bottom() - font.height() - 1.0, room, font.height())
                painter.drawText(place, Qt.AlignmentFlag.AlignLeft, text)

    def _draw_names(self, painter: QPainter, box: QRectF, plot: Plot) -> None:
        metrics = painter.fontMetrics()
        ground = self._colour(QPalette.ColorRole.Base)
        ground.setAlpha(215)
        x = box.left() + 3.0
        for series in plot.series:
            text = series.title
            if self._metrics is not None and self._read is not None:
                text += f" {figure(float(series.of(self._metrics)[self._read]))}"
            place = QRectF(x, box.top() + 2.0, metrics.horizontalAdvance(text) + 6.0, metrics.height())
            painter.fillRect(place, ground)
            painter.setPen(self._own(series.colours))
            painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)
            x = place.right() + 4.0

    def _draw_steps(self, painter: QPainter, box: QRectF) -> None:
        painter.setPen(self._colour(QPalette.ColorRole.PlaceholderText))
        line = QRectF(box.left(), box.bottom() + 1, box.width(), self.height() - box.bottom())
        metrics = self._metrics
        if metrics is not None and self._read is not None:
            text = tr("step {step}").format(step=f"{metrics.step[self._read]:,.0f}")
            width = painter.fontMetrics().horizontalAdvance(text)
            x = min(max(self._x(box, self._read) - width / 2, box.left()), box.right() - width)
            painter.setPen(self._colour(QPalette.ColorRole.Text))
            painter.drawText(QRectF(x, line.top(), width + 2.0, line.height()), Qt.AlignmentFlag.AlignLeft, text)
            return
        first, last = (f"{metrics.step[0]:,.0f}", f"{metrics.step[-1]:,.0f}") if metrics is not None else ("0", "")
        painter.drawText(line, Qt.AlignmentFlag.AlignLeft, first)
        painter.drawText(line, Qt.AlignmentFlag.AlignHCenter, tr("step"))
        painter.drawText(line, Qt.AlignmentFlag.AlignRight, last)

    def _x(self, box: QRectF, index: int) -> float:
        last = len(self._metrics.step) - 1 if self._metrics is not None else 0
        return box.left() + box.width() * index / max(last, 1)

    def _curve(self, painter: QPainter, box: QRectF, fractions: Array, colour: QColor) -> None:
        if len(fractions) < 2:
            return
        # No more points than pixels: the plot costs the same however long the run.
        stride = max(1, len(fractions) // int(max(box.width(), 1)))
        kept = fractions[::-stride][::-1]
        x = box.left() + np.linspace(0.0, box.width(), len(kept))
        y = box.bottom() - np.clip(kept, 0.0, 1.0) * box.height()
        painter.setPen(QPen(colour, 1.4))
        finite = np.isfinite(kept)
        breaks = np.flatnonzero(np.diff(finite.astype(int))) + 1
        for piece in np.split(np.arange(len(kept)), breaks):
            if finite[piece[0]] and len(piece) > 1:
                painter.drawPolyline(QPolygonF([QPointF(x[i], y[i]) for i in piece]))

    def _label(self, painter: QPainter, box: QRectF, fraction: float, text: str) -> None:
        painter.setPen(self._colour(QPalette.ColorRole.PlaceholderText))
        y = box.bottom() - fraction * box.height()
        height = painter.fontMetrics().height()
        y = min(max(y - height / 2, box.top() - 2), box.bottom() - height + 2)
        flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(QRectF(0, y, box.left() - 4, height), flags, text)

    def _own(self, colours: tuple[str, str]) -> QColor:
        """The darker of two colours on a light ground, the brighter on a dark one."""
        return QColor(colours[self._colour(QPalette.ColorRole.Base).lightness() < 128])

    def _colour(self, role: QPalette.ColorRole) -> QColor:
        return self.palette().color(role)
