"""The heading of a panel: its name, and quiet buttons to loosen and to close it."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QDockWidget, QHBoxLayout, QLabel, QToolButton, QWidget

from app.model.text.language import tr
from app.views.theme.icons import icon
from app.views.theme.theme import Theme


class PanelTitle(QWidget):
    """Takes the place of the heading that the style would draw; it is moved by it like that one.

    Parameters
    ----------
    dock : QDockWidget
        Panel that it is of.
    """

    def __init__(self, dock: QDockWidget) -> None:
        super().__init__(dock)
        self.setObjectName("title")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        name = QLabel(dock.windowTitle())
        name.setObjectName("heading")
        self._loosen = self._button(tr("Loosen the panel {title}, or put it back.").format(title=dock.windowTitle()))
        self._close = self._button(
            tr("Close the panel {title}; the menu View opens it again.").format(title=dock.windowTitle())
        )
        self._loosen.clicked.connect(lambda: dock.setFloating(not dock.isFloating()))
        self._close.clicked.connect(dock.close)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 3, 4, 3)
        row.setSpacing(0)
        row.addWidget(name)
        row.addStretch(1)
        row.addWidget(self._loosen)
        row.addWidget(self._close)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self._loosen.setIcon(icon("loosen", theme.dim))
        self._close.setIcon(icon("close", theme.dim))

    @staticmethod
    def _button(tip: str) -> QToolButton:
        button = QToolButton()
        button.setObjectName("quiet")
        button.setIconSize(QSize(14, 14))
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setToolTip(tip)
        button.setAccessibleName(tip)
        return button
