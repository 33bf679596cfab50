"""The palette of tools beside the canvas."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QSizePolicy, QToolBar, QToolButton

from app.views.actions import Actions
from app.views.icons import icon
from app.views.theme import Theme
from app.views.tools import TOOLS, ToolEntry
from cpm_core.shapes import KINDS


class ToolPalette(QToolBar):
    """One button a tool, and one for the starts that need no drawing.

    Parameters
    ----------
    actions : Actions
        The actions that the buttons stand for.
    """

    def __init__(self, actions: Actions) -> None:
        super().__init__("Tools")
        self.setObjectName("palette")
        self.setMovable(False)
        self.toggleViewAction().setEnabled(False)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        self.setIconSize(QSize(24, 24))
        for tool in TOOLS:
            if tool.gap:
                self.addSeparator()
            self._add(actions[tool.name], tool)
        self.addSeparator()
        self.starts = self._make_starts([actions[f"start_{kind}"] for kind in KINDS])
        self.addWidget(self.starts)

    def use_theme(self, theme: Theme) -> None:
        """Tint the button that is no action."""
        self.starts.setIcon(icon("everywhere", theme.text, faded=theme.line))

    def _add(self, action: QAction, tool: ToolEntry) -> None:
        action.setIconText(tool.short)
        self.addAction(action)
        button = self.widgetForAction(action)
        if isinstance(button, QToolButton):
            self._dress(button, tool.name)

    def _make_starts(self, actions: list[QAction]) -> QToolButton:
        button = QToolButton()
        menu = QMenu(button)
        menu.setToolTipsVisible(True)
        menu.addActions(actions)
        button.setMenu(menu)
        button.setText("Auto start")
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        button.setToolTip("Starts that need no drawing: everywhere, on strong edges, at centres.")
        button.setAccessibleName("Starts that need no drawing")
        self._dress(button, "starts")
        return button

    @staticmethod
    def _dress(button: QToolButton, name: str) -> None:
        button.setObjectName(name)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        # All as wide as the widest, so that icons and texts stand below each other.
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
