"""Positions in the timeline: one row per branch, one axis of steps."""

from __future__ import annotations

from PySide6.QtCore import QRectF
from PySide6.QtWidgets import QWidget

from app.session.features.timeline import TimelineNavigation

ROW = 24
"""Height of a branch [px]."""

FOOT, HEAD, SIDE = 16, 6, 10
"""Space below the branches for the axis, above them and beside them [px]."""

_END = 20
_LONGEST_NAME = 130
_SHORTEST = 20
"""Minimum number of steps of the axis."""


class TimelinePlaces:
    """Positions of branches and steps in the widget that shows them."""

    def __init__(self, widget: QWidget, navigation: TimelineNavigation) -> None:
        self._widget = widget
        self._navigation = navigation

    @property
    def steps(self) -> int:
        """Number of steps of the axis."""
        lasts = [self._navigation.last(branch.identity) for branch in self._navigation.outline.branches]
        return max(max(lasts, default=0) - self._navigation.first, _SHORTEST)

    def height(self) -> int:
        """Height that all branches need [px]."""
        return HEAD + ROW * max(len(self._navigation.outline.branches), 1) + FOOT

    def left(self) -> float:
        """Left end of the axis, right of the names [px]."""
        metrics = self._widget.fontMetrics()
        names = [metrics.horizontalAdvance(branch.name) for branch in self._navigation.outline.branches]
        longest = min(_LONGEST_NAME, self._widget.width() / 3)
        return SIDE + min(max(names, default=0), longest) + 14.0

    def span(self) -> tuple[float, float]:
        """Left end and width of the axis [px]."""
        return self.left(), max(self._widget.width() - _END - self.left(), 1.0)

    def x(self, step: float) -> float:
        """Position of a step [px]."""
        left, width = self.span()
        return left + width * (step - self._navigation.first) / self.steps

    def step(self, x: float) -> int:
        """The step at a position [px]."""
        left, width = self.span()
        return round(self._navigation.first + (x - left) / width * self.steps)

    def y(self, branch: int) -> float:
        """The middle of the row of a branch [px]."""
        rows = [known.identity for known in self._navigation.outline.branches]
        return HEAD + ROW * (rows.index(branch) + 0.5)

    def seen(self) -> QRectF:
        """The visible part of the widget."""
        seen = self._widget.visibleRegion().boundingRect()
        return QRectF(self._widget.rect() if seen.isEmpty() else seen)

    def base(self) -> float:
        """Vertical position of the axis, at the bottom of the visible part [px]."""
        return self.seen().bottom() - FOOT

    def branch_at(self, y: float) -> int | None:
        """The branch of a row; on the axis, the branch that is shown."""
        branches = self._navigation.outline.branches
        if not branches:
            return None
        if y > self.base():
            return self._navigation.place[0]
        row = int((y - HEAD) / ROW)
        return branches[min(max(row, 0), len(branches) - 1)].identity
