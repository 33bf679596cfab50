"""The panel of the run: its state in words, numbers and plots."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from app.model.display.plots import PLOTS, RunMetrics
from app.model.state.resolve import Resolved
from app.model.text.language import tr
from app.views.panels.run.chart import Chart

_WIDE = (tr("Contours"), tr("Bridged"), tr("Skeleton of"))
"""Numbers that need a row of their own."""


class StatusPanel(QWidget):
    """State in words, and the numbers of the run in two columns."""

    def __init__(self) -> None:
        super().__init__()
        self._state = QLabel()
        self._state.setObjectName("state")
        self._state.setWordWrap(True)
        self._state.setMinimumHeight(2 * self._state.fontMetrics().lineSpacing() + 2)
        self._values: dict[str, QLabel] = {}
        self._rows: dict[str, tuple[QLabel, QLabel]] = {}
        self._shown: tuple[str, ...] = ()
        self._grid = QGridLayout()
        self._grid.setHorizontalSpacing(8)
        self._grid.setVerticalSpacing(3)
        self._grid.setColumnStretch(1, 3)
        self._grid.setColumnStretch(3, 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        layout.addWidget(self._state)
        layout.addLayout(self._grid)

    def show_resolved(self, resolved: Resolved, frames_per_second: str) -> None:
        """Show a state and its numbers; only labels that differ are updated."""
        _set(self._state, resolved.state)
        frames = (
            tr("Frames/s"),
            frames_per_second,
            tr("How often per second the window draws the newest particles."),
        )
        moving = (frames,) if resolved.particles else ()
        narrow = [number for number in resolved.numbers if number[0] not in _WIDE]
        wide = [number for number in resolved.numbers if number[0] in _WIDE]
        numbers = (*narrow, *moving, *wide)
        labels = tuple(label for label, _, _ in numbers)
        if labels != self._shown:
            self._lay_out(numbers)
        for label, value, _ in numbers:
            _set(self._values[label], value)

    def value(self, label: str) -> str:
        """The number shown beside a label."""
        return self._values[label].text()

    @property
    def state(self) -> str:
        """The state in words."""
        return self._state.text()

    def _lay_out(self, numbers: Sequence[tuple[str, str, str]]) -> None:
        """Give each number its place, two in a row, and hide those of another mode."""
        for pair in self._rows.values():
            for widget in pair:
                self._grid.removeWidget(widget)
                widget.hide()
        place = 0
        for label, _, explanation in numbers:
            name, value = self._row(label, explanation)
            wide = label in _WIDE
            place += place % 2 if wide else 0
            row, column = place // 2, 2 * (place % 2)
            place += 2 if wide else 1
            self._grid.addWidget(name, row, column)
            self._grid.addWidget(value, row, column + 1, 1, 3 if wide else 1)
            name.show()
            value.show()
        self._shown = tuple(label for label, _, _ in numbers)

    def _row(self, label: str, explanation: str) -> tuple[QLabel, QLabel]:
        """The name and the value of a number, made when it is first shown."""
        if label not in self._rows:
            name, value = QLabel(label), QLabel()
            name.setObjectName("dim")
            for widget in (name, value):
                widget.setToolTip(explanation)
            value.setAccessibleName(label)
            self._rows[label], self._values[label] = (name, value), value
        return self._rows[label]


class RunPanel(QWidget):
    """Status above, plot below."""

    def __init__(self) -> None:
        super().__init__()
        self.status = StatusPanel()
        self.plot = PlotPanel()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(12, 8, 12, 8)
        layout.setSpacing(8)
        layout.addWidget(self.status)
        layout.addWidget(self.plot, 1)
        layout.addStretch()


def _set(label: QLabel, text: str) -> None:
    if label.text() != text:
        label.setText(text)


class PlotPanel(QWidget):
    """A button for each plot above the chart."""

    chosen = Signal()
    """The set of visible plots has changed."""

    def __init__(self) -> None:
        super().__init__()
        self.chart = Chart()
        self.buttons: dict[str, QToolButton] = {}
        row = QHBoxLayout()
        row.setSpacing(2)
        for plot in PLOTS:
            self.buttons[plot.name] = button = QToolButton()
            button.setObjectName("chip")
            button.setText(plot.title)
            button.setCheckable(True)
            button.setChecked(plot.first)
            button.setToolTip(plot.tip)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setAccessibleName(tr("Plot: {title}").format(title=plot.title))
            button.toggled.connect(self._choose)
            row.addWidget(button)
        row.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addLayout(row)
        column.addWidget(self.chart, 1)

    @property
    def shown(self) -> tuple[str, ...]:
        """Names of the plots shown."""
        return tuple(name for name, button in self.buttons.items() if button.isChecked())

    def show_plots(self, names: list[str]) -> None:
        """Show only the plots with these names."""
        for name, button in self.buttons.items():
            button.setChecked(name in names)

    def show_metrics(self, metrics: RunMetrics | None) -> None:
        """Show a run, or none."""
        self.chart.show_metrics(metrics)

    def _choose(self) -> None:
        self.chart.show_plots([plot for plot in PLOTS if plot.name in self.shown])
        self.chosen.emit()
