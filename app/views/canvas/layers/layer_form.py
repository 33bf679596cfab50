"""The forms for the options of layers; that of the image has a histogram."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
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
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array


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
        for option in layer.options:
            self._add(option)
        layer.changed.connect(self.show_chosen)
        self.show_chosen()

    def show_chosen(self) -> None:
        """Show the values of the options."""
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
"""Part of the range below which a window is shown enlarged, and the margin beside it, in window widths."""

_HANDLE = 5.0
_HEIGHT = 64


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
        whole = bool((sample == np.rint(sample)).all())
        self.low = _field(tr("Black"), tr("Gray value shown black."), *ends, whole)
        self.high = _field(tr("White"), tr("Gray value shown white."), *ends, whole)
        row = QHBoxLayout()
        row.setSpacing(6)
        for title, field in ((tr("Black"), self.low), (tr("White"), self.high)):
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


class Histogram(QWidget):
    """Histogram of the gray values on a logarithmic scale, with the window between two handles.

    Parameters
    ----------
    sample : ndarray, shape (N,)
        Gray values.
    low, high : float
        Least and largest of all.
    """

    moved = Signal(float, float)
    """The user has moved a handle: the new window."""

    def __init__(self, sample: Array, low: float, high: float) -> None:
        super().__init__()
        self._sample, self._ends = sample, (low, high)
        self._window = (low, high)
        self._axis = (0.0, 0.0)
        self._heights: Array = np.zeros(_BINS)
        self._held: int | None = None
        self.setMinimumHeight(_HEIGHT)
        self.setMouseTracking(True)
        self.setToolTip(
            tr("How often each gray value occurs. Drag the two lines: black to the left, white to the right.")
        )
        self._show_axis(low, high)

    def sizeHint(self) -> QSize:
        """Preferred size."""
        return QSize(240, _HEIGHT)

    def show_window(self, low: float, high: float) -> None:
        """Show a window; the axis does not change while a handle is held."""
        self._window = (low, high)
        if self._held is None:
            self._show_axis(low, high)
        self.update()

    def x_of(self, value: float) -> float:
        """Position of a gray value [px of the widget]."""
        begin, end = self._axis
        return _HANDLE + (value - begin) / (end - begin) * (self.width() - 2 * _HANDLE)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take hold of the nearer handle."""
        event.accept()
        x = event.position().x()
        low, high = (self.x_of(value) for value in self._window)
        self._held = 0 if abs(x - low) < abs(x - high) or (low == high and x < low) else 1
        self._drag(x)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move the handle."""
        event.accept()
        self.setCursor(Qt.CursorShape.SizeHorCursor)
        if self._held is not None:
            self._drag(event.position().x())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Release the handle."""
        event.accept()
        self._held = None
        self._show_axis(*self._window)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the counts, a veil outside the window, and the handles."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        role = QPalette.ColorRole
        color = self.palette().color
        area = QRectF(self.rect()).adjusted(_HANDLE, 0.5, -_HANDLE, -0.5)
        painter.fillRect(area, color(role.Base))
        x = area.left() + np.linspace(0.0, area.width(), _BINS)
        y = area.bottom() - self._heights * (area.height() - 4.0)
        outline = [QPointF(a, b) for a, b in zip(x, y, strict=True)]
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(color(role.PlaceholderText))
        painter.drawPolygon(QPolygonF([area.bottomLeft(), *outline, area.bottomRight()]))
        low, high = (min(max(self.x_of(value), area.left()), area.right()) for value in self._window)
        veil = color(role.Window)
        veil.setAlpha(170)
        painter.fillRect(QRectF(area.left(), area.top(), low - area.left(), area.height()), veil)
        painter.fillRect(QRectF(high, area.top(), area.right() - high, area.height()), veil)
        painter.setPen(QPen(color(role.Highlight), 2.0))
        for at in (low, high):
            painter.drawLine(QPointF(at, area.top()), QPointF(at, area.bottom()))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(color(role.Highlight))
        for at in (low, high):
            painter.drawRoundedRect(QRectF(at - 4.0, area.center().y() - 8.0, 8.0, 16.0), 2.0, 2.0)
        painter.end()

    def _drag(self, x: float) -> None:
        begin, end = self._axis
        value = begin + (x - _HANDLE) / max(self.width() - 2 * _HANDLE, 1.0) * (end - begin)
        value = min(max(value, self._ends[0]), self._ends[1])
        low, high = self._window
        low, high = (min(value, high), high) if self._held == 0 else (low, max(value, low))
        self._window = (low, high)
        self.update()
        self.moved.emit(low, high)

    def _show_axis(self, low: float, high: float) -> None:
        """Show the whole range, or the surroundings of a narrow window."""
        begin, end = self._ends
        if high - low < _NARROW * (end - begin):
            reach = _AROUND * max(high - low, 1e-3 * (end - begin))
            begin, end = max(begin, low - reach), min(end, high + reach)
        if begin == end:
            end = begin + 1.0
        if (begin, end) != self._axis:
            self._axis = (begin, end)
            counts = np.histogram(self._sample, _BINS, range=(begin, end))[0]
            self._heights = np.log1p(counts) / max(float(np.log1p(counts.max())), 1e-9)


def _field(title: str, tip: str, low: float, high: float, whole: bool) -> QDoubleSpinBox:
    field = DecimalField()
    field.setAccessibleName(title)
    field.setToolTip(tip)
    span = max(high - low, 1e-12)
    field.setDecimals(0 if whole else min(max(3 - math.floor(math.log10(span)), 0), 12))
    field.setRange(low, high)
    field.setSingleStep(max(1.0, round(span / 256.0)) if whole else 10.0 ** math.floor(math.log10(span / 50.0)))
    field.setKeyboardTracking(False)
    return field


class ImageForm(LayerForm):
    """The options of the image layer below the histogram of its image."""

    def __init__(self, layer: ImageLayer) -> None:
        self.levels: Levels | None = None
        self._image: Image | None = None
        self._own = layer
        super().__init__(layer)

    def show_chosen(self) -> None:
        """Show options, histogram and window."""
        super().show_chosen()
        image = self._own.scene.whole
        if image is not self._image and image is not None:
            self._image = image
            if self.levels is not None:
                self.rows.removeRow(self.levels)
            self.levels = Levels(image.values, self._own.ends, self._own.window)
            self.levels.moved.connect(self._own.choose_window)
            self.rows.insertRow(0, self.levels)
        elif self.levels is not None:
            self.levels.show_window(*self._own.window)
