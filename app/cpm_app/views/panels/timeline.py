"""Timeline of a run: one row for each branch over one axis of steps, and a panel with buttons."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, QSignalBlocker, QSize, Qt, QTimer
from PySide6.QtGui import (
    QColor,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
)
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QScrollArea,
    QSizePolicy,
    QSpinBox,
    QToolTip,
    QWidget,
)

from cpm_app.model.display.lengths import round_up
from cpm_app.model.state.situation import RunStatus
from cpm_app.model.text.language import tr
from cpm_app.session.features.timeline_navigation import TimelineNavigation
from cpm_app.session.timeline.branches import TimelineBranch
from cpm_app.views.widgets.actions import ActionButton
from cpm_app.views.widgets.containers import claim_key, create_dim_label, fill_layout

_BRANCH_HEIGHT = 20
"""Height of a branch [px]."""

_AXIS_HEIGHT = 15
"""Height of the axis below the branches [px]."""

_TOP_SPACE = 5
"""Space above the branches [px]."""

_SIDE_SPACE = 10
"""Space on either side of the branches [px]."""

_MAX_SHOWN_BRANCHES = 3
"""Largest number of branches shown at once; the track scrolls to the others."""

_MAX_NAME_WIDTH = 130
"""Largest width of the names [px]."""

_MIN_TRACK_WIDTH = 120
"""Smallest width of the track [px]."""

_MIN_AXIS_STEPS = 20
"""Smallest number of steps on the axis."""

_RUNNING_UPDATE_INTERVAL = 100
"""Time between two updates during a run [ms]."""

_MIN_TIMELINE_WIDTH = 316
"""Smallest width of the panel [px]."""

_STEP_KEYS = {
    Qt.Key.Key_Left: -1,
    Qt.Key.Key_Right: 1,
    Qt.Key.Key_PageUp: -10,
    Qt.Key.Key_PageDown: 10,
    Qt.Key.Key_Home: -(10**9),
    Qt.Key.Key_End: 10**9,
}
"""Keys that move along a branch, with the number of steps."""

_BRANCH_KEYS = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1}
"""Keys that move between branches, with the number of rows."""

_TIMELINE_KEYS = _STEP_KEYS.keys() | _BRANCH_KEYS
"""Keys that the timeline handles."""


class TimelineView(QWidget):
    """Branches over an axis of steps; the pointer and the arrow keys go to any step."""

    def __init__(self, navigation: TimelineNavigation) -> None:
        super().__init__()
        self._navigation = navigation
        self._dragged: int | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.MinimumExpanding)
        self.setAccessibleName(tr("Timeline"))
        self.setMinimumWidth(_MIN_TRACK_WIDTH)

    def sizeHint(self) -> QSize:
        """Return a size that is high enough for all branches."""
        return QSize(420, self.height_of(len(self._navigation.branches)))

    @staticmethod
    def height_of(branches: int) -> int:
        """Return the height of a number of branches [px]."""
        return _TOP_SPACE + _BRANCH_HEIGHT * max(branches, 1) + _AXIS_HEIGHT

    def show_branches(self) -> None:
        """Show the current branches and step."""
        self.setMinimumHeight(self.sizeHint().height())
        branch, step = self._navigation.current_step
        known = self._navigation.find_branch(branch)
        if known is not None:
            last = self._navigation.last_step(branch)
            self.setAccessibleDescription(
                tr("{branch}, step {step} of {last}", branch=known.name, step=step, last=last)
            )
        self.update()

    def step_position(self, branch: int, step: int) -> QPointF:
        """Return the position of a step of a branch."""
        rows = [known.identity for known in self._navigation.branches]
        left, width = self._axis_range()
        x = left + width * step / self._count_axis_steps()
        return QPointF(x, _TOP_SPACE + _BRANCH_HEIGHT * (rows.index(branch) + 0.5))

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Return the shown step; go to the step at the point first. See `MenuOwner`."""
        branch = self._branch_at(point.y()) if point is not None else None
        if point is not None and branch is not None:
            self._go_to_point(branch, QPointF(point))
        shown, step = self._navigation.current_step
        if self._navigation.find_branch(shown) is None:
            return "", QPoint()
        return "step", point if point is not None else self.step_position(shown, step).toPoint()

    # Positions

    def _count_axis_steps(self) -> int:
        """Return the number of steps on the axis."""
        lasts = [self._navigation.last_step(branch.identity) for branch in self._navigation.branches]
        return max(max(lasts, default=0), _MIN_AXIS_STEPS)

    def _axis_range(self) -> tuple[float, float]:
        """Return the left end of the axis, to the right of the names, and its width [px]."""
        names = [self.fontMetrics().horizontalAdvance(branch.name) for branch in self._navigation.branches]
        left = _SIDE_SPACE + min(max(names, default=0), _MAX_NAME_WIDTH, self.width() / 3) + 14.0
        return left, max(self.width() - 2 * _SIDE_SPACE - left, 1.0)

    def _step_at(self, x: float) -> int:
        left, width = self._axis_range()
        return round((x - left) / width * self._count_axis_steps())

    def _axis_y(self) -> float:
        """Return the vertical position of the axis, at the bottom of the visible part [px]."""
        seen = self.visibleRegion().boundingRect()
        return float((self.rect() if seen.isEmpty() else seen).bottom() - _AXIS_HEIGHT)

    def _branch_at(self, y: float) -> int | None:
        """Return the branch of a row; on the axis, the shown branch."""
        branches = self._navigation.branches
        if not branches or y > self._axis_y():
            return self._navigation.current_step[0] if branches else None
        return branches[min(max(int((y - _TOP_SPACE) / _BRANCH_HEIGHT), 0), len(branches) - 1)].identity

    def _go_to_point(self, branch: int, point: QPointF) -> None:
        on_name = point.x() < self._axis_range()[0] - _SIDE_SPACE
        self._navigation.go_to(branch, self._navigation.matching_step(branch) if on_name else self._step_at(point.x()))

    # Qt interface

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the branches, the axis and the shown step."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        branches = self._navigation.branches
        if branches:
            for branch in branches:
                self._draw_branch(painter, branch)
            self._draw_axis(painter)
            self._draw_place(painter)
        else:
            painter.setPen(self._palette_color(QPalette.ColorRole.PlaceholderText))
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(self.rect(), flags, tr("A run is recorded here, step by step."))
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(self._palette_color(QPalette.ColorRole.Highlight))
            painter.drawRoundedRect(QRectF(self.visibleRegion().boundingRect()).adjusted(0.5, 0.5, -0.5, -0.5), 4, 4)
        painter.end()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start scrubbing along a branch."""
        self._dragged = self._branch_at(event.position().y()) if event.button() == Qt.MouseButton.LeftButton else None
        self.mouseMoveEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Scrub along the branch."""
        if self._dragged is not None and event.buttons() & Qt.MouseButton.LeftButton:
            self._go_to_point(self._dragged, event.position())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move along a branch or to the next one by arrow keys."""
        navigation = self._navigation
        branch, _ = navigation.current_step
        key, branches = Qt.Key(event.key()), [known.identity for known in navigation.branches]
        if not branches or key not in _TIMELINE_KEYS:
            event.ignore()
        elif branch not in branches:  # no step is shown, as after a reset
            self._navigation.go_to(branches[-1], navigation.last_step(branches[-1]))
        elif key in _STEP_KEYS:
            navigation.go_by(_STEP_KEYS[key] * (10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1))
        else:
            row = branches.index(branch) + _BRANCH_KEYS[key]
            other = branches[min(max(row, 0), len(branches) - 1)]
            navigation.go_to(other, navigation.matching_step(other))

    def event(self, event: QEvent) -> bool:
        """Show the step under the pointer as a tooltip, and claim the keys of the timeline."""
        if claim_key(event, _TIMELINE_KEYS):
            return True
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            branch = self._navigation.find_branch(self._branch_at(event.pos().y()) or 0)
            if branch is not None and event.pos().x() >= self._axis_range()[0]:
                step = min(max(self._step_at(event.pos().x()), 0), self._navigation.last_step(branch.identity))
                words = tr("{branch}, step {step}", branch=branch.name, step=step)
                QToolTip.showText(event.globalPos(), words, self)
            return True
        return super().event(event)

    # Painting

    def _draw_branch(self, painter: QPainter, branch: TimelineBranch) -> None:
        """Draw the name of a branch, its link to the parent, its steps, and the first step of each scale."""
        identity = branch.identity
        here = identity == self._navigation.current_step[0]
        color = self._palette_color(QPalette.ColorRole.Highlight if here else QPalette.ColorRole.PlaceholderText)
        begin = self.step_position(identity, branch.first)
        if branch.parent is not None:
            painter.setPen(QPen(color, 1.6))
            painter.drawLine(self.step_position(branch.parent, branch.first), begin)
        pen = QPen(color, 4.0 if here else 3.0)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
        painter.setPen(pen)
        painter.drawLine(begin, self.step_position(identity, self._navigation.last_step(identity)))
        faint, text = (
            self._palette_color(QPalette.ColorRole.PlaceholderText),
            self._palette_color(QPalette.ColorRole.WindowText),
        )
        for step, scale in branch.scales:
            if step or scale:
                at = self.step_position(identity, step)
                painter.setPen(QPen(text, 1.4))
                painter.drawLine(at - QPointF(0.0, 5.0), at + QPointF(0.0, 5.0))
                painter.setPen(faint)
                painter.drawText(at - QPointF(-3.0, 4.0), f"1/{2**scale}")
        room = self._axis_range()[0] - _SIDE_SPACE - 10.0
        name = self.fontMetrics().elidedText(branch.name, Qt.TextElideMode.ElideRight, int(room))
        painter.setPen(color if here else text)
        flags = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
        painter.drawText(
            QRectF(_SIDE_SPACE - 2.0, begin.y() - _BRANCH_HEIGHT / 2, room + 4.0, _BRANCH_HEIGHT), flags, name
        )

    def _draw_axis(self, painter: QPainter) -> None:
        """Draw the axis of the steps and its labels."""
        base, (left, width) = self._axis_y(), self._axis_range()
        painter.fillRect(
            QRectF(0.0, base, self.width(), _AXIS_HEIGHT + 1), self._palette_color(QPalette.ColorRole.Window)
        )
        painter.setPen(self._palette_color(QPalette.ColorRole.PlaceholderText))
        painter.drawLine(QPointF(left, base), QPointF(left + width, base))
        half = self.fontMetrics().horizontalAdvance("0000000") / 2
        interval = int(round_up(max(self._count_axis_steps() * 2.4 * half / width, 1.0)))
        for step in range(0, self._count_axis_steps() + 1, interval):
            x = left + width * step / self._count_axis_steps()
            painter.drawLine(QPointF(x, base), QPointF(x, base + 3.0))
            painter.drawText(
                QRectF(x - half, base + 1.0, 2 * half, _AXIS_HEIGHT), Qt.AlignmentFlag.AlignHCenter, f"{step}"
            )

    def _draw_place(self, painter: QPainter) -> None:
        """Mark the step that is shown."""
        branch, step = self._navigation.current_step
        if self._navigation.find_branch(branch) is None:
            return
        at = self.step_position(branch, step)
        painter.setPen(QPen(self._palette_color(QPalette.ColorRole.WindowText), 1.4))
        painter.drawLine(QPointF(at.x(), self.visibleRegion().boundingRect().top()), QPointF(at.x(), self._axis_y()))
        painter.setPen(QPen(self._palette_color(QPalette.ColorRole.Base), 1.6))
        painter.setBrush(self._palette_color(QPalette.ColorRole.Highlight))
        painter.drawEllipse(at, 5.2, 5.2)

    def _palette_color(self, role: QPalette.ColorRole) -> QColor:
        return self.palette().color(role)


class TimelinePanel(QWidget):
    """Timeline with buttons that go to any step of the run; updated less often while it is running."""

    def __init__(self, navigation: TimelineNavigation, status: Callable[[], RunStatus]) -> None:
        super().__init__()
        self._navigation = navigation
        self._status = status
        self.view = TimelineView(navigation)
        self.setFocusProxy(self.view)
        style = Qt.ToolButtonStyle.ToolButtonIconOnly
        moves, others = ("first", "back", "forward", "last"), ("rename", "delete", "parameters")
        going, changing = ([ActionButton(f"timeline_{name}", style) for name in names] for names in (moves, others))
        self.step = QSpinBox()
        self.step.setKeyboardTracking(False)
        self.step.setAccessibleName(tr("Step"))
        self.step.setToolTip(tr("Shown step; type a number to go there."))
        self.step.valueChanged.connect(lambda step: navigation.go_to(navigation.current_step[0], step))
        self._total_label = create_dim_label()
        scroll = self._scroll = QScrollArea(widgetResizable=True)
        scroll.setWidget(self.view)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        scroll.setMinimumWidth(_MIN_TRACK_WIDTH)
        scroll.verticalScrollBar().valueChanged.connect(self.view.update)  # the axis does not scroll
        parts = *going, self.step, self._total_label, *changing, scroll
        fill_layout(QHBoxLayout(self), *parts, margins=(8, 1, 8, 1), spacing=2, wide=scroll)
        self._update_timer = QTimer(self, singleShot=True, interval=_RUNNING_UPDATE_INTERVAL)
        self._update_timer.timeout.connect(self._show_step)
        navigation.changed.connect(self._on_timeline_changed)
        self._show_step()

    def minimumSizeHint(self) -> QSize:
        """Return room for the buttons and a short track."""
        hint = super().minimumSizeHint()
        return QSize(min(hint.width(), _MIN_TIMELINE_WIDTH), hint.height())

    # Internal

    def _on_timeline_changed(self) -> None:
        if self._status().phase != "running":
            self._update_timer.stop()
            self._show_step()
        elif not self._update_timer.isActive():
            self._update_timer.start()

    def _show_step(self) -> None:
        navigation = self._navigation
        branch, step = navigation.current_step
        has_branch, last, count = (
            navigation.find_branch(branch) is not None,
            navigation.last_step(branch),
            len(navigation.branches),
        )
        with QSignalBlocker(self.step):
            self.step.setRange(0, max(last, step))
            self.step.setValue(step)
        self.step.setEnabled(has_branch)
        self._total_label.setText(tr("of {last}", last=last) if has_branch else "")
        self.view.show_branches()
        self._scroll.setFixedHeight(self.view.height_of(min(count, _MAX_SHOWN_BRANCHES)))
        if has_branch:
            self._scroll.ensureVisible(0, round(self.view.step_position(branch, step).y()), 0, _BRANCH_HEIGHT)
