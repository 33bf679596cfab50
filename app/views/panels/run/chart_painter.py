"""Painting of the chart of a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from app.model.display.plots import Axis, Plot, RunMetrics, figure
from app.model.text.language import tr, written
from cpm_core.numerics.types import Array

_GAP, _RIGHT = 3.0, 8.0


def sides(widget: QWidget) -> tuple[float, float]:
    """Left side and width of the plots in a chart [px]."""
    left = widget.fontMetrics().horizontalAdvance("10000") + 4.0
    return left, max(widget.width() - left - _RIGHT, 1.0)


class ChartPainter:
    """Paints plots, from top to bottom, onto a widget, once; `read` is the entry whose values are shown."""

    def __init__(self, widget: QWidget, plots: Sequence[Plot], metrics: RunMetrics | None, read: int | None) -> None:
        self._widget = widget
        self._plots = plots
        self._metrics = metrics
        self._read = read
        self._painter = QPainter(widget)

    def draw(self) -> None:
        """Draw all plots."""
        painter = self._painter
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        font = painter.font()
        font.setPointSizeF(max(6.5, font.pointSizeF() - 1.5))
        painter.setFont(font)
        left, width = sides(self._widget)
        below = painter.fontMetrics().height() + 2.0
        count = max(len(self._plots), 1)
        names = float(painter.fontMetrics().height())  # above each plot, so that they cover no curve
        height = (self._widget.height() - below - count * (names + _GAP)) / count
        box = QRectF()
        for index, plot in enumerate(self._plots):
            box = QRectF(left, names + index * (height + names + _GAP), width, height)
            self._draw_plot(box, plot, first=index == 0)
        if self._plots:
            self._draw_steps(box)
        painter.end()

    def _draw_plot(self, box: QRectF, plot: Plot, first: bool) -> None:
        axis = plot.axis(self._metrics)
        self._painter.setPen(self._color(QPalette.ColorRole.Mid))
        self._painter.setBrush(self._color(QPalette.ColorRole.Base))
        self._painter.drawRect(box)
        self._draw_labels(box, plot, axis)
        if self._metrics is not None:
            self._draw_scales(box, self._metrics, first)
            for series in plot.series:
                self._curve(box, axis.fractions(series.of(self._metrics)), self._series_color(series.colors))
            if self._read is not None:
                x = self._x(box, self._read)
                self._painter.setPen(QPen(self._color(QPalette.ColorRole.Text), 1.0))
                self._painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
        self._draw_names(box, plot)

    def _draw_labels(self, box: QRectF, plot: Plot, axis: Axis) -> None:
        low, high = axis.labels
        line = self._painter.fontMetrics().height()
        self._label(box, 1.0, high)
        at = float(axis.fractions(np.array([plot.line]))[0]) if plot.line is not None else 0.0
        if plot.line is not None and 0.0 <= at <= 1.0:
            if (1.0 - at) * box.height() > line:
                self._label(box, at, written(f"{plot.line:g}"))
            y = box.bottom() - at * box.height()
            self._painter.setPen(QPen(self._color(QPalette.ColorRole.PlaceholderText), 1, Qt.PenStyle.DashLine))
            self._painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))
        if box.height() > 2 * line and (plot.line is None or at * box.height() > 1.7 * line):
            self._label(box, 0.0, low)

    def _draw_scales(self, box: QRectF, metrics: RunMetrics, named: bool) -> None:
        """Mark the steps at which the run advanced to a finer scale."""
        changes = np.flatnonzero(np.diff(metrics.scale)) + 1
        pen = QPen(self._color(QPalette.ColorRole.PlaceholderText), 1, Qt.PenStyle.DotLine)
        font = self._painter.fontMetrics()
        right = box.left()
        for index in changes:
            self._painter.setPen(pen)
            x = self._x(box, int(index))
            self._painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
            text = tr("scale {scale}").format(scale=written(f"{metrics.scale[index]:.0f}"))
            room = font.horizontalAdvance(text) + 4.0
            # of overlapping names only the first is drawn
            if named and box.height() > 3 * font.height() and x + room <= box.right() and x >= right:
                right = x + room
                place = QRectF(x + 3.0, box.bottom() - font.height() - 1.0, room, font.height())
                self._painter.drawText(place, Qt.AlignmentFlag.AlignLeft, text)

    def _draw_names(self, box: QRectF, plot: Plot) -> None:
        metrics = self._painter.fontMetrics()
        x = box.left() + 3.0
        for series in plot.series:
            text = series.title
            if self._metrics is not None and self._read is not None:
                text += f" {figure(float(series.of(self._metrics)[self._read]))}"
            place = QRectF(x, box.top() - metrics.height(), metrics.horizontalAdvance(text) + 6.0, metrics.height())
            self._painter.setPen(self._series_color(series.colors))
            self._painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)
            x = place.right() + 4.0

    def _draw_steps(self, box: QRectF) -> None:
        self._painter.setPen(self._color(QPalette.ColorRole.PlaceholderText))
        line = QRectF(box.left(), box.bottom() + 1, box.width(), self._widget.height() - box.bottom())
        metrics = self._metrics
        if metrics is not None and self._read is not None:
            text = tr("step {step}").format(step=written(f"{metrics.step[self._read]:,.0f}"))
            width = self._painter.fontMetrics().horizontalAdvance(text)
            x = min(max(self._x(box, self._read) - width / 2, box.left()), box.right() - width)
            self._painter.setPen(self._color(QPalette.ColorRole.Text))
            self._painter.drawText(QRectF(x, line.top(), width + 2.0, line.height()), Qt.AlignmentFlag.AlignLeft, text)
            return
        first, last = (
            (written(f"{metrics.step[0]:,.0f}"), written(f"{metrics.step[-1]:,.0f}"))
            if metrics is not None
            else ("0", "")
        )
        self._painter.drawText(line, Qt.AlignmentFlag.AlignLeft, first)
        self._painter.drawText(line, Qt.AlignmentFlag.AlignHCenter, tr("step"))
        self._painter.drawText(line, Qt.AlignmentFlag.AlignRight, last)

    def _x(self, box: QRectF, index: int) -> float:
        last = len(self._metrics.step) - 1 if self._metrics is not None else 0
        return box.left() + box.width() * index / max(last, 1)

    def _curve(self, box: QRectF, fractions: Array, color: QColor) -> None:
        if len(fractions) < 2:
            return
        # No more points than pixels: the cost of the plot does not depend on the length of the run.
        stride = max(1, len(fractions) // int(max(box.width(), 1)))
        kept = fractions[::-stride][::-1]
        x = box.left() + np.linspace(0.0, box.width(), len(kept))
        y = box.bottom() - np.clip(kept, 0.0, 1.0) * box.height()
        self._painter.setPen(QPen(color, 1.4))
        finite = np.isfinite(kept)
        breaks = np.flatnonzero(np.diff(finite.astype(int))) + 1
        for piece in np.split(np.arange(len(kept)), breaks):
            if finite[piece[0]] and len(piece) > 1:
                self._painter.drawPolyline(QPolygonF([QPointF(x[i], y[i]) for i in piece]))

    def _label(self, box: QRectF, fraction: float, text: str) -> None:
        self._painter.setPen(self._color(QPalette.ColorRole.PlaceholderText))
        y = box.bottom() - fraction * box.height()
        height = self._painter.fontMetrics().height()
        y = min(max(y - height / 2, box.top() - 2), box.bottom() - height + 2)
        flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        self._painter.drawText(QRectF(0, y, box.left() - 4, height), flags, text)

    def _series_color(self, colors: tuple[str, str]) -> QColor:
        """The darker of two colors on a light background, the brighter on a dark one."""
        return QColor(colors[self._color(QPalette.ColorRole.Base).lightness() < 128])

    def _color(self, role: QPalette.ColorRole) -> QColor:
        return self._widget.palette().color(role)
