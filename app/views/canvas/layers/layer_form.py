"""The forms for the options of layers; that of the image has a histogram."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QPalette
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
from app.views.canvas.layers.image_layer import CT_WINDOWS, ImageLayer, named, window_at
from app.views.canvas.layers.layer import Choice, Layer, Option, Switch
from app.views.theme import color_maps
from app.views.widgets.fields import DecimalField, MarkedSlider
from cpm_core import Image


class LayerForm(QWidget):
    """A row for each option of a layer; it also follows changes that are made elsewhere."""

    def __init__(self, layer: Layer) -> None:
        super().__init__()
        self.layer = layer
        self.fields: dict[str, QWidget] = {}
        self._shows: dict[str, Callable[[Any], object]] = {}
        """What shows the value of an option in its field."""
        self.rows = QFormLayout(self)
        self.rows.setContentsMargins(0, 0, 0, 0)
        self.rows.setHorizontalSpacing(8)
        self.rows.setVerticalSpacing(4)
        self.rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.levels: Levels | None = None
        self._image: Image | None = None
        for option in layer.options:
            field, self._shows[option.name] = self._field(option)
            self.fields[option.name] = field
            field.setToolTip(option.tip)
            field.setAccessibleName(option.title)
            if isinstance(field, QCheckBox):
                self.rows.addRow(field)
            else:
                self.rows.addRow(_dim_label(option.title, option.tip), field)
        layer.changed.connect(self.show_chosen)
        self.show_chosen()

    def show_chosen(self) -> None:
        """Show the values of the options, and the window of an image."""
        if isinstance(self.layer, ImageLayer):
            self._show_levels(self.layer)
        for name, field in self.fields.items():
            self._shows[name](self.layer.chosen[name])
            field.setEnabled(self.layer.acts(name))

    def _show_levels(self, layer: ImageLayer) -> None:
        image = layer.scene.whole
        if image is not self._image and image is not None:
            self._image = image
            if self.levels is not None:
                self.rows.removeRow(self.levels)
            self.levels = Levels(image, layer.reach)
            self.levels.moved.connect(layer.choose_window)
            self.rows.insertRow(0, self.levels)
        if self.levels is not None:
            self.levels.show_window(*layer.window)

    def _field(self, option: Option) -> tuple[QWidget, Callable[[Any], object]]:
        """The field of an option, and what shows a value in it."""
        choose = partial(self.layer.choose, option.name)
        if isinstance(option, Switch):
            switch = QCheckBox(option.title)
            switch.toggled.connect(choose)
            return switch, switch.setChecked
        if isinstance(option, Choice):
            box = QComboBox()
            box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            box.setIconSize(QSize(36, 12))
            for name, title in option.ways.items():
                box.addItem(color_maps.icon(name) if name in color_maps.MAPS else QIcon(), title, name)
            box.activated.connect(lambda index: choose(box.itemData(index)))
            return box, lambda value: box.setCurrentIndex(box.findData(value))
        slider = MarkedSlider(option.low, option.high, option.step, option.first)
        slider.moved_to.connect(choose)
        slider.restored.connect(lambda: choose(option.first))
        figure = QLabel()
        figure.setMinimumWidth(figure.fontMetrics().horizontalAdvance("0.000"))
        figure.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        both = QWidget()
        both.setFocusProxy(slider)
        row = QHBoxLayout(both)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(slider, 1)
        row.addWidget(figure)

        def show(value: float) -> None:
            slider.show_value(value)
            figure.setText(written(f"{value:g}"))

        return both, show


def _dim_label(title: str, tip: str) -> QLabel:
    label = QLabel(title)
    label.setObjectName("dim")
    label.setToolTip(tip)
    return label


_BINS = 128
_MOST = 100_000
"""Largest number of pixels counted; more would not visibly change the histogram."""

_NARROW, _AROUND = 0.1, 2.0
"""Part of the range below which a window is shown enlarged, and the margin next to it, in window widths."""

_HEIGHT = 72


class Levels(QWidget):
    """Histogram of the gray values on a logarithmic scale, and their window: two lines to drag, and two fields.

    Of CT it has the usual windows as well.

    Parameters
    ----------
    image : Image
        The image.
    ends : tuple of float
        Within which the window may be chosen.
    """

    moved = Signal(float, float)
    """The user has chosen another window."""

    def __init__(self, image: Image, ends: tuple[float, float]) -> None:
        super().__init__()
        values = image.values
        stride = max(1, int((values.size / _MOST) ** (1.0 / values.ndim)))
        self._sample = values[(slice(None, None, stride),) * values.ndim].ravel()
        self._ends = ends
        self.histogram = pg.PlotWidget(background=None, enableMenu=False)
        self.histogram.setFixedHeight(_HEIGHT)
        self.histogram.setMinimumWidth(100)
        self.histogram.hideAxis("left")
        self.histogram.hideAxis("bottom")
        self.histogram.hideButtons()
        self.histogram.setMouseEnabled(False, False)
        self.histogram.setToolTip(
            tr("Histogram of the gray values. Drag the two lines: black to the left, white to the right.")
        )
        color = self.palette().color
        self._bars = self.histogram.plot(
            stepMode="center", fillLevel=0.0, pen=None, brush=color(QPalette.ColorRole.PlaceholderText)
        )
        line = pg.mkPen(color(QPalette.ColorRole.Highlight), width=3)
        self._lines = pg.LinearRegionItem(ends, pen=line, brush=(128, 128, 128, 40), swapMode="block", bounds=ends)
        self.histogram.addItem(self._lines)
        self._lines.sigRegionChanged.connect(lambda lines: self.moved.emit(*lines.getRegion()))
        self._lines.sigRegionChangeFinished.connect(lambda lines: self._show_axis(*lines.getRegion()))
        self.low, self.high = DecimalField(), DecimalField()
        self.low.valueChanged.connect(lambda value: self.moved.emit(value, max(value, self.high.value())))
        self.high.valueChanged.connect(lambda value: self.moved.emit(min(value, self.low.value()), value))
        row = QHBoxLayout()
        row.setSpacing(6)
        titles = ((tr("Black"), tr("Gray value shown as black.")), (tr("White"), tr("Gray value shown as white.")))
        whole, span = bool((self._sample == np.rint(self._sample)).all()), max(ends[1] - ends[0], 1e-12)
        for (title, tip), field in zip(titles, (self.low, self.high), strict=True):
            field.setDecimals(0 if whole else min(max(3 - math.floor(math.log10(span)), 0), 12))
            field.setRange(*ends)
            field.setSingleStep(max(1.0, round(span / 256.0)) if whole else 10.0 ** math.floor(math.log10(span / 50.0)))
            field.setKeyboardTracking(False)
            field.setAccessibleName(title)
            field.setToolTip(tip)
            row.addWidget(_dim_label(title, ""))
            row.addWidget(field, 1)
        self.figures, self.usual = QLabel(), _usual_windows(image)
        self.figures.setObjectName("dim")
        self.figures.setToolTip(tr("Width and level of the range: white minus black, and the middle between them."))
        self.usual.activated.connect(lambda index: self.moved.emit(*self.usual.itemData(index)))
        below = QHBoxLayout()
        below.addWidget(self.figures)
        below.addWidget(self.usual, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.histogram)
        column.addLayout(row)
        column.addLayout(below)

    def show_window(self, low: float, high: float) -> None:
        """Show a window without emitting a signal; the lines and their axis do not change while one is held."""
        self.low.show_value(low)
        self.high.show_value(high)
        self.figures.setText(named((low, high)))
        usual = [*map(window_at, CT_WINDOWS.values())]
        self.usual.setCurrentIndex(usual.index((low, high)) if (low, high) in usual else -1)
        if not (self._lines.moving or any(line.moving for line in self._lines.lines)):
            with QSignalBlocker(self._lines):
                self._lines.setRegion((low, high))
            self._show_axis(low, high)

    def _show_axis(self, low: float, high: float) -> None:
        """Show the whole range, or the surroundings of a narrow window."""
        begin, end = self._ends
        if high - low < _NARROW * (end - begin):
            reach = _AROUND * max(high - low, 1e-3 * (end - begin))
            begin, end = max(begin, low - reach), min(end, high + reach)
        counts, edges = np.histogram(self._sample, _BINS, range=(begin, end if end > begin else begin + 1.0))
        self._bars.setData(edges, np.log1p(counts))
        self.histogram.setXRange(edges[0], edges[-1], padding=0.02)


def _usual_windows(image: Image) -> QComboBox:
    """The usual windows of CT, which images of other kinds do not have."""
    box = QComboBox()
    box.setPlaceholderText(tr("CT window"))
    box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
    box.setMinimumContentsLength(10)
    box.setAccessibleName(tr("CT window"))
    box.setToolTip(tr("The usual windows of CT, in Hounsfield units."))
    box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    for name, usual in CT_WINDOWS.items():
        box.addItem(f"{name}  {named(window_at(usual))}", window_at(usual))
    if not image.is_ct:
        box.hide()
    return box
