"""The tool bar above the canvas."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QToolBar, QToolButton, QWidget

from app.model.language import tr
from app.views.actions import PRIMARY, Actions

_BEFORE = (("open", "save"), ("undo", "redo"), ("run", "step", "reset"))
_AFTER = ("fit", "export")


class ToolBar(QToolBar):
    """Buttons for what is done most; an action that no part brings is left out.

    Parameters
    ----------
    actions : Actions
        The actions that the buttons stand for.
    speed : QWidget
        The speed control.
    """

    def __init__(self, actions: Actions, speed: QWidget) -> None:
        super().__init__(tr("Run"))
        self.setObjectName("bar")
        self.setMovable(False)
        self.toggleViewAction().setEnabled(False)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        for names in _BEFORE:
            for name in names:
                self._add(actions, name)
            self.addSeparator()
        self.addWidget(speed)
        self.addSeparator()
        for name in _AFTER:
            self._add(actions, name)

    def _add(self, actions: Actions, name: str) -> None:
        if name not in actions:
            return
        action = actions[name]
        self.addAction(action)
        button = self.widgetForAction(action)
        if isinstance(button, QToolButton):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setObjectName("primary" if name == PRIMARY else name)
            if name == PRIMARY:
                bold = button.font()
                bold.setBold(True)
                button.setMinimumWidth(QFontMetrics(bold).horizontalAdvance(tr("Run anew")) + 60)
