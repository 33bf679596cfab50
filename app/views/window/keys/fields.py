"""Fields and what they take as text, and the values that they hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from PySide6.QtCore import QLocale, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QComboBox,
    QDoubleSpinBox,
    QLineEdit,
    QPlainTextEdit,
    QSlider,
    QSpinBox,
    QTextEdit,
    QWidget,
)

Text = Callable[[str], bool]


@runtime_checkable
class Exact(Protocol):
    """A field that shows its value rounded."""

    exact: float
    """The value that it was last given."""

    def move_to(self, value: float) -> None:
        """Set a value, as if the person had done so."""


def _number(character: str) -> bool:
    """Digits, signs and separators; no letters, so that a number has no exponent."""
    locale = QLocale()
    return character.isdigit() or character in f"+-.,{locale.decimalPoint()}{locale.groupSeparator()}"


def _anything(character: str) -> bool:
    return True


def _nothing(character: str) -> bool:
    return False


TEXTS: tuple[tuple[tuple[type[QWidget], ...], Text], ...] = (
    ((QAbstractSpinBox,), _number),
    ((QLineEdit, QTextEdit, QPlainTextEdit), _anything),
    ((QAbstractButton, QComboBox, QSlider), _nothing),
)
"""Which characters a field takes as text; all others belong to the window."""

_HELD = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.KeypadModifier | Qt.KeyboardModifier.GroupSwitchModifier
"""Modifier keys with which a key still writes a character."""


def types(event: QKeyEvent) -> bool:
    """Whether a key writes a character."""
    return bool(event.text()) and event.text().isprintable() and not event.modifiers() & ~_HELD


def is_field(widget: QWidget) -> bool:
    """Whether a widget holds a value or is a button, and is not an editor inside a table."""
    return any(isinstance(widget, kinds) for kinds, _ in TEXTS) and not in_view(widget)


def takes(widget: QWidget, event: QKeyEvent) -> bool:
    """Whether a key that writes a character is text for a widget."""
    if isinstance(widget, QComboBox) and widget.isEditable():
        return True
    text = next((text for kinds, text in TEXTS if isinstance(widget, kinds)), _nothing)
    return all(map(text, event.text()))


def in_view(widget: QWidget) -> bool:
    """Whether a widget is the editor of a table or a list."""
    viewport = widget.parentWidget()
    return viewport is not None and isinstance(viewport.parentWidget(), QAbstractItemView)


def value_of(widget: QWidget) -> Any:
    """The value of a field; None for what holds none."""
    match widget:
        case Exact():
            return widget.exact
        case QSpinBox() | QDoubleSpinBox() | QSlider():
            return widget.value()
        case QComboBox():
            return widget.currentIndex()
        case QLineEdit():
            return widget.text()
    return None


def put_back(widget: QWidget, value: Any) -> None:
    """Restore the value of a field, as if the person had set it."""
    match widget:
        case Exact():
            widget.move_to(value)
        case QSpinBox() | QDoubleSpinBox() | QSlider():
            widget.setValue(value)  # also drops what has been typed and not entered
        case QComboBox():
            if value != widget.currentIndex():
                widget.setCurrentIndex(value)
                widget.activated.emit(value)
        case QLineEdit():
            widget.setText(value)
