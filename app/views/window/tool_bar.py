"""The tool bar above the canvas."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QFontMetrics
from PySide6.QtWidgets import QHBoxLayout, QToolBar, QToolButton, QWidget

from app.model.document.modes import MODES
from app.model.text.language import tr
from app.views.widgets.actions import PRIMARY, Actions

_FILES, _EDITS, _RUN, _AFTER = ("open", "save"), ("undo", "redo"), ("run", "step", "reset"), ("fit", "export")
_ICON_ONLY = ("undo", "redo", "fit")
"""Buttons that need no text."""


class ToolBar(QToolBar):
    """Buttons for the most frequent actions that exist, and the speed control."""

    def __init__(self, actions: Actions, speed: QWidget) -> None:
        super().__init__(tr("Run"))
        self.setObjectName("bar")
        self.setMovable(False)
        self.toggleViewAction().setEnabled(False)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._add(actions, *_FILES)
        self.addSeparator()
        self._add(actions, *_EDITS)
        self.addSeparator()
        self.addWidget(_modes(actions))
        self.addSeparator()
        self._add(actions, *_RUN)
        self.addSeparator()
        self.addWidget(speed)
        self.addSeparator()
        self._add(actions, *_AFTER)

    def _add(self, actions: Actions, *names: str) -> None:
        for name in filter(actions.__contains__, names):
            self._add_one(actions[name], name)

    def _add_one(self, action: QAction, name: str) -> None:
        self.addAction(action)
        button = self.widgetForAction(action)
        if isinstance(button, QToolButton):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setObjectName("primary" if name == PRIMARY else name)
            if name in _ICON_ONLY:
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
                button.setAccessibleName(action.iconText())
            if name == PRIMARY:
                bold = button.font()
                bold.setBold(True)
                metrics = QFontMetrics(bold)
                button.setMinimumWidth(metrics.horizontalAdvance(tr("Run again")) + 52)


def _modes(actions: Actions) -> QWidget:
    """The modes side by side, as one segmented control."""
    segments = QWidget()
    segments.setObjectName("segments")
    row = QHBoxLayout(segments)
    row.setContentsMargins(6, 0, 6, 0)
    row.setSpacing(0)
    names = [f"mode_{mode}" for mode in MODES]
    for index, name in enumerate(names):
        button = QToolButton()
        button.setDefaultAction(actions[name])
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        place = "first" if index == 0 else "last" if index == len(names) - 1 else "middle"
        button.setProperty("segment", place)
        button.setObjectName(name)
        row.addWidget(button)
    return segments
