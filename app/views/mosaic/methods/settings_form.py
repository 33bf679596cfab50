"""The parameters of one method, each with a field, a slider and its words."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QLabel, QSlider, QVBoxLayout, QWidget

from app.model.text.language import from_core
from app.views.widgets.fields.decimal_field import DecimalField
from cpm_core.objects.methods import Settings
from cpm_core.parameters import ParameterInfo

_NOTCHES = 200


class SettingsForm(QWidget):
    """Fields for the settings of a method, made again for each method."""

    changed = Signal(object)
    """The settings have been changed: Settings."""

    def __init__(self) -> None:
        super().__init__()
        self.fields: dict[str, QDoubleSpinBox] = {}
        self._settings: Settings | None = None
        self._layout = QVBoxLayout(self)
        self._layout.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._body: QWidget | None = None

    def show_settings(self, settings: Settings | None, otherwise: str) -> None:
        """Show settings, or a sentence where there are none to show."""
        if settings is not None and settings == self._settings and self.fields:
            return
        self._settings, self.fields = settings, {}
        if self._body is not None:
            self._layout.removeWidget(self._body)
            self._body.hide()  # it is deleted later than what takes its place is shown
            self._body.deleteLater()
        self._body = QWidget()
        rows = QVBoxLayout(self._body)
        rows.setContentsMargins(0, 0, 0, 0)
        if settings is None:
            sentence = QLabel(otherwise)
            sentence.setWordWrap(True)
            rows.addWidget(sentence)
        else:
            for name, info in settings.table().items():
                self._add_row(rows, name, info, getattr(settings, name))
        self._layout.addWidget(self._body)

    def _add_row(self, rows: QVBoxLayout, name: str, info: ParameterInfo, value: float) -> None:
        unit = f" {info.unit}" if info.unit else ""
        label = QLabel(f"{from_core(info.title)}  {info.symbol}")
        field = DecimalField()
        field.setDecimals(max(0, -math.floor(math.log10(info.step))))
        field.setRange(info.low, info.high)
        field.setSingleStep(info.step)
        field.setSuffix(unit)
        field.setValue(value)
        field.setKeyboardTracking(False)
        slider = QSlider(Qt.Orientation.Horizontal)
        slider.setRange(0, _NOTCHES)
        slider.setValue(_notch(info, value))
        words = f"{from_core(info.meaning)} {from_core(info.more)}"
        for widget in (label, field, slider):
            widget.setToolTip(words)
        for widget in (field, slider):
            widget.setAccessibleName(from_core(info.title))
            widget.setAccessibleDescription(words)
        field.valueChanged.connect(partial(self._take, name, slider, info))
        slider.valueChanged.connect(lambda notch: field.setValue(_value(info, notch)))
        for widget in (label, field, slider):
            rows.addWidget(widget)
        self.fields[name] = field

    def _take(self, name: str, slider: QSlider, info: ParameterInfo, value: float) -> None:
        if self._settings is None:
            return
        slider.blockSignals(True)
        slider.setValue(_notch(info, value))
        slider.blockSignals(False)
        whole = isinstance(getattr(type(self._settings), name), int)
        self._settings = replace(self._settings, **{name: int(value) if whole else value})
        self.changed.emit(self._settings)


def _notch(info: ParameterInfo, value: float) -> int:
    share = (value - info.slider_low) / (info.slider_high - info.slider_low)
    return round(_NOTCHES * min(max(share, 0.0), 1.0))


def _value(info: ParameterInfo, notch: int) -> float:
    raw = info.slider_low + (info.slider_high - info.slider_low) * notch / _NOTCHES
    return float(round(raw / info.step) * info.step)
