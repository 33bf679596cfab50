"""The headings of panels."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QBoxLayout, QDockWidget, QLabel, QToolButton, QWidget

from app.model.text.language import tr
from app.views.theme.icons import icon
from app.views.theme.theme import Theme


class PanelTitle(QWidget):
    """Replaces the title bar of a dock: its name, and buttons to detach and to close it.

    An `upright` one stands at the left of its panel and takes no height; it has the buttons only.
    """

    def __init__(self, dock: QDockWidget, upright: bool = False) -> None:
        super().__init__(dock)
        self.setObjectName("upright" if upright else "title")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        name = QLabel(dock.windowTitle())
        name.setObjectName("heading")
        self._detach = self._button(tr("Detach the panel {title}, or put it back.").format(title=dock.windowTitle()))
        self._close = self._button(
            tr("Close the panel {title}; the menu View opens it again.").format(title=dock.windowTitle())
        )
        self._detach.clicked.connect(lambda: dock.setFloating(not dock.isFloating()))
        self._close.clicked.connect(dock.close)
        direction = QBoxLayout.Direction
        line = QBoxLayout(direction.TopToBottom if upright else direction.LeftToRight, self)
        line.setSpacing(0)
        if upright:
            name.hide()
            self.setToolTip(dock.windowTitle())
            line.setContentsMargins(3, 4, 3, 4)
            line.addWidget(self._close)
            line.addWidget(self._detach)
            line.addStretch(1)
        else:
            line.setContentsMargins(12, 3, 4, 3)
            line.addWidget(name)
            line.addStretch(1)
            line.addWidget(self._detach)
            line.addWidget(self._close)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self._detach.setIcon(icon("loosen", theme.dim))
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
