"""The timeline as it is drawn: one row a branch, with the step that is shown."""

from __future__ import annotations

from collections.abc import Iterator

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFocusEvent,
    QFont,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPalette,
    QPen,
    QPolygonF,
)
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from app.model.text.language import tr
from app.session.features.timeline_navigation import TimelineNavigation
from app.session.timeline.branches import Branch
from app.views.theme import theme

ROW = 24
"""Height of a branch [px]."""

_FOOT, _HEAD, _SIDE = 16, 6, 10
_FINE_PRINT = 10
"""Height of the letters that tell scales [px]."""

_END = 20
_LONGEST_NAME = 130
_SOONEST = 20
"""Steps that the axis spans at least."""

_KEYS = {
    Qt.Key.Key_Left: -1,
    Qt.Key.Key_Right: 1,
    Qt.Key.Key_PageUp: -10,
    Qt.Key.Key_PageDown: 10,
}


class TimelineView(QWidget):
    """Branches over steps; the pointer and the arrow keys go to any of them.

    Parameters
    ----------
    navigation : TimelineNavigation
        What it shows and goes through.
    """

    asked = Signal(int, int)
    """Branch and step that somebody wants to see."""

    def __init__(self, navigation: TimelineNavigation) -> None:
        super().__init__()
        self._navigation = navigation
        self._dragged: int | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.MinimumExpanding)
        self.setAccessibleName(tr("Timeline"))
        self.setMinimumWidth(180)

    def sizeHint(self) -> QSize:
        """As high as its branches."""
        return QSize(420, self._height())

    def refresh(self) -> None:
        """Show how the timeline stands now."""
        if self.minimumHeight() != self._height():
            self.setMinimumHeight(self._height())
        branch, step = self._navigation.place
        told = self._navigation.branch(branch)
        if told is not None:
            words = tr("{branch}, step {step} of {last}")
            self.setAccessibleDescription(
                words.format(branch=told.name, step=step, last=self._navigation.last(told.identity))
            )
        self.update()

    def point(self, branch: int, step: int) -> QPointF:
        """Where a step of a branch is drawn."""
        return QPointF(self._x(step), self._y(branch))

    # What Qt calls

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw axis, branches and the step that is shown."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        font = painter.font()
        font.setPointSizeF(max(6.5, font.pointSizeF() - 1.0))
        painter.setFont(font)
        branches = self._navigation.outline.branches
        if not branches:
            painter.setPen(self._colour(QPalette.ColorRole.PlaceholderText))
            words = tr("Every step of a run will be kept here, for going back to it.")
            painter.drawText(QRectF(self.rect()), Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, words)
        else:
            self._draw_grid(painter)
            for branch in branches:
                self._draw_branch(painter, branch)
            self._draw_axis(painter)
            self._draw_place(painter)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(self._colour(QPalette.ColorRole.Highlight), 1.0))
            painter.drawRoundedRect(self._seen().adjusted(0.5, 0.5, -0.5, -0.5), 4.0, 4.0)
        painter.end()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take hold of a branch."""
        branch = self._branch_at(event.position().y())
        if event.button() == Qt.MouseButton.LeftButton and branch is not None:
            self._dragged = branch
            self._ask_for(event.position())
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Scrub along it."""
        if self._dragged is not None:
            self._ask_for(event.position())
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Let go."""
        self._dragged = None
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows go along a branch and from one to the next."""
        branch, step = self._navigation.place
        key, branches = Qt.Key(event.key()), [known.identity for known in self._navigation.outline.branches]
        if branch not in branches:
            event.ignore()
        elif key in _KEYS:
            fast = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
            self.asked.emit(branch, step + fast * _KEYS[key])
        elif key in (Qt.Key.Key_Home, Qt.Key.Key_End):
            self.asked.emit(branch, self._navigation.first if key == Qt.Key.Key_Home else self._navigation.last(branch))
        elif key in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            row = branches.index(branch) + (1 if key == Qt.Key.Key_Down else -1)
            self.asked.emit(branches[min(max(row, 0), len(branches) - 1)], step)
        else:
            event.ignore()

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show the frame."""
        self.update()
        super().focusInEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Hide the frame."""
        self.update()
        super().focusOutEvent(event)

    def event(self, event: QEvent) -> bool:
        """Tell under the pointer which step that is."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            branch = self._navigation.branch(self._branch_at(event.pos().y()) or 0)
            if branch is not None and event.pos().x() >= self._left():
                step = min(max(self._step(event.pos().x()), 0), self._navigation.last(branch.identity))
                words = tr("{branch}, step {step}").format(branch=branch.name, step=step)
                QToolTip.showText(event.globalPos(), words, self)
            return True
        return super().event(event)

    # Places

    def _height(self) -> int:
        return _HEAD + ROW * max(len(self._navigation.outline.branches), 2) + _FOOT

    def _left(self) -> float:
        metrics = self.fontMetrics()
        names = [metrics.horizontalAdvance(branch.name) for branch in self._navigation.outline.branches]
        return _SIDE + min(max(names, default=0), _LONGEST_NAME) + 14.0

    def _longest(self) -> int:
        return max((self._navigation.last(branch.identity) for branch in self._navigation.outline.branches), default=0)

    def _span(self) -> tuple[float, float]:
        return self._left(), max(self.width() - _END - self._left(), 1.0)

    def _x(self, step: float) -> float:
        left, width = self._span()
        first = self._navigation.first
        return left + width * (step - first) / max(self._longest() - first, _SOONEST)

    def _step(self, x: float) -> int:
        left, width = self._span()
        first = self._navigation.first
        return round(first + (x - left) / width * max(self._longest() - first, _SOONEST))

    def _y(self, branch: int) -> float:
        rows = [known.identity for known in self._navigation.outline.branches]
        return _HEAD + ROW * (rows.index(branch) + 0.5)

    def _seen(self) -> QRectF:
        seen = self.visibleRegion().boundingRect()
        return QRectF(self.rect() if seen.isEmpty() else seen)

    def _base(self) -> float:
        return self._seen().bottom() - _FOOT

    def _branch_at(self, y: float) -> int | None:
        """The branch of a row; on the axis that where the run stands."""
        branches = self._navigation.outline.branches
        if not branches:
            return None
        if y > self._base():
            return self._navigation.place[0]
        row = int((y - _HEAD) / ROW)
        return branches[min(max(row, 0), len(branches) - 1)].identity

    def _ask_for(self, point: QPointF) -> None:
        assert self._dragged is not None
        # a press on the name changes the branch and keeps the step
        step = self._step(point.x()) if point.x() >= self._left() - _SIDE else self._navigation.place[1]
        self.asked.emit(self._dragged, step)

    # Drawing

    def _ticks(self, painter: QPainter) -> Iterator[int]:
        """Steps that the axis names."""
        _, width = self._span()
        span = max(self._longest() - self._navigation.first, _SOONEST)
        every = _round_up(span * painter.fontMetrics().horizontalAdvance("00000") * 1.6 / width)
        first = -(-self._navigation.first // every) * every
        yield from range(first, self._navigation.first + span + 1, every)

    def _draw_grid(self, painter: QPainter) -> None:
        painter.setPen(QPen(self._colour(QPalette.ColorRole.Mid), 1.0))
        for step in self._ticks(painter):
            painter.drawLine(QPointF(self._x(step), _HEAD), QPointF(self._x(step), self.height() - _FOOT))

    def _draw_axis(self, painter: QPainter) -> None:
        """The axis stays at the foot of what is seen, however many branches there are."""
        base = self._base()
        metrics = painter.fontMetrics()
        left, width = self._span()
        painter.fillRect(QRectF(0.0, base, self.width(), _FOOT), self._colour(QPalette.ColorRole.Window))
        painter.setPen(QPen(self._colour(QPalette.ColorRole.Mid), 1.0))
        painter.drawLine(QPointF(left, base), QPointF(left + width, base))
        half = metrics.horizontalAdvance("0000000") / 2
        for step in self._ticks(painter):
            x = self._x(step)
            painter.setPen(QPen(self._colour(QPalette.ColorRole.Mid), 1.0))
            painter.drawLine(QPointF(x, base), QPointF(x, base + 3.0))
            painter.setPen(self._colour(QPalette.ColorRole.PlaceholderText))
            painter.drawText(QRectF(x - half, base + 1.0, 2 * half, _FOOT), Qt.AlignmentFlag.AlignHCenter, f"{step}")

    def _draw_branch(self, painter: QPainter, branch: Branch) -> None:
        here, identity = self._navigation.place[0], branch.identity
        y, last = self._y(identity), self._navigation.last(identity)
        compared = identity == self._navigation.comparison.branch
        role = QPalette.ColorRole.Highlight if identity == here else QPalette.ColorRole.PlaceholderText
        colour = self._ghost() if compared else self._colour(role)
        pen = QPen(colour, 4.0 if identity == here else 3.0)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
        painter.setPen(QPen(colour, 1.6))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        begin = QPointF(self._x(branch.first), y)
        if branch.parent is not None:
            fork = QPointF(self._x(branch.first), self._y(branch.parent))
            path = QPainterPath(fork)
            path.lineTo(begin)
            painter.drawPath(path)
            painter.setBrush(colour)
            painter.drawEllipse(fork, 2.6, 2.6)
        painter.setPen(pen)
        painter.drawLine(begin, QPointF(self._x(last), y))
        for step, scale in branch.scales:
            self._draw_scale(painter, step, scale, y, branch.first)
        self._draw_name(painter, branch, y, colour if compared or identity == here else None)

    def _draw_scale(self, painter: QPainter, step: int, scale: int, y: float, first: int) -> None:
        """A tick where a scale begins, with how small the image is then; where the run begins nobody asks."""
        if step == first == self._navigation.first and scale == 0:
            return
        x = self._x(step)
        painter.setPen(QPen(self._colour(QPalette.ColorRole.WindowText), 1.4))
        painter.drawLine(QPointF(x, y - 5.0), QPointF(x, y + 5.0))
        text = f"1/{2**scale}" if scale else "1/1"
        painter.setPen(self._colour(QPalette.ColorRole.PlaceholderText))
        font = painter.font()
        fine = QFont(font)
        fine.setPixelSize(_FINE_PRINT)
        painter.setFont(fine)
        flags = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignBottom
        painter.drawText(QRectF(x + 3.0, y - ROW / 2 - 2.0, 40.0, ROW / 2), flags, text)
        painter.setFont(font)

    def _draw_name(self, painter: QPainter, branch: Branch, y: float, colour: QColor | None) -> None:
        font = painter.font()
        bold = branch.identity == self._navigation.place[0]
        font.setBold(bold)
        painter.setFont(font)
        room = self._left() - _SIDE - 10.0
        text = painter.fontMetrics().elidedText(branch.name, Qt.TextElideMode.ElideRight, int(room))
        painter.setPen(colour or self._colour(QPalette.ColorRole.WindowText))
        flags = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
        painter.drawText(QRectF(_SIDE - 2.0, y - ROW / 2, room + 4.0, ROW), flags, text)
        font.setBold(False)
        painter.setFont(font)

    def _draw_place(self, painter: QPainter) -> None:
        branch, step = self._navigation.place
        if self._navigation.branch(branch) is None:
            return
        at = self.point(branch, step)
        colour = self._colour(QPalette.ColorRole.WindowText)
        painter.setPen(QPen(colour, 1.4))
        top = self._seen().top()
        painter.drawLine(QPointF(at.x(), top + 2.0), QPointF(at.x(), self._base()))
        painter.setBrush(colour)
        painter.setPen(Qt.PenStyle.NoPen)
        flag = [QPointF(at.x() - 5.0, top + 1.0), QPointF(at.x() + 5.0, top + 1.0), QPointF(at.x(), top + 8.0)]
        painter.drawPolygon(QPolygonF(flag))
        painter.setPen(QPen(self._colour(QPalette.ColorRole.Base), 1.6))
        painter.setBrush(self._colour(QPalette.ColorRole.Highlight))
        painter.drawEllipse(at, 5.2, 5.2)

    def _ghost(self) -> QColor:
        dark = self._colour(QPalette.ColorRole.Base).lightness() < 128
        return QColor(theme.GHOST) if dark else QColor(theme.GHOST).darker(150)

    def _colour(self, role: QPalette.ColorRole) -> QColor:
        return self.palette().color(role)


def _round_up(value: float) -> int:
    """The next number of the form 1, 2 or 5 times a power of ten."""
    power = 1
    while True:
        for factor in (1, 2, 5):
            if factor * power >= value:
                return factor * power
        power *= 10
