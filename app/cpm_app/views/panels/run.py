"""Tab of the run: state, main numbers, preset and sliders; more numbers and plots folded away."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPoint, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QPalette, QShowEvent
from PySide6.QtWidgets import QFormLayout, QLabel, QVBoxLayout, QWidget

from cpm_app.model.display.plots import PLOTS, Metrics, Plot, PlotCurve, RunMetrics
from cpm_app.model.state.resolve import LEADING_LABELS, WindowTexts
from cpm_app.model.text.language import tr
from cpm_app.views.panels.parameters import ParametersPanel
from cpm_app.views.widgets.containers import (
    ElidedLabel,
    FoldableSection,
    VerticalScrollArea,
    create_dim_label,
    fill_layout,
)

_MIN_PANEL_HEIGHT = 120
"""Smallest height of the panel, whose content scrolls [px]."""

_MIN_PLOT_HEIGHT = 72
"""Smallest height of a plot [px]."""

NumberRow = tuple[str, str, str]
"""Name, value and explanation."""


class NumberForm(QWidget):
    """Names and values below one another; only changed texts are updated."""

    def __init__(self) -> None:
        super().__init__()
        self._values: dict[str, QLabel] = {}
        self._form = QFormLayout(self)
        self._form.setContentsMargins(0, 0, 0, 0)
        self._form.setHorizontalSpacing(8)
        self._form.setVerticalSpacing(3)

    def show_numbers(self, numbers: Sequence[NumberRow]) -> None:
        """Show these numbers."""
        if [name for name, _, _ in numbers] != [*self._values]:
            while self._form.rowCount():
                self._form.removeRow(0)
            self._values = {name: ElidedLabel() for name, _, _ in numbers}
            for name, _, explanation in numbers:
                self._values[name].setToolTip(explanation)
                self._values[name].setAccessibleName(name)
                self._form.addRow(create_dim_label(name, explanation), self._values[name])
        for name, value, _ in numbers:
            self._values[name].setText(value)


class Chart(pg.GraphicsLayoutWidget):  # type: ignore[misc]  # pyqtgraph has no types
    """Plots of metrics over steps or pages."""

    clicked = Signal(float)
    """The user has clicked at a step or page."""

    def __init__(self, plots: Sequence[Plot], name: str) -> None:
        self._items: list[pg.PlotItem] = []
        self._curves: list[tuple[Plot, PlotCurve, pg.PlotDataItem]] = []
        self._marks: list[pg.VTickGroup] = []
        """Lines at the marks of the metrics, one group per plot."""
        self._plots = plots
        super().__init__()
        self._metrics: Metrics | None = None
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setAccessibleName(name)
        self.scene().sigMouseClicked.connect(self._on_mouse_clicked)
        self.ci.setContentsMargins(0, 0, 0, 0)
        self.ci.setSpacing(0)

    def show_metrics(self, metrics: Metrics | None) -> None:
        """Show metrics, or none."""
        self._metrics = metrics = metrics if metrics is not None and len(metrics.step) else None
        if metrics is not None and self._plots and not self._items:
            self._draw_plots()
            return
        for plot, series, curve in self._curves:
            if metrics is None:
                curve.clear()
            else:
                values = np.asarray(series.get_values(metrics), float)
                known = np.isfinite(values) if plot.points else slice(None)
                curve.setData(metrics.step[known], values[known])
        for marks in self._marks:
            marks.setXVals([] if metrics is None else list(metrics.marks))

    def show_plots(self, plots: Sequence[Plot]) -> None:
        """Show these plots; they are drawn when they become visible for the first time."""
        self._plots = plots
        if self._items or self.isVisible():
            self._draw_plots()

    def showEvent(self, event: QShowEvent) -> None:
        """Draw the plots when they become visible."""
        super().showEvent(event)
        if not self._items:
            self._draw_plots()

    def _draw_plots(self) -> None:
        self.clear()
        self._items, self._curves, self._marks = [], [], []
        pale = self._palette_color(QPalette.ColorRole.PlaceholderText)
        for row, plot in enumerate(self._plots):
            item = self.addPlot(row=row, col=0)
            item.setToolTip(plot.tip)
            item.setMouseEnabled(False, False)
            item.setMenuEnabled(False)
            item.hideButtons()
            item.setLogMode(y=plot.kind == "logarithmic")
            item.setDownsampling(auto=True, mode="subsample")
            for side in ("left", "bottom"):
                item.getAxis(side).setPen(self._palette_color(QPalette.ColorRole.Mid))
                item.getAxis(side).setTextPen(pale)
            item.getAxis("left").setWidth(self.fontMetrics().horizontalAdvance("0000000"))
            item.getAxis("bottom").setStyle(showValues=plot is self._plots[-1])
            if plot.axis:
                item.setLabel("bottom", plot.axis)
            if plot.kind == "from zero":
                item.getViewBox().setLimits(yMin=0.0)
            if plot.line is not None:
                item.addLine(y=float(np.log10(plot.line)), pen=pg.mkPen(pale, style=Qt.PenStyle.DashLine))
            self._items.append(item)
            if row:
                item.setXLink(self._items[0])
            marks = pg.VTickGroup(yrange=(0.0, 1.0), pen=pg.mkPen(pale, style=Qt.PenStyle.DotLine))
            item.addItem(marks, ignoreBounds=True)
            self._marks.append(marks)
            titles = []
            for series in plot.curves:
                # the darker of two colors on a light background, the brighter on a dark one
                color = series.colors[self._palette_color(QPalette.ColorRole.Base).lightness() < 128]
                curve = item.plot(pen=pg.mkPen(color, width=1.4), connect="finite", symbol="o" if plot.points else None)
                curve.setSymbolBrush(color)
                curve.setSymbolPen(None)
                curve.setSymbolSize(4)
                self._curves.append((plot, series, curve))
                titles.append(f"<span style='color: {color}'>{series.title}</span>")
            item.setTitle(" &nbsp; ".join(titles), size="8pt")
        self.setMinimumHeight(_MIN_PLOT_HEIGHT * max(len(self._plots), 1))
        self.setBackground(self._palette_color(QPalette.ColorRole.Base))
        self.show_metrics(self._metrics)

    def _on_mouse_clicked(self, event: Any) -> None:
        if self._items:
            place = self._items[0].getViewBox().mapSceneToView(event.scenePos()).x()
            # later, as the receiver may redraw the plots while their scene still handles the event
            QTimer.singleShot(0, self, partial(self.clicked.emit, place))

    def changeEvent(self, event: QEvent) -> None:
        """Redraw in the colors of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and self._items:
            # Later, since Qt iterates over the items of the scene while it reports another palette.
            QTimer.singleShot(0, self, self._draw_plots)

    def _palette_color(self, role: QPalette.ColorRole) -> QColor:
        return QColor(self.palette().color(role))


class StatusPanel(QWidget):
    """State of the run and its main numbers."""

    def __init__(self) -> None:
        super().__init__()
        self._label = ElidedLabel()
        self._label.setObjectName("state")
        self.leading, self.others = NumberForm(), NumberForm()
        fill_layout(QVBoxLayout(self), self._label, self.leading, spacing=4)

    def show_resolved(self, resolved: WindowTexts) -> None:
        """Show a state and its numbers."""
        if resolved.state != self.state:
            # the explanation after a colon is only in the tooltip
            self._label.setText(resolved.state.partition(": ")[0])
            self._label.setToolTip(resolved.state)
            self._label.setAccessibleName(resolved.state)
        self.leading.show_numbers([number for number in resolved.numbers if number[0] in LEADING_LABELS])
        self.others.show_numbers([number for number in resolved.numbers if number[0] not in LEADING_LABELS])

    @property
    def state(self) -> str:
        """State of the run in words."""
        return self._label.accessibleName()


class RunPanel(VerticalScrollArea):
    """State, preset and sliders; more numbers and plots folded away."""

    section_toggled = Signal()
    """The user has folded or unfolded a section."""

    def __init__(self, parameters: ParametersPanel) -> None:
        self.status, self.parameters, self.plot = (
            StatusPanel(),
            parameters,
            Chart(PLOTS, tr("Plot of the run over its steps")),
        )
        further = QWidget()
        fill_layout(QVBoxLayout(further), self.status.others, self.plot, spacing=4, wide=self.plot)
        self.plots = FoldableSection(tr("Numbers and plots"), further)
        self.sections = {"parameters": parameters.more, "plots": self.plots}
        self._metrics: RunMetrics | None = None
        content = QWidget()
        parts = self.status, parameters, self.plots, None
        fill_layout(QVBoxLayout(content), *parts, margins=(8, 8, 6, 6), spacing=8)
        super().__init__(content, _MIN_PANEL_HEIGHT)
        for section in self.sections.values():
            section.fold.toggled.connect(partial(self._on_section_toggled, section))

    @property
    def unfolded_sections(self) -> list[str]:
        """Names of the unfolded sections."""
        return [name for name, section in self.sections.items() if section.fold.isChecked()]

    def unfold_sections(self, names: list[str]) -> None:
        """Unfold the sections with these names and fold the others."""
        for name, section in self.sections.items():
            section.fold.setChecked(name in names)

    def show_metrics(self, metrics: RunMetrics | None) -> None:
        """Show a run, or none; nothing is drawn while the plots are folded."""
        self._metrics = metrics
        if self.plots.fold.isChecked():
            self.plot.show_metrics(metrics)

    def _on_section_toggled(self, section: FoldableSection, unfolded: bool) -> None:
        """Scroll an unfolded section into view, after the layout has placed it."""
        self.show_metrics(self._metrics)
        self.section_toggled.emit()
        if unfolded and self.isVisible():
            scroll = self.verticalScrollBar().setValue
            QTimer.singleShot(0, self, lambda: scroll(section.mapTo(self._content, QPoint()).y()))
