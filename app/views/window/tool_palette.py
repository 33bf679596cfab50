"""The palette of tools beside the canvas."""

from __future__ import annotations

from itertools import groupby

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QMenu,
    QSizePolicy,
    QToolBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.model.text.language import tr
from app.views.canvas.tools import OBJECT, START, TOOLS
from app.views.theme.icons import icon
from app.views.theme.theme import Theme
from app.views.widgets.actions import Actions
from app.views.widgets.scrolled import Scrolled
from cpm_core.shapes import KINDS

_WIDEST = 16_777_215
_COLUMNS, _BUTTON = 2, 34
"""Buttons in a row, and side of a button [px], such that all tools fit in a window 720 px high."""


class ToolPalette(QToolBar):
    """One button for each tool, in groups, and one for the starts that need no drawing."""

    def __init__(self, actions: Actions) -> None:
        super().__init__(tr("Tools"))
        self.setObjectName("palette")
        self.setMovable(False)
        self.toggleViewAction().setEnabled(False)
        self.setIconSize(QSize(22, 22))
        self.buttons: dict[str, QToolButton] = {}
        self.starts = self._make_starts([actions[f"start_{kind}"] for kind in KINDS])
        case = QWidget()
        column = QVBoxLayout(case)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        for number, (group, tools) in enumerate(groupby(TOOLS, lambda tool: tool.group)):
            buttons = [self._make(actions[tool.name], tool.name) for tool in tools]
            if group == OBJECT:
                column.addWidget(self._widened(buttons[0], group))
                continue
            heading = QLabel(group)
            heading.setObjectName("heading")
            heading.setAlignment(Qt.AlignmentFlag.AlignHCenter)
            heading.setContentsMargins(0, 6 if number else 0, 0, 0)
            column.addWidget(heading)
            grid = QGridLayout()
            grid.setSpacing(2)
            for index, button in enumerate(buttons):
                grid.addWidget(button, index // _COLUMNS, index % _COLUMNS)
            if group == START:
                grid.addWidget(self.starts, grid.rowCount(), 0, 1, _COLUMNS)
            column.addLayout(grid)
        column.addStretch(1)
        scrolled = Scrolled(case, 3 * _BUTTON)
        scrolled.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Expanding)
        self.addWidget(scrolled)

    def use_theme(self, theme: Theme) -> None:
        """Tint the button without an action."""
        self.starts.setIcon(icon("everywhere", theme.text, faded=theme.line))

    def _make(self, action: QAction, name: str) -> QToolButton:
        button = QToolButton()
        button.setDefaultAction(action)
        button.setFixedSize(_BUTTON, _BUTTON)
        button.setAccessibleName(action.text().replace("&", ""))
        self._set_style(button, name)
        self.buttons[name] = button
        return button

    def _widened(self, button: QToolButton, text: str) -> QToolButton:
        """A button as wide as the palette, with a short text beside its icon."""
        button.defaultAction().setIconText(text)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setMaximumWidth(_WIDEST)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        return button

    def _make_starts(self, actions: list[QAction]) -> QToolButton:
        button = QToolButton()
        menu = QMenu(button)
        menu.setToolTipsVisible(True)
        menu.addActions(actions)
        button.setMenu(menu)
        button.setText(tr("Auto"))
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        button.setToolTip(tr("Starts that need no drawing: everywhere, on strong edges, at centers."))
        button.setAccessibleName(tr("Starts that need no drawing"))
        self._set_style(button, "starts")
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        return button

    def _set_style(self, button: QToolButton, name: str) -> None:
        button.setObjectName(name)
        button.setIconSize(self.iconSize())
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
