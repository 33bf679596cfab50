"""The plots of a run, and a button for each."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QVBoxLayout, QWidget

from app.model.display.plots import PLOTS, RunMetrics
from app.model.text.language import tr
from app.views.panels.run.chart import Chart


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
