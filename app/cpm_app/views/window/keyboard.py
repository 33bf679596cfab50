"""Keyboard: which widget gets a key, and which one gets the focus next."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import shiboken6
from PySide6.QtCore import QCoreApplication, QEvent, QLocale, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QGuiApplication, QKeyEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QCheckBox,
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

from cpm_app.views.widgets.containers import ENTER_KEYS, has_own_escape
from cpm_app.views.widgets.fields import DecimalField, MarkedSlider

_FIELD_CLASSES = (QAbstractSpinBox, QLineEdit, QTextEdit, QPlainTextEdit, QAbstractButton, QComboBox, QSlider)
"""Classes of the widgets that hold a value, and of buttons."""

_TEXT_MODIFIERS = (
    Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.KeypadModifier | Qt.KeyboardModifier.GroupSwitchModifier
)
"""Modifiers with which a key still types a character."""


def is_cell_editor(widget: QWidget) -> bool:
    """Return whether a widget is the editor of a table or a list."""
    viewport = widget.parentWidget()
    return viewport is not None and isinstance(viewport.parentWidget(), QAbstractItemView)


def is_window_key(widget: QWidget, event: QKeyEvent) -> bool:
    """Return whether a key types a character that a field cannot use, so that it acts on the window."""
    text = event.text()
    if not text or not text.isprintable() or event.modifiers() & ~_TEXT_MODIFIERS:
        return False
    if not isinstance(widget, _FIELD_CLASSES) or is_cell_editor(widget):
        return False
    match widget:
        case QAbstractSpinBox():  # letters act on the window, so a number has no exponent
            locale = QLocale()
            signs = f"+-.,{locale.decimalPoint()}{locale.groupSeparator()}"
            return not all(character.isdigit() or character in signs for character in text)
        case QComboBox():
            return not widget.isEditable()
    return isinstance(widget, QAbstractButton | QSlider)


def is_typed_in(widget: QWidget | None) -> bool:
    """Return whether a widget is a field in which text is typed."""
    if isinstance(widget, QComboBox):
        return widget.isEditable()
    return isinstance(widget, QAbstractSpinBox | QLineEdit | QTextEdit | QPlainTextEdit)


def read_field_value(widget: QWidget) -> Any:
    """Read the value of a field, which is the user property of its Qt class; None if it has none."""
    return (
        widget.exact
        if isinstance(widget, DecimalField | MarkedSlider)
        else widget.metaObject().userProperty().read(widget)
    )


def restore_field_value(widget: QWidget, value: Any) -> None:
    """Restore the value of a field as if the user had set it, and drop typed text."""
    if isinstance(widget, DecimalField | MarkedSlider):
        widget.move_to(value)
        return
    changed = value != read_field_value(widget)
    widget.metaObject().userProperty().write(widget, value)
    if changed and isinstance(widget, QComboBox):
        widget.activated.emit(widget.currentIndex())


class Keyboard(QObject):
    """Filter of the keys of the focused widget of the window; dialogs are left alone.

    - A character that a field cannot use acts on the window: Space runs, letters select tools.
    - Enter keeps what is typed in a field, presses a button, and does what a table does with it. Elsewhere it is that
      of the canvas, `press_enter`, which is told whether to wait for what is being found, and returns whether there was
      anything to do; if not, it ticks a check box. The focus returns to the canvas.
    - Escape restores the value from before the first key, and returns the focus to the canvas.

    Only the widget with the focus is watched; when it is hidden or disabled, the canvas gets the focus.
    """

    typing_changed = Signal(bool)
    """Whether a field in which text is typed has the focus."""

    def __init__(self, window: QMainWindow, canvas: QWidget, press_enter: Callable[[bool], bool]) -> None:
        super().__init__(window)
        self._window = window
        self._canvas = canvas
        self._press_enter = press_enter
        self._watched: QWidget | None = None
        self._value_before: Any = None
        """Value of the watched field before the first key; None until then."""
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._on_focus_changed)

    def focus_canvas(self) -> None:
        """Move the keyboard focus to the canvas."""
        self._canvas.window().activateWindow()
        self._canvas.setFocus()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle or pass on a key of the focused widget."""
        if not isinstance(event, QKeyEvent) or not isinstance(watched, QWidget):
            return False
        if event.type() == QEvent.Type.ShortcutOverride:
            return self._claim_shortcut(watched, event)
        return event.type() == QEvent.Type.KeyPress and self._on_key_pressed(watched, event)

    def _on_focus_changed(self, before: QWidget | None, now: QWidget | None) -> None:
        if now is None and before is not None and isinstance(dialog := before.window(), QDialog):
            QTimer.singleShot(0, self, lambda: self.reactivate_window(dialog))
        left, here = self._watched, now is not None and now.window() is self._window
        is_deleted = left is not None and not shiboken6.isValid(left)
        if left is not None and not is_deleted:
            left.removeEventFilter(self)
        self._watched, self._value_before = None, None
        is_gone = left is not None and (is_deleted or not (left.isVisible() and left.isEnabled()))
        if is_gone and (here or now is None) and shiboken6.isValid(self._canvas):
            self._canvas.setFocus()  # Qt would give it to whatever is next, or to nothing
        elif now is not None and here and now is not self._canvas and not isinstance(now, QMenuBar | QMenu):
            self._watched = now
            now.installEventFilter(self)
        self.typing_changed.emit(is_typed_in(self._watched))

    def reactivate_window(self, dialog: QDialog) -> None:
        """Activate the window when a dialog has closed, which nothing else does without a window manager."""
        closed = not shiboken6.isValid(dialog) or not dialog.isVisible()
        if closed and QGuiApplication.focusWindow() is None and self._window.isVisible():
            (QApplication.activeModalWidget() or self._window).activateWindow()

    def _claim_shortcut(self, widget: QWidget, event: QKeyEvent) -> bool:
        """Decide whether a key is a shortcut of the window; return whether the decision was made here."""
        if event.key() == Qt.Key.Key_Escape and not event.modifiers():
            event.accept()
            return True
        if is_window_key(widget, event):
            event.ignore()
            return True
        return False

    def _on_key_pressed(self, widget: QWidget, event: QKeyEvent) -> bool:
        own = has_own_escape(widget) or is_cell_editor(widget)
        if event.key() == Qt.Key.Key_Escape:
            if own:
                return False
            if self._value_before is not None:
                restore_field_value(widget, self._value_before)
            self.focus_canvas()
            return True
        if event.key() in ENTER_KEYS and (not own or isinstance(widget, QAbstractButton)):
            self._on_enter(widget, event)
            return True
        if own or isinstance(widget, QAbstractItemView):
            return False
        if is_window_key(widget, event):
            event.ignore()  # its action is disabled now; the field must not get the key instead
            return True
        if self._value_before is None:
            self._value_before = read_field_value(widget)
        return False

    def _on_enter(self, widget: QWidget, event: QKeyEvent) -> None:
        if isinstance(widget, QAbstractButton) and not isinstance(widget, QCheckBox):
            widget.click()
            return
        widget.removeEventFilter(self)
        QCoreApplication.sendEvent(widget, event)
        if widget is self._watched:
            widget.installEventFilter(self)
        used = event.isAccepted()
        event.accept()
        if used and isinstance(widget, QAbstractItemView):
            return
        in_table = isinstance(
            widget, QAbstractItemView
        )  # elsewhere Enter leads back, and is not for what will be found
        if used or is_typed_in(widget) or self._press_enter(in_table) or not isinstance(widget, QCheckBox):
            self.focus_canvas()
        else:
            widget.click()


def find_sliders(panel: QWidget) -> list[QSlider]:
    """Find the sliders of a panel that can be moved, from top to bottom."""
    found = [slider for slider in panel.findChildren(QSlider) if slider.isVisibleTo(panel) and slider.isEnabled()]
    places = {slider: slider.mapTo(panel, slider.rect().topLeft()) for slider in found}
    return sorted(found, key=lambda slider: (places[slider].y(), places[slider].x()))


def find_focus_target(panel: QWidget) -> QWidget:
    """Find the widget of a panel that gets the focus: its focus proxy, the slider used last, or the first one."""
    proxy, last, sliders = panel.focusProxy(), panel.focusWidget(), find_sliders(panel)
    if proxy is not None:
        return proxy
    if isinstance(last, QSlider) and last in sliders:
        return last
    return sliders[0] if sliders else panel


def focus_and_reveal(widget: QWidget) -> None:
    """Move the keyboard focus to a widget and scroll it into view."""
    widget.setFocus(Qt.FocusReason.TabFocusReason)
    ancestor = widget.parentWidget()
    while ancestor is not None:
        if isinstance(ancestor, QScrollArea):
            ancestor.ensureWidgetVisible(widget)
        ancestor = ancestor.parentWidget()


class TypedAhead(QObject):
    """Filter that keeps what is typed in a widget, up to Enter or Escape, for a field that is about to open.

    Parameters
    ----------
    widget : QWidget
        It has the keyboard focus until the field opens.
    is_awaited : callable
        Returns whether the field is still going to open; once it is not, the filter ends.
    """

    def __init__(self, widget: QWidget, is_awaited: Callable[[], bool]) -> None:
        super().__init__(widget)
        self._is_awaited = is_awaited
        self._keys: list[QKeyEvent] = []
        widget.installEventFilter(self)

    def type_into(self, field: QWidget | None) -> None:
        """Type in the field what has been kept."""
        self.deleteLater()
        for key in self._keys:
            if field is not None and shiboken6.isValid(field):
                QCoreApplication.sendEvent(field, key)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep a key that types or edits text, and let it be no shortcut."""
        if not self._is_awaited():
            self.deleteLater()
            return False
        pressed = event.type() == QEvent.Type.KeyPress
        if not isinstance(event, QKeyEvent) or not (pressed or event.type() == QEvent.Type.ShortcutOverride):
            return False
        ended = bool(self._keys) and self._keys[-1].key() in (*ENTER_KEYS, Qt.Key.Key_Escape)
        if ended or not event.text() or event.modifiers() & ~_TEXT_MODIFIERS:
            return False
        if pressed:
            self._keys.append(event.clone())
        event.accept()
        return True


class KeyFilter(QObject):
    """Filter that passes the keys of a widget to `take` first, which returns whether it has handled a key."""

    def __init__(self, widget: QWidget, take: Callable[[QKeyEvent], bool]) -> None:
        super().__init__(widget)
        self._take = take
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Pass the keys to `take`."""
        return event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent) and self._take(event)
