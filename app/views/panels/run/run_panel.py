"""The panel of the run: how it stands in one line, the numbers that matter, and the rest folded away."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSize, Signal
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from app.model.display.plots import RunMetrics
from app.model.state.resolve import Resolved
from app.model.text.language import tr
from app.views.panels.run.numbers import Numbers
from app.views.panels.run.plot_panel import PlotPanel
from app.views.widgets.elided_label import ElidedLabel
from app.views.widgets.section import Section

_LOWEST = 74
"""Minimum height of the panel, in which its content scrolls [px]."""


class StatusPanel(QWidget):
    """How the run stands, the leading numbers, and the other ones in a section."""

    def __init__(self) -> None:
        super().__init__()
        self._state = ElidedLabel()
        self._state.setObjectName("state")
        self._resolved: Resolved | None = None
        self._leading, self._others = Numbers(), Numbers()
        self.section = Section(tr("More numbers"), self._others, unfolded=False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        for widget in (self._state, self._leading, self.section):
            layout.addWidget(widget)

    def show_resolved(self, resolved: Resolved, frames_per_second: str) -> None:
        """Show a state and its numbers."""
        if self._resolved is None or self._resolved.state != resolved.state:
            # what follows a colon explains the rest, and is in the tip
            head, colon, _ = resolved.state.partition(": ")
            self._state.setText(f"{head}." if colon else head)
            self._state.setToolTip(resolved.state)
            self._state.setAccessibleName(resolved.state)
        self._resolved = resolved
        frames = (
            tr("Frames/s"),
            frames_per_second,
            tr("How often per second the window draws the newest particles."),
        )
        self._leading.show_numbers([number for number in resolved.numbers if number[0] in resolved.leading])
        others = [number for number in resolved.numbers if number[0] not in resolved.leading]
        self._others.show_numbers([*others, frames] if resolved.particles else others)
        self.section.setVisible(bool(others))

    def value(self, label: str) -> str:
        """The number shown beside a label."""
        return (self._leading if label in self._leading else self._others).value(label)

    @property
    def state(self) -> str:
        """The state in words."""
        return self._resolved.state if self._resolved is not None else ""


class RunPanel(QWidget):
    """Status above, plots below; it scrolls where it is lower than its content."""

    folded = Signal()
    """A section has been folded or unfolded."""

    def __init__(self) -> None:
        super().__init__()
        self.status = StatusPanel()
        self.plot = PlotPanel()
        self.plots = Section(tr("Plots"), self.plot, unfolded=False)
        self.sections = {"numbers": self.status.section, "plots": self.plots}
        self._content = QWidget()
        self._content.setObjectName("scrolled")
        column = QVBoxLayout(self._content)
        column.setContentsMargins(12, 6, 12, 6)
        column.setSpacing(4)
        column.addWidget(self.status)
        column.addWidget(self.plots, 1)
        column.addStretch()
        area = QScrollArea()
        area.setWidget(self._content)
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.viewport().setAutoFillBackground(False)
        self._content.setAutoFillBackground(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(area)
        for section in self.sections.values():
            section.fold.toggled.connect(self._refit)
        self._metrics: RunMetrics | None = None
        self._content.installEventFilter(self)

    @property
    def unfolded(self) -> list[str]:
        """Names of the sections that are unfolded."""
        return [name for name, section in self.sections.items() if section.fold.isChecked()]

    def unfold(self, names: list[str]) -> None:
        """Unfold the sections with these names, and fold the others."""
        for name, section in self.sections.items():
            section.fold.setChecked(name in names)

    def show_particles(self, particles: bool) -> None:
        """Show the plots where there are particles that move."""
        self.plots.setVisible(particles)

    def show_metrics(self, metrics: RunMetrics | None) -> None:
        """Show a run, or none; nothing is drawn while the plots are folded."""
        self._metrics = metrics
        if self.plots.fold.isChecked():
            self.plot.show_metrics(metrics)

    def sizeHint(self) -> QSize:
        """The size of the content."""
        return self._content.sizeHint()

    def minimumSizeHint(self) -> QSize:
        """The width of the content, and room for the first lines."""
        return QSize(self._content.minimumSizeHint().width(), _LOWEST)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Pass on that the content wants another size, which the scroll area keeps to itself."""
        if event.type() == QEvent.Type.LayoutRequest:
            self.updateGeometry()
        return super().eventFilter(watched, event)

    def _refit(self) -> None:
        self.show_metrics(self._metrics)
        self.folded.emit()
