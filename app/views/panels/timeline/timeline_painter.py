"""Painting of the timeline."""

from __future__ import annotations

import math
from collections.abc import Iterator

from app.views.panels.timeline.timeline_places import FOOT, HEAD, ROW, SIDE, TimelinePlaces
from PySide6.QtCore import QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetrics, QPainter, QPainterPath, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from app.model.display.lengths import round_up
from app.model.text.language import tr
from app.session.features.timeline import TimelineNavigation
from app.session.timeline.timeline import Branch
from app.views.theme import theme

_FINE_PRINT = 10
"""Height of the labels of scales [px]."""


_EMPTY = (
    tr("The steps of a run are recorded here, so that you can go back to any of them."),
    tr("A run is recorded here, step by step."),
)
"""What an empty timeline says, and what it says where that does not fit."""
_WRAPPED = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap


def text_of_none(metrics: QFontMetrics, area: QRect) -> str:
    """The text of an empty timeline: as much as an area has room for."""
    return next((text for text in _EMPTY if area.contains(metrics.boundingRect(area, _WRAPPED, text))), "")


class TimelinePainter:
    """Paints the timeline of a navigation onto a widget, once."""

    def __init__(self, widget: QWidget, navigation: TimelineNavigation, places: TimelinePlaces) -> None:
        self._widget = widget
        self._navigation = navigation
        self._places = places
        self._painter = QPainter(widget)

    def draw(self) -> None:
        """Draw the axis, the branches and the shown step."""
        painter = self._painter
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        font = painter.font()
        font.setPointSizeF(max(6.5, font.pointSizeF() - 1.0))
        painter.setFont(font)
        branches = self._navigation.outline.branches
        if not branches:
            painter.setPen(self._color(QPalette.ColorRole.PlaceholderText))
            area = self._widget.rect()
            painter.drawText(area, _WRAPPED, text_of_none(painter.fontMetrics(), area))
        else:
            self._draw_grid()
            for branch in branches:
                self._draw_branch(branch)
            self._draw_axis()
            self._draw_place()
        if self._widget.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(self._color(QPalette.ColorRole.Highlight), 1.0))
            painter.drawRoundedRect(self._places.seen().adjusted(0.5, 0.5, -0.5, -0.5), 4.0, 4.0)
        painter.end()

    def _ticks(self) -> Iterator[int]:
        """Steps with a label on the axis."""
        _, width = self._places.span()
        span = self._places.steps
        wide = 1.6 * self._painter.fontMetrics().horizontalAdvance("00000")
        every = int(round_up(max(span * wide / width, 1.0)))
        first = -(-self._navigation.first // every) * every
        yield from range(first, self._navigation.first + span + 1, every)

    def _draw_grid(self) -> None:
        self._painter.setPen(QPen(self._color(QPalette.ColorRole.Mid), 1.0))
        for step in self._ticks():
            self._painter.drawLine(
                QPointF(self._places.x(step), HEAD), QPointF(self._places.x(step), self._widget.height() - FOOT)
            )

    def _draw_axis(self) -> None:
        """Draw the axis at the bottom of the visible part."""
        base = self._places.base()
        metrics = self._painter.fontMetrics()
        left, width = self._places.span()
        self._painter.fillRect(QRectF(0.0, base, self._widget.width(), FOOT), self._color(QPalette.ColorRole.Window))
        self._painter.setPen(QPen(self._color(QPalette.ColorRole.Mid), 1.0))
        self._painter.drawLine(QPointF(left, base), QPointF(left + width, base))
        half = metrics.horizontalAdvance("0000000") / 2
        for step in self._ticks():
            x = self._places.x(step)
            self._painter.setPen(QPen(self._color(QPalette.ColorRole.Mid), 1.0))
            self._painter.drawLine(QPointF(x, base), QPointF(x, base + 3.0))
            self._painter.setPen(self._color(QPalette.ColorRole.PlaceholderText))
            self._painter.drawText(
                QRectF(x - half, base + 1.0, 2 * half, FOOT), Qt.AlignmentFlag.AlignHCenter, f"{step}"
            )

    def _draw_branch(self, branch: Branch) -> None:
        here, identity = self._navigation.place[0], branch.identity
        y, last = self._places.y(identity), self._navigation.last(identity)
        compared = identity == self._navigation.comparison.branch
        role = QPalette.ColorRole.Highlight if identity == here else QPalette.ColorRole.PlaceholderText
        color = self._ghost() if compared else self._color(role)
        pen = QPen(color, 4.0 if identity == here else 3.0)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
        self._painter.setPen(QPen(color, 1.6))
        self._painter.setBrush(Qt.BrushStyle.NoBrush)
        begin = QPointF(self._places.x(branch.first), y)
        if branch.parent is not None:
            fork = QPointF(self._places.x(branch.first), self._places.y(branch.parent))
            path = QPainterPath(fork)
            path.lineTo(begin)
            self._painter.drawPath(path)
            self._painter.setBrush(color)
            self._painter.drawEllipse(fork, 2.6, 2.6)
        self._painter.setPen(pen)
        self._painter.drawLine(begin, QPointF(self._places.x(last), y))
        places = [*(self._places.x(step) for step, _ in branch.scales), math.inf]
        for index, (step, scale) in enumerate(branch.scales):
            if not (step == branch.first == self._navigation.first and scale == 0):
                self._draw_scale(scale, places[index], y, places[index + 1])
        self._draw_name(branch, y, color if compared or identity == here else None)

    def _draw_scale(self, scale: int, x: float, y: float, end: float) -> None:
        """Draw a tick where a scale begins, labeled with its reduction if that fits before the next one, at `end`."""
        self._painter.setPen(QPen(self._color(QPalette.ColorRole.WindowText), 1.4))
        self._painter.drawLine(QPointF(x, y - 5.0), QPointF(x, y + 5.0))
        text = f"1/{2**scale}" if scale else "1/1"
        self._painter.setPen(self._color(QPalette.ColorRole.PlaceholderText))
        font = self._painter.font()
        fine = QFont(font)
        fine.setPixelSize(_FINE_PRINT)
        self._painter.setFont(fine)
        flags = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignBottom
        if x + 3.0 + self._painter.fontMetrics().horizontalAdvance(text) < end:
            self._painter.drawText(QRectF(x + 3.0, y - ROW / 2 - 2.0, 40.0, ROW / 2), flags, text)
        self._painter.setFont(font)

    def _draw_name(self, branch: Branch, y: float, color: QColor | None) -> None:
        font = self._painter.font()
        bold = branch.identity == self._navigation.place[0]
        font.setBold(bold)
        self._painter.setFont(font)
        room = self._places.left() - SIDE - 10.0
        text = self._painter.fontMetrics().elidedText(branch.name, Qt.TextElideMode.ElideRight, int(room))
        self._painter.setPen(color or self._color(QPalette.ColorRole.WindowText))
        flags = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
        self._painter.drawText(QRectF(SIDE - 2.0, y - ROW / 2, room + 4.0, ROW), flags, text)
        font.setBold(False)
        self._painter.setFont(font)

    def _draw_place(self) -> None:
        branch, step = self._navigation.place
        if self._navigation.branch(branch) is None:
            return
        at = QPointF(self._places.x(step), self._places.y(branch))
        color = self._color(QPalette.ColorRole.WindowText)
        self._painter.setPen(QPen(color, 1.4))
        top = self._places.seen().top()
        self._painter.drawLine(QPointF(at.x(), top + 2.0), QPointF(at.x(), self._places.base()))
        self._painter.setBrush(color)
        self._painter.setPen(Qt.PenStyle.NoPen)
        flag = [QPointF(at.x() - 5.0, top + 1.0), QPointF(at.x() + 5.0, top + 1.0), QPointF(at.x(), top + 8.0)]
        self._painter.drawPolygon(QPolygonF(flag))
        self._painter.setPen(QPen(self._color(QPalette.ColorRole.Base), 1.6))
        self._painter.setBrush(self._color(QPalette.ColorRole.Highlight))
        self._painter.drawEllipse(at, 5.2, 5.2)

    def _ghost(self) -> QColor:
        dark = self._color(QPalette.ColorRole.Base).lightness() < 128
        return QColor(theme.GHOST) if dark else QColor(theme.GHOST).darker(150)

    def _color(self, role: QPalette.ColorRole) -> QColor:
        return self._widget.palette().color(role)
