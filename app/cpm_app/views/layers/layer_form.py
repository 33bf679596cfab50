"""The forms for the options of layers; the form of the image has a histogram."""

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

from cpm_app.model.text.language import localize_number, tr
from cpm_app.views.layers.image_layer import CT_WINDOWS, ImageLayer, format_window, window_from_level
from cpm_app.views.layers.layer import Layer, Option
from cpm_app.views.theme import color_maps
from cpm_app.views.widgets.containers import create_dim_label, fill_layout
from cpm_app.views.widgets.fields import ChoiceBox, DecimalField, MarkedSlider
from cpm_core import Image


class LayerForm(QWidget):
    """A row for each option of a layer; it also shows changes made elsewhere."""

    def __init__(self, layer: Layer) -> None:
        super().__init__()
        self.layer = layer
        self.fields: dict[str, QWidget] = {}
        self._value_setters: dict[str, Callable[[Any], object]] = {}
        """Functions that show the value of an option in its field."""
        grows = QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow
        self.rows = QFormLayout(self, horizontalSpacing=8, verticalSpacing=4, fieldGrowthPolicy=grows)
        self.rows.setContentsMargins(0, 0, 0, 0)
        self.levels: LevelsEditor | None = None
        self._image: Image | None = None
        for option in layer.options:
            field, self._value_setters[option.name] = self._create_field(option)
            self.fields[option.name] = field
            field.setToolTip(option.tip)
            field.setAccessibleName(option.title)
            if isinstance(field, QCheckBox):
                self.rows.addRow(field)
            else:
                self.rows.addRow(create_dim_label(option.title, option.tip), field)
        layer.changed.connect(self.show_option_values)
        self.show_option_values()

    def show_option_values(self) -> None:
        """Show the values of the options, and the window of an image."""
        if isinstance(self.layer, ImageLayer):
            self._show_levels(self.layer)
        for name, field in self.fields.items():
            self._value_setters[name](self.layer.option_values[name])
            field.setEnabled(self.layer.has_effect(name))

    def _show_levels(self, layer: ImageLayer) -> None:
        image = layer.scene.full_image
        if image is not self._image and image is not None:
            self._image = image
            if self.levels is not None:
                self.rows.removeRow(self.levels)
            self.levels = LevelsEditor(image, layer.window_bounds)
            self.levels.moved.connect(layer.set_window)
            self.rows.insertRow(0, self.levels)
        if self.levels is not None:
            self.levels.show_window(*layer.window)

    def _create_field(self, option: Option) -> tuple[QWidget, Callable[[Any], object]]:
        """Create the field of an option, and the function that shows a value in it."""
        set_option = partial(self.layer.set_option, option.name)
        if isinstance(option.default, bool):
            switch = QCheckBox(option.title)
            switch.toggled.connect(set_option)
            return switch, switch.setChecked
        if option.choices:
            box = ChoiceBox(option.choices)
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            box.setIconSize(QSize(36, 12))
            for index, name in enumerate(option.choices):
                box.setItemIcon(index, color_maps.create_map_icon(name) if name in color_maps.COLOR_MAPS else QIcon())
            box.value_selected.connect(set_option)
            return box, box.show_value
        slider = MarkedSlider(*option.bounds, float(option.default))
        slider.moved_to.connect(set_option)
        slider.restored.connect(lambda: set_option(option.default))
        figure = QLabel(alignment=Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        figure.setMinimumWidth(figure.fontMetrics().horizontalAdvance("0.000"))
        both = QWidget()
        both.setFocusProxy(slider)
        fill_layout(QHBoxLayout(both), slider, figure, wide=slider)

        def show_amount(value: float) -> None:
            slider.show_value(value)
            figure.setText(localize_number(f"{value:g}"))

        return both, show_amount


_HISTOGRAM_BINS = 128
"""Number of bins of the histogram."""

_MAX_SAMPLED_PIXELS = 100_000
"""Largest number of pixels counted; more would not visibly change the histogram."""

_NARROW_FRACTION = 0.1
"""Fraction of the range below which a window is shown enlarged."""

_NARROW_MARGIN = 2.0
"""Margin on either side of an enlarged window [widths of the window]."""

_HISTOGRAM_HEIGHT = 72
"""Height of the histogram [px of the screen]."""


class LevelsEditor(QWidget):
    """Histogram of the gray values on a logarithmic scale, and their window: two lines to drag, and two fields.

    For CT it also offers the usual windows.

    Parameters
    ----------
    image : Image
        The image.
    ends : tuple of float
        Bounds of the window.
    """

    moved = Signal(float, float)
    """The user has set another window."""

    def __init__(self, image: Image, ends: tuple[float, float]) -> None:
        super().__init__()
        values = image.values
        stride = max(1, int((values.size / _MAX_SAMPLED_PIXELS) ** (1.0 / values.ndim)))
        self._sample = values[(slice(None, None, stride),) * values.ndim].ravel()
        self._ends = ends
        self.histogram = pg.PlotWidget(background=None, enableMenu=False)
        self.histogram.setFixedHeight(_HISTOGRAM_HEIGHT)
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
        whole, span = bool((self._sample == np.rint(self._sample)).all()), max(ends[1] - ends[0], 1e-12)
        decimals = 0 if whole else min(max(3 - math.floor(math.log10(span)), 0), 12)
        step = max(1.0, round(span / 256.0)) if whole else 10.0 ** math.floor(math.log10(span / 50.0))
        self.low, self.high = DecimalField(*ends, step, decimals), DecimalField(*ends, step, decimals)
        self.low.valueChanged.connect(lambda value: self.moved.emit(value, max(value, self.high.value())))
        self.high.valueChanged.connect(lambda value: self.moved.emit(min(value, self.low.value()), value))
        row = fill_layout(QHBoxLayout(), spacing=6)
        for title, tip, field in (
            (tr("Black"), tr("Gray value shown as black."), self.low),
            (tr("White"), tr("Gray value shown as white."), self.high),
        ):
            field.setAccessibleName(title)
            field.setToolTip(tip)
            row.addWidget(create_dim_label(title))
            row.addWidget(field, 1)
        tip = tr("Width and level of the range: white minus black, and the middle between them.")
        self.figures = create_dim_label(tip=tip)
        usual = {
            name: f"{title}  {format_window(window_from_level(window))}" for name, (title, window) in CT_WINDOWS.items()
        }
        self.usual = ChoiceBox(usual)
        self.usual.setPlaceholderText(tr("CT window"))
        self.usual.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.usual.setMinimumContentsLength(10)
        self.usual.setAccessibleName(tr("CT window"))
        self.usual.setToolTip(tr("The usual windows of CT, in Hounsfield units."))
        self.usual.value_selected.connect(lambda name: self.moved.emit(*window_from_level(CT_WINDOWS[name][1])))
        self.usual.setVisible(image.is_ct)
        below = fill_layout(QHBoxLayout(), self.figures, self.usual, wide=self.usual)
        fill_layout(QVBoxLayout(self), self.histogram, row, below, spacing=4)

    def show_window(self, low: float, high: float) -> None:
        """Show a window without emitting a signal; leave the lines and their axis alone while a line is dragged."""
        self.low.show_value(low)
        self.high.show_value(high)
        self.figures.setText(format_window((low, high)))
        usual = (name for name, (_, window) in CT_WINDOWS.items() if window_from_level(window) == (low, high))
        self.usual.show_value(next(usual, ""))
        if not (self._lines.moving or any(line.moving for line in self._lines.lines)):
            with QSignalBlocker(self._lines):
                self._lines.setRegion((low, high))
            self._show_axis(low, high)

    def _show_axis(self, low: float, high: float) -> None:
        """Show the whole range, or the surroundings of a narrow window."""
        begin, end = self._ends
        if high - low < _NARROW_FRACTION * (end - begin):
            reach = _NARROW_MARGIN * max(high - low, 1e-3 * (end - begin))
            begin, end = max(begin, low - reach), min(end, high + reach)
        counts, edges = np.histogram(self._sample, _HISTOGRAM_BINS, range=(begin, end if end > begin else begin + 1.0))
        self._bars.setData(edges, np.log1p(counts))
        self.histogram.setXRange(edges[0], edges[-1], padding=0.02)
