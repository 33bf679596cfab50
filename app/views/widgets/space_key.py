"""Space presses a focused button and does not run or pause the particles."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractButton


class _SpaceKey(QObject):
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Accept the key before it becomes a shortcut of the window."""
        if event.type() != QEvent.Type.ShortcutOverride or not isinstance(event, QKeyEvent):
            return False
        if event.key() == Qt.Key.Key_Space and event.modifiers() == Qt.KeyboardModifier.NoModifier:
            event.accept()
            return True
        return False


def own_space(*buttons: QAbstractButton) -> None:
    """Let Space press these buttons while they have the focus."""
    for button in buttons:
        button.installEventFilter(_SpaceKey(button))
