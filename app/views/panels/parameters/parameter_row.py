"""One parameter: label, number, slider, and a button that restores its default."""

from __future__ import annotations

import math

from PySide6.QtCore import QEvent, QObject, QPoint, Qt, Signal
from PySide6.QtGui import QAction, QEnterEvent, QValidator, QWheelEvent
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QGridLayout,
    QLabel,
    QToolButton,
    QWhatsThis,
    QWidget,
)

from app.model.parameters.controls import Control, in_dimension, slider_range
from app.model.text.language import tr, written
from app.model.text.wording import FIRST_WORDING, Wording
from app.views.panels.parameters.explanation import tip
from app.views.theme.icons import icon
from app.views.theme.theme import Theme
from app.views.widgets.fields.decimal_field import DecimalField
from app.views.widgets.fields.marked_slider import MarkedSlider

_SAME = 1e-9

_WIDTH, _ARROWS, _LONGEST = 106, 44, "0000.0"
"""Width of the field of a number, that of its arrows and margins [px], and a number that has room beside any unit."""


class Number(DecimalField):
    """A number field that shows words for some values; the wheel changes it only while it has the focus."""

    def __init__(self, words: tuple[tuple[float, str], ...]) -> None:
        super().__init__()
        self._words = dict(words)
        self.exact = 0.0
        """The value that it was last given, with more digits than are shown."""

    def textFromValue(self, value: float) -> str:
        """The word for a value, or the number."""
        return self._words.get(value) or super().textFromValue(value)

    def valueFromText(self, text: str) -> float:
        """The value of a word, or the number."""
        spoken = {word: value for value, word in self._words.items()}
        word = text.removesuffix(self.suffix()).strip()
        return spoken[word] if word in spoken else super().valueFromText(text)

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        """Accept the words as well."""
        word = text.removesuffix(self.suffix()).strip()
        if word in self._words.values():
            return QValidator.State.Acceptable, text, position
        return super().validate(text, position)

    def move_to(self, value: float) -> None:
        """Set a value, and drop what has been typed."""
        changed = value != self.exact
        self.setValue(value)
        if changed:
            self.valueChanged.emit(value)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Scroll the column unless the number has the focus."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()


class ParameterRow(QWidget):
    """Shows one control and reports the changes that the user makes."""

    changed = Signal(str, object)
    """Name of the control and its new value."""
    released = Signal()
    """The user has finished one change."""
    explained = Signal(object)
    """The pointer or the focus is on this control."""

    def __init__(self, control: Control) -> None:
        super().__init__()
        self.control = self._in_image = control
        numeric = control.default if isinstance(control.default, float | int) else None
        self._label = QLabel()
        self.number = Number(control.words)
        self.slider = MarkedSlider(control.slider_low, control.slider_high, control.step, numeric)
        self._automatic = QCheckBox(tr("auto")) if control.automatic else None
        self._restore = QToolButton()
        self.effect = QLabel()
        self._set_up()
        self._lay_out()
        self._connect()

    def show_value(self, value: float | str, contrast: float) -> None:
        """Show a value or ``"auto"``; the range of some sliders depends on the contrast of the image."""
        low, high = slider_range(self.control, contrast)
        step = self.control.step * (high - low) / (self.control.slider_high - self.control.slider_low)
        self.slider.set_range(low, high, step)
        by_hand = not isinstance(value, str)
        if self._automatic is not None:
            self._automatic.setChecked(not by_hand)
        self.number.setEnabled(by_hand)
        self.slider.setEnabled(by_hand)
        if not isinstance(value, str):
            self.slider.show_value(value)
            self.number.exact = value
            spoken = value in dict(self.control.words)
            self.number.setSuffix(f" {self.control.unit}" if self.control.unit and not spoken else "")
            if not math.isclose(self.number.value(), value, abs_tol=0.5 * 10.0 ** -self.number.decimals()):
                self.number.blockSignals(True)
                self.number.setValue(value)
                self.number.blockSignals(False)
        default = self.control.default
        same = value == default if isinstance(value, str) or isinstance(default, str) else abs(value - default) < _SAME
        self._restore.setEnabled(not same)

    def use_dimension(self, ndim: int) -> None:
        """Say what it is in an image, or in a volume, which has three axes."""
        made = in_dimension(self._in_image, ndim)
        if made != self.control:
            self.control = made
            for widget in (self._label, self.number, self.slider):
                widget.setToolTip(tip(made))

    def show_effect(self, words: str) -> None:
        """Show what the present value changes, below the slider."""
        self.effect.setText(words)
        self.effect.setVisible(bool(words))

    def use_wording(self, wording: Wording) -> None:
        """Label it by name or by symbol first."""
        self._label.setText(self.control.label(wording))

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The parameter. See `MenuOwner`."""
        if not self.actions():
            self._add_actions()
        return "parameter", point if point is not None else self.slider.geometry().center()

    def use_theme(self, theme: Theme) -> None:
        """Color the button."""
        self._restore.setIcon(icon("restore", theme.accent, faded=theme.line))

    def enterEvent(self, event: QEnterEvent) -> None:
        """Explain the control under the pointer."""
        self.explained.emit(self.control)
        super().enterEvent(event)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Explain the control with the focus, and restore the default on a double click on the name."""
        if watched is self._label:
            if event.type() == QEvent.Type.MouseButtonDblClick:
                self._reset()
        elif event.type() == QEvent.Type.FocusIn:
            self.explained.emit(self.control)
        elif event.type() == QEvent.Type.FocusOut:
            self.released.emit()
        return False

    def _set_up(self) -> None:
        control = self.control
        self.number.setRange(control.low, control.high)
        self.number.setSingleStep(control.step)
        self.number.setDecimals(control.decimals)
        self.number.setKeyboardTracking(False)
        self.number.setSuffix(f" {control.unit}" if control.unit else "")
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        longest = self.number.fontMetrics().horizontalAdvance(f"{_LONGEST} {control.unit}")
        self.number.setFixedWidth(max(_WIDTH, longest + _ARROWS))
        self.effect.setObjectName("dim")
        self.effect.hide()
        self._restore.setObjectName("restore")
        self._restore.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._restore.setAccessibleName(tr("{parameter}: restore the default").format(parameter=control.title))
        default = control.default if isinstance(control.default, str) else written(f"{control.default:.4g}")
        restore = tr("Restore the default, {default} (or double-click the slider or its name).")
        self._restore.setToolTip(restore.format(default=default))
        self._label.setBuddy(self.number)
        self._label.installEventFilter(self)
        for widget in (self._label, self.number, self.slider):
            widget.setToolTip(tip(control))
        self.use_wording(FIRST_WORDING)
        for field in (self.number, self.slider):
            field.setAccessibleName(control.title)
            field.setAccessibleDescription(f"{control.facts}. {control.meaning} {control.more}")
            field.installEventFilter(self)
        if control.by_hand is not None:
            self.number.setValue(control.by_hand)
            self.slider.show_value(control.by_hand)
        if self._automatic is not None:
            self._automatic.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            self._automatic.setToolTip(control.by_itself)
            self._automatic.installEventFilter(self)

    def _lay_out(self) -> None:
        low, high = (QLabel(self._word(value)) for value in (self.control.slider_low, self.control.slider_high))
        for end in (low, high):
            end.setObjectName("dim")
        if self.control.in_gray_levels:
            low.hide()
            high.hide()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 2, 0, 2)
        grid.setVerticalSpacing(0)
        grid.setHorizontalSpacing(6)
        grid.addWidget(self._label, 0, 0, 1, 2)
        grid.addWidget(self.slider, 1, 1, 1, 2)  # before the number, so that Tab reaches it first
        if self._automatic is not None:
            grid.addWidget(self._automatic, 0, 2, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self.number, 0, 3, 1, 2, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(low, 1, 0)
        grid.addWidget(high, 1, 3)
        grid.addWidget(self._restore, 1, 4, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self.effect, 2, 1, 1, 3)
        grid.setColumnStretch(1, 1)

    def _word(self, value: float) -> str:
        return dict(self.control.words).get(value, written(f"{value:g}"))

    def _connect(self) -> None:
        self.slider.moved_to.connect(self._report)
        self.slider.sliderReleased.connect(self.released)
        self.slider.restored.connect(self._reset)
        self.number.valueChanged.connect(self._report)
        self.number.editingFinished.connect(self.released)
        self._restore.clicked.connect(self._reset)
        if self._automatic is not None:
            self._automatic.clicked.connect(self._set_automatic)

    def _add_actions(self) -> None:
        """Make the actions of its menu, when that is opened first."""
        for text, do in (
            (tr("&Restore the default"), self._reset),
            (tr("&Copy the value"), lambda: QApplication.clipboard().setText(f"{self.number.exact:.10g}")),
            (tr("&Explain"), lambda: QWhatsThis.showText(self.mapToGlobal(QPoint(0, 0)), tip(self.control), self)),
        ):
            action = QAction(text, self)
            action.triggered.connect(lambda _=False, do=do: do())
            self.addAction(action)

    def _report(self, value: float) -> None:
        self.changed.emit(self.control.name, int(value) if self.control.whole else value)

    def _reset(self) -> None:
        self.released.emit()
        self.changed.emit(self.control.name, self.control.default)
        self.released.emit()

    def _set_automatic(self, automatic: bool) -> None:
        self.released.emit()
        self.changed.emit(self.control.name, "auto" if automatic else self.number.value())
        self.released.emit()
