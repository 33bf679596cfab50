"""The forms for the options of layers; that of the image has a histogram."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.model.text.language import tr, written
from app.views.canvas.layers.image_layer import ImageLayer
from app.views.canvas.layers.layer import Amount, Choice, Layer, Option
from app.views.theme import color_maps
from app.views.widgets.fields import DecimalField, MarkedSlider
from cpm_core import Image
from cpm_core.numerics import Array


class LayerForm(QWidget):
    """A row for each option of a layer; it also follows changes that are made elsewhere."""

    def __init__(self, layer: Layer) -> None:
        super().__init__()
        self.layer = layer
        self.fields: dict[str, QWidget] = {}
        self._showing: list[Callable[[], None]] = []
        self.rows = QFormLayout(self)
        self.rows.setContentsMargins(0, 0, 0, 0)
        self.rows.setHorizontalSpacing(8)
        self.rows.setVerticalSpacing(4)
        self.rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.levels: Levels | None = None
        self._image: Image | None = None
        for option in layer.options:
            self._add(option)
        layer.changed.connect(self.show_chosen)
        self.show_chosen()

    def show_chosen(self) -> None:
        """Show the values of the options, and the window of an image."""
        if isinstance(self.layer, ImageLayer):
            self._show_levels(self.layer)
        for show in self._showing:
            show()
        for name, field in self.fields.items():
            field.setEnabled(self.layer.acts(name))

    def _add(self, option: Option) -> None:
        if isinstance(option, Choice):
            field: QWidget = self._choice(option)
        elif isinstance(option, Amount):
            field = self._amount(option)
        else:
            field = self._switch(option.name, option.title)
        self.fields[option.name] = field
        field.setToolTip(option.tip)
        field.setAccessibleName(option.title)
        if isinstance(field, QCheckBox):
            self.rows.addRow(field)
            return
        label = QLabel(option.title)
        label.setObjectName("dim")
        label.setToolTip(option.tip)
        self.rows.addRow(label, field)

    def _show_levels(self, layer: ImageLayer) -> None:
        image = layer.scene.whole
        if image is not self._image and image is not None:
            self._image = image
            if self.levels is not None:
                self.rows.removeRow(self.levels)
            self.levels = Levels(image.values, layer.ends, layer.window)
            self.levels.moved.connect(layer.choose_window)
            self.rows.insertRow(0, self.levels)
        elif self.levels is not None:
            self.levels.show_window(*layer.window)

    def _choice(self, option: Choice) -> QComboBox:
        box = QComboBox()
        box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        box.setIconSize(QSize(36, 12))
        for name, title in option.ways.items():
            if name in color_maps.MAPS:
                box.addItem(color_maps.icon(name), title, name)
            else:
                box.addItem(title, name)

        def show() -> None:
            box.setCurrentIndex(box.findData(self.layer.chosen[option.name]))

        self._showing.append(show)
        box.activated.connect(lambda index: self.layer.choose(option.name, box.itemData(index)))
        return box

    def _amount(self, option: Amount) -> QWidget:
        slider = MarkedSlider(option.low, option.high, option.step, option.first)
        figure = QLabel()
        figure.setMinimumWidth(figure.fontMetrics().horizontalAdvance("0.000"))
        figure.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

        def show() -> None:
            slider.show_value(self.layer.number(option.name))
            figure.setText(written(f"{self.layer.number(option.name):g}"))

        self._showing.append(show)
        slider.moved_to.connect(lambda value: self.layer.choose(option.name, value))
        slider.restored.connect(lambda: self.layer.choose(option.name, option.first))
        both = QWidget()
        both.setFocusProxy(slider)
        row = QHBoxLayout(both)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(slider, 1)
        row.addWidget(figure)
        return both

    def _switch(self, name: str, title: str) -> QCheckBox:
        box = QCheckBox(title)
        box.toggled.connect(lambda checked: self.layer.choose(name, checked))
        self._showing.append(lambda: box.setChecked(bool(self.layer.chosen[name])))
        return box


_BINS = 128
_MOST = 100_000
"""Largest number of pixels counted; more would not visibly change the histogram."""

_NARROW, _AROUND = 0.1, 2.0
"""Part of the range below which a window is shown enlarged, and the margin next to it, in window widths."""

_HEIGHT = 72


class Levels(QWidget):
    """Histogram and fields for the window of gray values.

    Parameters
    ----------
    values : ndarray, shape (H, W) or (P, H, W)
        Gray values of the image.
    ends : tuple of float
        Least and largest of them.
    window : tuple of float
        The window shown.
    """

    moved = Signal(float, float)
    """The user has chosen another window."""

    def __init__(self, values: Array, ends: tuple[float, float], window: tuple[float, float]) -> None:
        super().__init__()
        stride = max(1, int((values.size / _MOST) ** (1.0 / values.ndim)))
        sample = values[(slice(None, None, stride),) * values.ndim].ravel()
        self.histogram = Histogram(sample, *ends)
        self.low, self.high = DecimalField(), DecimalField()
        row = QHBoxLayout()
        row.setSpacing(6)
        titles = ((tr("Black"), tr("Gray value shown black.")), (tr("White"), tr("Gray value shown white.")))
        for (title, tip), field in zip(titles, (self.low, self.high), strict=True):
            _set_range(field, *ends, whole=bool((sample == np.rint(sample)).all()))
            field.setAccessibleName(title)
            field.setToolTip(tip)
            label = QLabel(title)
            label.setObjectName("dim")
            row.addWidget(label)
            row.addWidget(field, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.histogram)
        column.addLayout(row)
        self.show_window(*window)
        self.histogram.moved.connect(self.moved)
        self.low.valueChanged.connect(lambda value: self.moved.emit(value, max(value, self.high.value())))
        self.high.valueChanged.connect(lambda value: self.moved.emit(min(value, self.low.value()), value))

    def show_window(self, low: float, high: float) -> None:
        """Show a window without emitting a signal."""
        self.histogram.show_window(low, high)
        for field, value in ((self.low, low), (self.high, high)):
            field.blockSignals(True)
            field.setValue(value)
            field.blockSignals(False)


class Histogram(pg.PlotWidget):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Histogram of the gray values on a logarithmic scale, with the window between two lines that can be dragged.

    Parameters
    ----------
    sample : ndarray, shape (N,)
        Gray values.
    low, high : float
        Least and largest of all.
    """

    moved = Signal(float, float)
    """The user has moved a line: the new window."""

    def __init__(self, sample: Array, low: float, high: float) -> None:
        super().__init__(background=None, enableMenu=False)
        self._sample, self._ends = sample, (low, high)
        self.setFixedHeight(_HEIGHT)
        self.setMinimumWidth(100)
        self.hideAxis("left")
        self.hideAxis("bottom")
        self.hideButtons()
        self.setMouseEnabled(False, False)
        self.setToolTip(
            tr("How often each gray value occurs. Drag the two lines: black to the left, white to the right.")
        )
        color = self.palette().color
        self._bars = self.plot(
            stepMode="center", fillLevel=0.0, pen=None, brush=color(QPalette.ColorRole.PlaceholderText)
        )
        line = pg.mkPen(color(QPalette.ColorRole.Highlight), width=3)
        self.window_lines = pg.LinearRegionItem((low, high), pen=line, brush=(128, 128, 128, 40), swapMode="block",
                                                bounds=(low, high))  # fmt: skip
        self.addItem(self.window_lines)
        self.window_lines.sigRegionChanged.connect(lambda region: self.moved.emit(*region.getRegion()))
        self.window_lines.sigRegionChangeFinished.connect(lambda region: self._show_axis(*region.getRegion()))
        self._show_axis(low, high)

    def show_window(self, low: float, high: float) -> None:
        """Show a window; the axis does not change while a line is held."""
        region = self.window_lines
        if not (region.moving or any(line.moving for line in region.lines)):
            region.blockSignals(True)
            region.setRegion((low, high))
            region.blockSignals(False)
            self._show_axis(low, high)

    def _show_axis(self, low: float, high: float) -> None:
        """Show the whole range, or the surroundings of a narrow window."""
        begin, end = self._ends
        if high - low < _NARROW * (end - begin):
            reach = _AROUND * max(high - low, 1e-3 * (end - begin))
            begin, end = max(begin, low - reach), min(end, high + reach)
        counts, edges = np.histogram(self._sample, _BINS, range=(begin, end if end > begin else begin + 1.0))
        self._bars.setData(edges, np.log1p(counts))
        self.setXRange(edges[0], edges[-1], padding=0.02)


def _set_range(field: DecimalField, low: float, high: float, *, whole: bool) -> None:
    span = max(high - low, 1e-12)
    field.setDecimals(0 if whole else min(max(3 - math.floor(math.log10(span)), 0), 12))
    field.setRange(low, high)
    field.setSingleStep(max(1.0, round(span / 256.0)) if whole else 10.0 ** math.floor(math.log10(span / 50.0)))
    field.setKeyboardTracking(False)
