"""The panel of the run: its state in one line, the numbers that matter, and further numbers and plots folded away."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QObject, QPointF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPalette
from PySide6.QtWidgets import QFrame, QGridLayout, QHBoxLayout, QLabel, QScrollArea, QToolButton, QVBoxLayout, QWidget

from app.model.display.plots import PLOTS, Plot, RunMetrics, figure
from app.model.state.resolve import Resolved
from app.model.text.language import tr, written
from app.views.widgets.containers import ElidedLabel, Section
from cpm_core.numerics import Array

_WIDE = (tr("Contours"), tr("Bridged"), tr("Skeleton of"))
"""Numbers that need a row of their own."""

_LOWEST = 74
"""Minimum height of the panel, in which its content scrolls [px]."""

_LOWEST_PLOT = 72
"""Minimum height of a plot [px]."""

_PAGE = 10
"""Steps that the cursor moves by with Shift."""

Number = tuple[str, str, str]
"""Name, value and explanation."""


class Numbers(QWidget):
    """Names and values in a grid; only labels that differ are updated."""

    def __init__(self) -> None:
        super().__init__()
        self._values: dict[str, QLabel] = {}
        self._rows: dict[str, tuple[QLabel, QLabel]] = {}
        self._shown: tuple[str, ...] = ()
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(8)
        self._grid.setVerticalSpacing(3)
        self._grid.setColumnStretch(1, 3)
        self._grid.setColumnStretch(3, 2)

    def __contains__(self, name: object) -> bool:
        return name in self._shown

    def show_numbers(self, numbers: Sequence[Number]) -> None:
        """Show these numbers, the wide ones last."""
        ordered = sorted(numbers, key=lambda number: number[0] in _WIDE)
        names = tuple(name for name, _, _ in ordered)
        if names != self._shown:
            self._lay_out(ordered)
        for name, value, _ in ordered:
            if self._values[name].text() != value:
                self._values[name].setText(value)

    def value(self, name: str) -> str:
        """The value shown next to a name."""
        return self._values[name].text()

    def _lay_out(self, numbers: Sequence[Number]) -> None:
        """Give each number its place, two in a row, and hide those of another mode."""
        for pair in self._rows.values():
            for widget in pair:
                self._grid.removeWidget(widget)
                widget.hide()
        place = 0
        for name, _, explanation in numbers:
            label, value = self._row(name, explanation)
            wide = name in _WIDE
            place += place % 2 if wide else 0
            row, column = place // 2, 2 * (place % 2)
            place += 2 if wide else 1
            self._grid.addWidget(label, row, column)
            self._grid.addWidget(value, row, column + 1, 1, 3 if wide else 1)
            label.show()
            value.show()
        self._shown = tuple(name for name, _, _ in numbers)

    def _row(self, name: str, explanation: str) -> tuple[QLabel, QLabel]:
        """The name and the value of a number, made when it is first shown."""
        if name not in self._rows:
            label, value = QLabel(name), QLabel()
            label.setObjectName("dim")
            for widget in (label, value):
                widget.setToolTip(explanation)
            value.setAccessibleName(name)
            self._rows[name], self._values[name] = (label, value), value
        return self._rows[name]


class Chart(pg.GraphicsLayoutWidget):  # type: ignore[misc]  # pyqtgraph has no types
    """Plots the metrics of a run; the pointer or the arrow keys choose the step whose values are read."""

    def __init__(self) -> None:
        self._plots: tuple[Plot, ...] = ()
        super().__init__()
        self._metrics: RunMetrics | None = None
        self._items: list[pg.PlotItem] = []
        self._curves: list[list[pg.PlotDataItem]] = []
        self._cursors: list[pg.InfiniteLine] = []
        self._scales: list[tuple[pg.PlotItem, pg.InfiniteLine]] = []
        self._read: int | None = None
        # Later, since Qt is going through the items of the scene when it reports another palette.
        self._recolor = QTimer(self, singleShot=True, interval=0)
        self._recolor.timeout.connect(lambda: self.show_plots(self._plots))
        self.viewport().setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName(tr("Plot of the run over its steps"))
        self.ci.setContentsMargins(0, 0, 0, 0)
        self.ci.setSpacing(0)
        self.show_plots([plot for plot in PLOTS if plot.first])

    @property
    def reading(self) -> str:
        """The values at the step that is read; empty if there is none."""
        metrics, index = self._metrics, self._read
        if metrics is None or index is None:
            return ""
        values = [f"{one.title} {figure(float(one.of(metrics)[index]))}" for plot in self._plots for one in plot.series]
        return ", ".join([tr("step {step}").format(step=written(f"{metrics.step[index]:,.0f}")), *values])

    def show_metrics(self, metrics: RunMetrics | None) -> None:
        """Show a run, or none."""
        self._metrics = metrics if metrics is not None and len(metrics.step) else None
        if self._read is not None and (self._metrics is None or self._read >= len(self._metrics.step)):
            self._read = None
        for item, line in self._scales:
            item.removeItem(line)
        self._scales = []
        for plot, item, curves in zip(self._plots, self._items, self._curves, strict=True):
            for series, curve in zip(plot.series, curves, strict=True):
                self._draw(plot, curve, None if self._metrics is None else series.of(self._metrics))
            self._mark_scales(item)
        self._show_reading()

    def show_plots(self, plots: Sequence[Plot]) -> None:
        """Show these plots."""
        self.clear()
        self._plots = tuple(plots)
        self._items, self._curves, self._cursors, self._scales = [], [], [], []
        for row, plot in enumerate(self._plots):
            item = self.addPlot(row=row, col=0)
            item.setMouseEnabled(False, False)
            item.setMenuEnabled(False)
            item.hideButtons()
            item.setLogMode(y=plot.kind == "logarithmic")
            item.getAxis("left").setWidth(self.fontMetrics().horizontalAdvance("0000000"))
            if plot.kind == "from zero":
                item.getViewBox().setLimits(yMin=0.0)
            if plot.line is not None:
                item.addItem(self._line(0, Qt.PenStyle.DashLine, float(np.log10(plot.line))))
            if row < len(self._plots) - 1:
                item.getAxis("bottom").setStyle(showValues=False)
            if self._items:
                item.setXLink(self._items[0])
            cursor = self._line(90, Qt.PenStyle.SolidLine, 0.0)
            cursor.hide()
            item.addItem(cursor, ignoreBounds=True)
            pens = [pg.mkPen(self._series_color(series.colors), width=1.4) for series in plot.series]
            self._items.append(item)
            self._cursors.append(cursor)
            self._curves.append([item.plot(pen=pen, connect="finite") for pen in pens])
        self.setMinimumHeight(_LOWEST_PLOT * max(len(self._plots), 1))
        self._use_palette()
        self.show_metrics(self._metrics)

    def read(self, index: int | None) -> None:
        """Read the values of one entry of the metrics, or of none."""
        if index is not None and self._metrics is not None:
            index = min(max(index, 0), len(self._metrics.step) - 1)
        self._read = index if self._metrics is not None else None
        self._show_reading()

    def point(self, index: int) -> QPointF:
        """Position of an entry of the metrics in the uppermost plot."""
        view = self._items[0].getViewBox()
        step = self._metrics.step[index] if self._metrics is not None else 0.0
        place = view.mapViewToScene(QPointF(step, view.viewRange()[1][0]))
        return QPointF(self.mapFromScene(QPointF(place.x(), view.sceneBoundingRect().center().y())))

    # Qt interface

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Read the step under the pointer."""
        super().mouseMoveEvent(event)
        if self._metrics is not None and self._items:
            at = self._items[0].getViewBox().mapSceneToView(self.mapToScene(event.position().toPoint())).x()
            self.read(int(np.abs(self._metrics.step - at).argmin()))

    def leaveEvent(self, event: QEvent) -> None:
        """Stop reading."""
        super().leaveEvent(event)
        self.read(None)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Stop reading."""
        self.read(None)
        super().focusOutEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the cursor by steps."""
        last = len(self._metrics.step) - 1 if self._metrics is not None else 0
        at = self._read if self._read is not None else last
        stride = _PAGE if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        targets = {
            Qt.Key.Key_Left: at - stride,
            Qt.Key.Key_Right: at + stride,
            Qt.Key.Key_Home: 0,
            Qt.Key.Key_End: last,
            Qt.Key.Key_Escape: None,
        }
        key = Qt.Key(event.key())
        if key in targets:
            self.read(targets[key])
        else:
            event.ignore()

    def changeEvent(self, event: QEvent) -> None:
        """Draw in the colors of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and self._plots:
            self._recolor.start()

    # Internal

    def _draw(self, plot: Plot, curve: pg.PlotDataItem, values: Array | None) -> None:
        if values is None or self._metrics is None:
            curve.setData([], [])
            return
        # what is not positive has no logarithm
        shown = np.where(values > 0.0, values, np.nan) if plot.kind == "logarithmic" else values
        stride = max(1, len(shown) // max(self.width(), 1))  # no more points than pixels
        curve.setData(self._metrics.step[::-stride], np.asarray(shown, float)[::-stride])

    def _mark_scales(self, item: pg.PlotItem) -> None:
        """Mark the steps at which the run advanced to a finer scale."""
        if self._metrics is None:
            return
        for index in np.flatnonzero(np.diff(self._metrics.scale)) + 1:
            line = self._line(90, Qt.PenStyle.DotLine, float(self._metrics.step[index]))
            item.addItem(line, ignoreBounds=True)
            self._scales.append((item, line))

    def _show_reading(self) -> None:
        self.setAccessibleDescription(self.reading)
        for plot, item, cursor in zip(self._plots, self._items, self._cursors, strict=True):
            cursor.setVisible(self._read is not None)
            if self._read is not None and self._metrics is not None:
                cursor.setValue(float(self._metrics.step[self._read]))
            item.setTitle(" &nbsp; ".join(self._titles(plot)), size="8pt")

    def _titles(self, plot: Plot) -> list[str]:
        """Names of the curves in their colors, with the values that are read."""
        titles = []
        for series in plot.series:
            value = ""
            if self._metrics is not None and self._read is not None:
                value = figure(float(series.of(self._metrics)[self._read]))
            titles.append(f"<span style='color: {self._series_color(series.colors)}'>{series.title} {value}</span>")
        return titles

    def _line(self, angle: int, style: Qt.PenStyle, value: float) -> pg.InfiniteLine:
        color = self.palette().color(QPalette.ColorRole.PlaceholderText)
        return pg.InfiniteLine(value, angle, pg.mkPen(color, style=style))

    def _series_color(self, colors: tuple[str, str]) -> str:
        """The darker of two colors on a light background, the brighter on a dark one."""
        return colors[self.palette().color(QPalette.ColorRole.Base).lightness() < 128]

    def _use_palette(self) -> None:
        self.setBackground(self.palette().color(QPalette.ColorRole.Base))
        for item in self._items:
            for side in ("left", "bottom"):
                item.getAxis(side).setPen(self.palette().color(QPalette.ColorRole.Mid))
                item.getAxis(side).setTextPen(self.palette().color(QPalette.ColorRole.PlaceholderText))


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
        """The number shown next to a label."""
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
