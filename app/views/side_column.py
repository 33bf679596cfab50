"""The column beside the canvas: status, plot, parameters and layers."""

from __future__ import annotations

from PySide6.QtWidgets import QFrame, QVBoxLayout, QWidget

from app.session.session import Session
from app.views.panels.layers_panel import LayersPanel
from app.views.panels.parameters import ParametersPanel
from app.views.panels.plot import PlotPanel
from app.views.panels.status import StatusPanel
from app.views.theme import Theme

WIDTH = 348


class SideColumn(QWidget):
    """The panels one below the other; the parameters scroll, so nothing is ever cut off."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.setObjectName("side")
        self.setFixedWidth(WIDTH)
        self.status = StatusPanel()
        self.plot = PlotPanel()
        self.parameters = ParametersPanel(session)
        self.layers = LayersPanel()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 10, 10, 10)
        layout.setSpacing(8)
        layout.addWidget(self.status)
        layout.addWidget(self.plot, 2)
        layout.addWidget(_line())
        layout.addWidget(self.parameters, 5)
        layout.addWidget(_line())
        layout.addWidget(self.layers)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self.parameters.use_theme(theme)


def _line() -> QFrame:
    line = QFrame()
    line.setFrameShape(QFrame.Shape.HLine)
    line.setFrameShadow(QFrame.Shadow.Plain)
    line.setStyleSheet("color: palette(mid)")
    return line
