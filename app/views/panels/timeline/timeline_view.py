"""The widget of the timeline: one row per branch, with the shown step."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QPoint, QPointF, QSize, Qt, Signal
from PySide6.QtGui import (
    QFocusEvent,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPaintEvent,
)
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from app.model.text.language import tr
from app.session.features.timeline import TimelineNavigation
from app.views.panels.timeline.timeline_painter import TimelinePainter
from app.views.panels.timeline.timeline_places import SIDE, TimelinePlaces

_KEYS = {
    Qt.Key.Key_Left: -1,
    Qt.Key.Key_Right: 1,
    Qt.Key.Key_PageUp: -10,
    Qt.Key.Key_PageDown: 10,
}


_ALL_KEYS = (*_KEYS, Qt.Key.Key_Home, Qt.Key.Key_End, Qt.Key.Key_Up, Qt.Key.Key_Down)


class TimelineView(QWidget):
    """Branches over steps; the pointer and the arrow keys go to any of them."""

    step_requested = Signal(int, int)
    """Branch and step that the user asks to see."""

    def __init__(self, navigation: TimelineNavigation) -> None:
        super().__init__()
        self._navigation = navigation
        self._places = TimelinePlaces(self, navigation)
        self._dragged: int | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.MinimumExpanding)
        self.setAccessibleName(tr("Timeline"))
        self.setMinimumWidth(120)

    def sizeHint(self) -> QSize:
        """High enough for all branches."""
        return QSize(420, self._places.height())

    def refresh(self) -> None:
        """Show the present branches and step."""
        if self.minimumHeight() != self._places.height():
            self.setMinimumHeight(self._places.height())
        branch, step = self._navigation.place
        known = self._navigation.branch(branch)
        if known is not None:
            words = tr("{branch}, step {step} of {last}")
            self.setAccessibleDescription(
                words.format(branch=known.name, step=step, last=self._navigation.last(known.identity))
            )
        self.update()

    def point(self, branch: int, step: int) -> QPointF:
        """Position of a step of a branch."""
        return QPointF(self._places.x(step), self._places.y(branch))

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The step that is shown; the one at a point is shown first. See `MenuOwner`."""
        branch = self._places.branch_at(point.y()) if point is not None else None
        if point is not None and branch is not None:
            self._dragged = branch
            self._request(QPointF(point))
            self._dragged = None
        shown, step = self._navigation.place
        if self._navigation.branch(shown) is None:
            return "", QPoint()
        return "step", point if point is not None else self.point(shown, step).toPoint()

    # Qt interface

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the axis, the branches and the shown step."""
        TimelinePainter(self, self._navigation, self._places).draw()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start scrubbing along a branch."""
        branch = self._places.branch_at(event.position().y())
        if event.button() == Qt.MouseButton.LeftButton and branch is not None:
            self._dragged = branch
            self._request(event.position())
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Scrub along the branch."""
        if self._dragged is not None:
            self._request(event.position())
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End scrubbing."""
        self._dragged = None
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move along a branch or to the next one by arrow keys."""
        branch, step = self._navigation.place
        key, branches = Qt.Key(event.key()), [known.identity for known in self._navigation.outline.branches]
        if not branches or key not in _ALL_KEYS:
            event.ignore()
        elif branch not in branches:  # no run is shown, as after a reset
            self.step_requested.emit(branches[-1], self._navigation.last(branches[-1]))
        elif key in _KEYS:
            fast = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
            self.step_requested.emit(branch, step + fast * _KEYS[key])
        elif key in (Qt.Key.Key_Home, Qt.Key.Key_End):
            self.step_requested.emit(
                branch, self._navigation.first if key == Qt.Key.Key_Home else self._navigation.last(branch)
            )
        else:
            row = branches.index(branch) + (1 if key == Qt.Key.Key_Down else -1)
            other = branches[min(max(row, 0), len(branches) - 1)]
            self.step_requested.emit(other, self._navigation.beside(other))

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show the focus outline."""
        self.update()
        super().focusInEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Hide the focus outline."""
        self.update()
        super().focusOutEvent(event)

    def event(self, event: QEvent) -> bool:
        """Show the step under the pointer as a tooltip, and keep the keys that move along a branch."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and event.key() in _ALL_KEYS:
            event.accept()
            return True
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            branch = self._navigation.branch(self._places.branch_at(event.pos().y()) or 0)
            if branch is not None and event.pos().x() >= self._places.left():
                step = min(max(self._places.step(event.pos().x()), 0), self._navigation.last(branch.identity))
                words = tr("{branch}, step {step}").format(branch=branch.name, step=step)
                QToolTip.showText(event.globalPos(), words, self)
            return True
        return super().event(event)

    def _request(self, point: QPointF) -> None:
        assert self._dragged is not None
        if point.x() >= self._places.left() - SIDE:
            step = self._places.step(point.x())
        else:
            step = self._navigation.beside(self._dragged)
        self.step_requested.emit(self._dragged, step)
