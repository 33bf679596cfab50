"""The panel of the run: its state in words, figures and curves."""

from __future__ import annotations

from PySide6.QtWidgets import QGridLayout, QLabel, QVBoxLayout, QWidget

from app.model.state.resolve import Resolved
from app.model.text.language import tr
from app.views.panels.run.plot import PlotPanel

_WIDE = (tr("Contours"), tr("Bridged"))
"""Figures that take a line of their own."""


class StatusPanel(QWidget):
    """State in words, and the figures of the run in two columns."""

    def __init__(self) -> None:
        super().__init__()
        self._state = QLabel()
        self._state.setObjectName("state")
        self._state.setWordWrap(True)
        self._state.setMinimumHeight(2 * self._state.fontMetrics().lineSpacing() + 2)
        self._values: dict[str, QLabel] = {}
        self._next = 0
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
        """Show a state and its figures; what is the same as before is left alone."""
        _set(self._state, resolved.state)
        frames = (
            tr("Frames/s"),
            frames_per_second,
            tr("How often a second the window looks for newer particles and draws them."),
        )
        narrow = [number for number in resolved.numbers if number[0] not in _WIDE]
        wide = [number for number in resolved.numbers if number[0] in _WIDE]
        for label, value, explanation in (*narrow, frames, *wide):
            if label not in self._values:
                self._add(label, explanation)
            _set(self._values[label], value)

    def value(self, label: str) -> str:
        """The figure shown beside a label."""
        return self._values[label].text()

    @property
    def state(self) -> str:
        """The state in words as shown."""
        return self._state.text()

    def _add(self, label: str, explanation: str) -> None:
        wide = label in _WIDE
        self._next += self._next % 2 if wide else 0
        row, column = self._next // 2, 2 * (self._next % 2)
        self._next += 2 if wide else 1
        name, value = QLabel(label), QLabel()
        name.setObjectName("dim")
        for widget in (name, value):
            widget.setToolTip(explanation)
        value.setAccessibleName(label)
        self._values[label] = value
        self._grid.addWidget(name, row, column)
        self._grid.addWidget(value, row, column + 1, 1, 3 if wide else 1)


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


def _set(label: QLabel, text: str) -> None:
    if label.text() != text:
        label.setText(text)
