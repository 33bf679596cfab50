"""Fields: typed numbers, alternatives, sliders with a mark, positions in a stack, and the speed of the run."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from PySide6.QtCore import QPointF, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPalette, QPolygonF, QValidator, QWheelEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDoubleSpinBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QSlider,
    QSpinBox,
    QStyle,
    QStyleOptionSlider,
    QWidget,
)

from cpm_app.model.state.resolve import INITIAL_PACE_INDEX, RUN_PACES, format_pace
from cpm_app.model.text.language import tr
from cpm_app.session.session import Session
from cpm_app.views.widgets.containers import create_dim_label, fill_layout

_DECIMAL_POINT = "."
"""Decimal mark that is accepted in every language."""

_NO_DECIMALS_FROM = 100.0
"""Value from which a whole number is shown without decimals."""

_DIGITS_PER_GROUP = 3
"""Number of digits between two group separators."""

PLACE_JUMP = 10
"""Slices or pages by which Page Up and Page Down move the slider, at most."""


class WheelWithFocus:
    """Mixin of fields that the wheel changes only while they have the focus; otherwise their column scrolls."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Leave the wheel to the widgets around the field, unless it has the focus."""
        if self.hasFocus():  # type: ignore[attr-defined]  # method of the widget that it is mixed into
            super().wheelEvent(event)  # type: ignore[misc]
        else:
            event.ignore()


class DecimalField(WheelWithFocus, QDoubleSpinBox):
    """Field for numbers as the language writes them, or with a point unless that may be a group separator.

    In a language with a decimal comma ``0.25`` is a quarter, but ``1.250`` is read as the language does, unless that is
    out of range. `words` are shown in place of some values.
    """

    def __init__(
        self,
        low: float = 0.0,
        high: float = 100.0,
        step: float = 1.0,
        decimals: int = 2,
        suffix: str = "",
        words: Sequence[tuple[float, str]] = (),
    ) -> None:
        super().__init__()
        self._words = dict(words)
        self._exact = 0.0
        self.setDecimals(decimals)
        self.setRange(low, high)
        self.setSingleStep(step)
        self.setSuffix(suffix)
        # With tracking each typed digit would set a value, and the "1" of "16" may be out of range.
        self.setKeyboardTracking(False)

    @property
    def exact(self) -> float:
        """Value including the digits that are not shown."""
        return self._exact if self._displays_value(self._exact) else self.value()

    def show_value(self, value: float) -> None:
        """Show a value without emitting a signal."""
        self._exact = value
        if not self._displays_value(value):
            with QSignalBlocker(self):
                self.setValue(value)

    def move_to(self, value: float) -> None:
        """Set a value as if the user had set it, and drop typed text."""
        changed = value != self.exact
        self.setValue(value)
        if changed:
            self.valueChanged.emit(value)

    def textFromValue(self, value: float) -> str:
        """Return the word for a value, or the number; large whole numbers have no decimals."""
        if value in self._words:
            return self._words[value]
        long = self.decimals() and value >= _NO_DECIMALS_FROM and value == round(value)
        return self.locale().toString(value, "f", 0) if long else super().textFromValue(value)

    def validate(self, text: str, place: int) -> tuple[QValidator.State, str, int]:
        """Return whether a text is a number or a word, or the beginning of one."""
        if self._value_of_word(text) is not None:
            return QValidator.State.Acceptable, text, place
        state, _, at = super().validate(self._localize_decimal_point(text), place)
        return state, text, at

    def fixup(self, text: str) -> str:
        """Complete the beginning of a number."""
        return super().fixup(self._localize_decimal_point(text))

    def valueFromText(self, text: str) -> float:
        """Return the number that a text stands for."""
        value = self._value_of_word(text)
        return super().valueFromText(self._localize_decimal_point(text)) if value is None else value

    def _displays_value(self, value: float) -> bool:
        return math.isclose(self.value(), value, abs_tol=0.5 * 10.0 ** -self.decimals())

    def _value_of_word(self, text: str) -> float | None:
        """Return the value that a word stands for, or None."""
        word = text.removesuffix(self.suffix()).strip()
        return next((value for value, known in self._words.items() if known == word), None)

    def _localize_decimal_point(self, text: str) -> str:
        """Return the text with the decimal mark of the language."""
        mark = self.locale().decimalPoint()
        if mark == _DECIMAL_POINT or mark in text or text.count(_DECIMAL_POINT) != 1:
            return text
        converted = text.replace(_DECIMAL_POINT, mark)
        digits = re.search(r"\.(\d*)", text)
        if digits is None or len(digits[1]) != _DIGITS_PER_GROUP or self.locale().groupSeparator() != _DECIMAL_POINT:
            return converted
        state = super().validate(text, len(text))[0]
        return text if state == QValidator.State.Acceptable else converted


class ChoiceBox(WheelWithFocus, QComboBox):
    """Box with alternatives; `titles` maps their names to their titles."""

    value_selected = Signal(str)
    """The user has selected an alternative, by its name."""

    def __init__(self, titles: Mapping[str, str]) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        for name, title in titles.items():
            self.addItem(title, name)
        self.activated.connect(lambda index: self.value_selected.emit(self.itemData(index)))

    def show_value(self, name: str) -> None:
        """Show an alternative without emitting a signal; an unknown name shows nothing."""
        self.setCurrentIndex(self.findData(name))


_MARK_SIZE = 3.5
"""Height of the mark of the default, and half its width [px]."""


class MarkedSlider(WheelWithFocus, QSlider):
    """Slider in steps of a given size; a double click restores the default.

    Parameters
    ----------
    low, high, step : float
        Range and increment.
    default : float or None
        Position of the mark; None for no mark.
    """

    moved_to = Signal(float)
    """The user has moved it to a value."""
    restored = Signal()
    """The user restores the default."""

    def __init__(self, low: float, high: float, step: float, default: float | None = None) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self.exact = low
        """Value that was set last, which may lie between two steps."""
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.set_range(low, high, step, default)
        self.valueChanged.connect(self._on_value_changed)

    def set_range(self, low: float, high: float, step: float, default: float | None) -> None:
        """Change range, increment and the position of the mark; call `show_value` afterwards."""
        self._low, self._step, self._default = low, step, default
        count = max(1, round((high - low) / step))
        with QSignalBlocker(self):
            self.setRange(0, count)
        self.setPageStep(max(1, count // 10))
        self.update()

    def move_to(self, value: float) -> None:
        """Move the slider to a value, as if the user had moved it."""
        if value != self.exact:
            self.show_value(value)
            self.moved_to.emit(value)

    def show_value(self, value: float) -> None:
        """Show a value, clipped to the range, without emitting a signal."""
        self.exact = value
        with QSignalBlocker(self):
            self.setValue(round((value - self._low) / self._step))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Restore the default."""
        event.accept()
        self.restored.emit()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the mark below the groove."""
        super().paintEvent(event)
        if self._default is None:
            return
        option = QStyleOptionSlider()
        self.initStyleOption(option)
        handle = self.style().subControlRect(
            QStyle.ComplexControl.CC_Slider, option, QStyle.SubControl.SC_SliderHandle, self
        )
        room = self.width() - handle.width()
        fraction = (self._default - self._low) / (self._step * max(1, self.maximum()))
        if not 0.0 <= fraction <= 1.0:
            return
        x, y = handle.width() / 2 + fraction * room, self.height() - 1.0
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.palette().color(QPalette.ColorRole.PlaceholderText))
        painter.drawPolygon(
            QPolygonF([QPointF(x, y - _MARK_SIZE), QPointF(x - _MARK_SIZE, y), QPointF(x + _MARK_SIZE, y)])
        )
        painter.end()

    def _on_value_changed(self, value: int) -> None:
        self.exact = round(self._low + value * self._step, 9)
        self.moved_to.emit(self.exact)


class PlaceBar(QFrame):
    """Line below the canvas that selects a slice or page by a slider and a number.

    `title` and `name` are the accessible names of slider and number.
    """

    moved = Signal(int)
    """The user selects a slice or page."""

    def __init__(self, title: str, name: str) -> None:
        super().__init__()
        self.setObjectName("slices")
        self.slider, self.number, self.total_label = QSlider(Qt.Orientation.Horizontal), QSpinBox(), create_dim_label()
        self.slider.setAccessibleName(title)
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.number.setAccessibleName(name)
        self.number.setKeyboardTracking(False)
        self.slider.valueChanged.connect(self.moved)
        self.number.valueChanged.connect(self.moved)
        self.hide()

    def show_position(self, place: int, last: int) -> None:
        """Show the selected number, from 1 to the last."""
        for field in (self.slider, self.number):
            with QSignalBlocker(field):
                field.setRange(1, last)
                field.setValue(place)
        self.slider.setPageStep(min(max((last - 1) // 10, 1), PLACE_JUMP))  # the wheel moves no further than this
        self.total_label.setText(tr("of {last}", last=last))


class SpeedControl(QWidget):
    """Slider from one step per second to as many as possible."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, len(RUN_PACES) - 1)
        self.slider.setPageStep(1)
        self.slider.setValue(INITIAL_PACE_INDEX)
        self.slider.setFixedWidth(76)
        self.slider.setAccessibleName(tr("Speed"))
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.label = QLabel(format_pace(RUN_PACES[INITIAL_PACE_INDEX]))
        self.label.setMinimumWidth(
            self.label.fontMetrics().horizontalAdvance(max(map(format_pace, RUN_PACES), key=len)) + 8
        )
        self.setToolTip(tr("Maximum number of steps per second."))
        fill_layout(QHBoxLayout(self), self.slider, self.label, margins=(6, 0, 6, 0))
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)
        self.slider.valueChanged.connect(self._on_pace_changed)
        # the next image runs at the usual speed, if this one was watched at a lower one
        session.image_changed.connect(lambda: self.slider.setValue(max(self.slider.value(), INITIAL_PACE_INDEX)))

    def speed_up(self) -> None:
        """Move the slider one notch up."""
        self.slider.setValue(self.slider.value() + 1)

    def slow_down(self) -> None:
        """Move the slider one notch down."""
        self.slider.setValue(self.slider.value() - 1)

    def _on_pace_changed(self, index: int) -> None:
        self.label.setText(format_pace(RUN_PACES[index]))
        self._session.set_pace(RUN_PACES[index])
