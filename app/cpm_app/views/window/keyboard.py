"""The keyboard: who gets a key, and where the keyboard goes next."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import shiboken6
from PySide6.QtCore import QCoreApplication, QEvent, QLocale, QObject, Qt, QTimer
from PySide6.QtGui import QGuiApplication, QKeyEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDialog,
    QLineEdit,
    QMainWindow,
    QMenu,
    QMenuBar,
    QPlainTextEdit,
    QScrollArea,
    QSlider,
    QTextEdit,
    QWidget,
)

from cpm_app.views.widgets.containers import ENTER, has_own_escape
from cpm_app.views.widgets.fields import DecimalField, MarkedSlider

_FIELDS = (QAbstractSpinBox, QLineEdit, QTextEdit, QPlainTextEdit, QAbstractButton, QComboBox, QSlider)
"""What holds a value or is a button."""

_HELD = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.KeypadModifier | Qt.KeyboardModifier.GroupSwitchModifier
"""Modifier keys with which a key still writes a character."""


def in_view(widget: QWidget) -> bool:
    """Whether a widget is the editor of a table or a list."""
    viewport = widget.parentWidget()
    return viewport is not None and isinstance(viewport.parentWidget(), QAbstractItemView)


def leaves(widget: QWidget, event: QKeyEvent) -> bool:
    """Whether a key writes a character that is no text for a field, so that it is a key of the window."""
    text = event.text()
    if not text or not text.isprintable() or event.modifiers() & ~_HELD:
        return False
    if not isinstance(widget, _FIELDS) or in_view(widget):
        return False
    match widget:
        case QAbstractSpinBox():  # no letters, so that a number has no exponent
            locale = QLocale()
            signs = f"+-.,{locale.decimalPoint()}{locale.groupSeparator()}"
            return not all(character.isdigit() or character in signs for character in text)
        case QComboBox():
            return not widget.isEditable()
    return isinstance(widget, QAbstractButton | QSlider)


def value_of(widget: QWidget) -> Any:
    """The value of a field, which its class names in Qt; None for what holds none."""
    return (
        widget.exact
        if isinstance(widget, DecimalField | MarkedSlider)
        else widget.metaObject().userProperty().read(widget)
    )


def put_back(widget: QWidget, value: Any) -> None:
    """Restore the value of a field, as if the user had set it; what has been typed and not entered is dropped."""
    if isinstance(widget, DecimalField | MarkedSlider):
        widget.move_to(value)
        return
    changed = value != value_of(widget)
    widget.metaObject().userProperty().write(widget, value)
    if changed and isinstance(widget, QComboBox):
        widget.activated.emit(widget.currentIndex())


class Keyboard(QObject):
    """Decides on the keys of the focused widget of the window; dialogs are left alone.

    - A character that is not text for a field is a key of the window: Space runs, letters choose tools.
    - Enter enters the value of a field and gives the keyboard back to the canvas; it presses a button.
    - Escape restores the value from before the first key, and gives the keyboard back.

    Tables keep Enter, which names a row. It watches only the widget that has the focus.
    """

    def __init__(self, window: QMainWindow, canvas: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self._canvas = canvas
        self._watched: QWidget | None = None
        self._before: Any = None
        """The value of the watched field before it was changed by keys; None before the first key."""
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._follow)

    def give_back(self) -> None:
        """Give the keyboard to the canvas."""
        self._canvas.window().activateWindow()
        self._canvas.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Decide on a key of the focused widget."""
        if not isinstance(event, QKeyEvent) or not isinstance(watched, QWidget):
            return False
        if event.type() == QEvent.Type.ShortcutOverride:
            return self._claim(watched, event)
        return event.type() == QEvent.Type.KeyPress and self._press(watched, event)

    def _follow(self, before: QWidget | None, now: QWidget | None) -> None:
        if now is None and before is not None and isinstance(dialog := before.window(), QDialog):
            QTimer.singleShot(0, self, lambda: self.take_back(dialog))
        if self._watched is not None and shiboken6.isValid(self._watched):
            self._watched.removeEventFilter(self)
        self._watched, self._before = None, None
        if now is None or now is self._canvas or isinstance(now, QMenuBar | QMenu):
            return
        if now.window() is self._window:
            self._watched = now
            now.installEventFilter(self)

    def take_back(self, dialog: QDialog) -> None:
        """Take the keyboard from a dialog that has closed: without a window manager nobody else gives it."""
        closed = not shiboken6.isValid(dialog) or not dialog.isVisible()
        if closed and QGuiApplication.focusWindow() is None and self._window.isVisible():
            (QApplication.activeModalWidget() or self._window).activateWindow()

    def _claim(self, widget: QWidget, event: QKeyEvent) -> bool:
        """Say whether a key is a shortcut of the window or belongs to the widget."""
        if event.key() == Qt.Key.Key_Escape and not event.modifiers():
            event.accept()
            return True
        if leaves(widget, event):
            event.ignore()
            return True
        return False

    def _press(self, widget: QWidget, event: QKeyEvent) -> bool:
        own = has_own_escape(widget) or in_view(widget)
        if event.key() == Qt.Key.Key_Escape:
            if own:
                return False
            if self._before is not None:
                put_back(widget, self._before)
            self.give_back()
            return True
        if event.key() in ENTER and isinstance(widget, QAbstractButton):
            widget.click()
            return True
        if own or isinstance(widget, QAbstractItemView):
            return False
        if event.key() in ENTER:
            widget.removeEventFilter(self)
            QCoreApplication.sendEvent(widget, event)
            if event.isAccepted() or isinstance(widget, _FIELDS):
                self.give_back()
            else:  # a view takes no value: Enter means what it means on the canvas
                self._canvas.setFocus()
                QCoreApplication.sendEvent(self._canvas, event)
            event.accept()
            return True
        if leaves(widget, event):
            event.ignore()  # its action cannot be done now; the field must not take it instead
            return True
        if self._before is None:
            self._before = value_of(widget)
        return False


def sliders_of(panel: QWidget) -> list[QSlider]:
    """The sliders of a panel that can be moved, from top to bottom."""
    found = [slider for slider in panel.findChildren(QSlider) if slider.isVisibleTo(panel) and slider.isEnabled()]
    places = {slider: slider.mapTo(panel, slider.rect().topLeft()) for slider in found}
    return sorted(found, key=lambda slider: (places[slider].y(), places[slider].x()))


def in_panel(panel: QWidget) -> QWidget:
    """What takes the keyboard in a panel: what it says itself, or the slider that had it last, or the first one."""
    proxy, last, sliders = panel.focusProxy(), panel.focusWidget(), sliders_of(panel)
    if proxy is not None:
        return proxy
    if isinstance(last, QSlider) and last in sliders:
        return last
    return sliders[0] if sliders else panel


def take_keyboard(widget: QWidget) -> None:
    """Give the keyboard to a widget, and scroll it into view."""
    widget.setFocus(Qt.FocusReason.TabFocusReason)
    around = widget.parentWidget()
    while around is not None:
        if isinstance(around, QScrollArea):
            around.ensureWidgetVisible(widget)
        around = around.parentWidget()


class Keys(QObject):
    """Gives the keys of a widget to `take` first, which returns whether it has used a key."""

    def __init__(self, widget: QWidget, take: Callable[[QKeyEvent], bool]) -> None:
        super().__init__(widget)
        self._take = take
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Pass the keys on."""
        return event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent) and self._take(event)
