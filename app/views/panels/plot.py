"""The plot of ε on a logarithmic axis and of the number of particles over the steps."""

from __future__ import annotations

import math

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from app.session.messages import Array, Trace
from app.views import theme

RESTING = 1e-3
"""ε of eq. (23) under which particles count as at rest."""

_COUNTS = ("#0072b2", theme.CLOSED)
_EPSILONS = ("#c2410c", theme.OPEN)
_GAP = 10.0


class PlotPanel(QWidget):
    """Two small plots above each other with the step as their common axis."""

    def __init__(self) -> None:
        super().__init__()
        self._trace: Trace | None = None
        self.setMinimumHeight(120)
        self.setMaximumHeight(240)
        self.setAccessibleName("Plot of ε and particles over steps")
        self.setToolTip(
            "Above: ε of eq. (23), with the line at 0.001 under which particles are at rest. Below: particles."
        )

    def sizeHint(self) -> QSize:
        """Wide and low."""
        return QSize(300, 150)

    def show_trace(self, trace: Trace | None) -> None:
        """Show a run, or none."""
        self._trace = trace
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw both plots."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        font = painter.font()
        font.setPointSizeF(max(6.5, font.pointSizeF() - 1.5))
        painter.setFont(font)
        metrics = painter.fontMetrics()
        left, below = metrics.horizontalAdvance("10000") + 6.0, metrics.height() + 2.0
        height = (self.height() - below - _GAP) / 2
        width = self.width() - left - 8.0
        above = QRectF(left, 2.0, width, height - 2.0)
        under = QRectF(left, 2.0 + height + _GAP, width, height - 2.0)
        self._draw_epsilon(painter, above)
        self._draw_count(painter, under)
        self._draw_steps(painter, under)
        painter.end()

    def _draw_epsilon(self, painter: QPainter, box: QRectF) -> None:
        values = self._trace.epsilon if self._trace else np.empty(0)
        known = values[np.isfinite(values) & (values > 0)]
        low = math.floor(math.log10(min(known.min(), RESTING))) if len(known) else -4
        high = math.ceil(math.log10(max(known.max(), 10 * RESTING))) if len(known) else 0
        low = max(low, high - 8)
        self._frame(painter, box)
        rest = (math.log10(RESTING) - low) / (high - low)
        self._label(painter, box, 1.0, f"1e{high}" if high else "1")
        self._label(painter, box, rest, f"{RESTING:g}")
        if rest * box.height() > 1.7 * painter.fontMetrics().height():
            self._label(painter, box, 0.0, f"1e{low}")
        if 0.0 <= rest <= 1.0:
            y = box.bottom() - rest * box.height()
            painter.setPen(QPen(self._colour(QPalette.ColorRole.PlaceholderText), 1, Qt.PenStyle.DashLine))
            painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))
        with np.errstate(divide="ignore", invalid="ignore"):
            fractions = (np.log10(values) - low) / (high - low)
        self._curve(painter, box, fractions, _EPSILONS)
        self._name(painter, box, "ε", _EPSILONS)

    def _draw_count(self, painter: QPainter, box: QRectF) -> None:
        values = self._trace.count if self._trace else np.empty(0)
        top = _round_up(float(values.max())) if len(values) else 100.0
        self._frame(painter, box)
        for fraction in (0.0, 1.0):
            self._label(painter, box, fraction, f"{fraction * top:.0f}")
        self._curve(painter, box, values / top, _COUNTS)
        self._name(painter, box, "particles", _COUNTS)

    def _draw_steps(self, painter: QPainter, box: QRectF) -> None:
        last = int(self._trace.step[-1]) if self._trace is not None and len(self._trace.step) else 0
        painter.setPen(self._colour(QPalette.ColorRole.PlaceholderText))
        line = QRectF(box.left(), box.bottom() + 1, box.width(), self.height() - box.bottom())
        painter.drawText(line, Qt.AlignmentFlag.AlignLeft, "0")
        painter.drawText(line, Qt.AlignmentFlag.AlignHCenter, "step")
        painter.drawText(line, Qt.AlignmentFlag.AlignRight, f"{last:,}" if last else "")

    def _curve(self, painter: QPainter, box: QRectF, fractions: Array, colours: tuple[str, str]) -> None:
        if len(fractions) < 2:
            return
        # No more points than pixels: the plot costs the same however long the run.
        stride = max(1, len(fractions) // int(max(box.width(), 1)))
        kept = fractions[::-stride][::-1]
        x = box.left() + np.linspace(0.0, box.width(), len(kept))
        y = box.bottom() - np.clip(kept, 0.0, 1.0) * box.height()
        painter.setPen(QPen(self._own(colours), 1.4))
        finite = np.isfinite(kept)
        breaks = np.flatnonzero(np.diff(finite.astype(int))) + 1
        for piece in np.split(np.arange(len(kept)), breaks):
            if finite[piece[0]] and len(piece) > 1:
                painter.drawPolyline(QPolygonF([QPointF(x[i], y[i]) for i in piece]))

    def _frame(self, painter: QPainter, box: QRectF) -> None:
        painter.setPen(self._colour(QPalette.ColorRole.Mid))
        painter.setBrush(self._colour(QPalette.ColorRole.Base))
        painter.drawRect(box)

    def _label(self, painter: QPainter, box: QRectF, fraction: float, text: str) -> None:
        painter.setPen(self._colour(QPalette.ColorRole.PlaceholderText))
        y = box.bottom() - fraction * box.height()
        height = painter.fontMetrics().height()
        y = min(max(y - height / 2, box.top() - 2), box.bottom() - height + 2)
        flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(QRectF(0, y, box.left() - 4, height), flags, text)

    def _name(self, painter: QPainter, box: QRectF, text: str, colours: tuple[str, str]) -> None:
        metrics = painter.fontMetrics()
        place = QRectF(box.left() + 3, box.top() + 2, metrics.horizontalAdvance(text) + 6.0, metrics.height())
        ground = self._colour(QPalette.ColorRole.Base)
        ground.setAlpha(200)
        painter.fillRect(place, ground)
        painter.setPen(self._own(colours))
        painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)

    def _own(self, colours: tuple[str, str]) -> QColor:
        """The darker of two colours on a light ground, the brighter on a dark one."""
        return QColor(colours[self._colour(QPalette.ColorRole.Base).lightness() < 128])

    def _colour(self, role: QPalette.ColorRole) -> QColor:
        return self.palette().color(role)


def _round_up(value: float) -> float:
    """The next number of the form 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(max(value, 1.0)))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= value)
