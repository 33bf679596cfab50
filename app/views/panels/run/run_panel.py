"""The panel that tells how the run stands, in words, figures and curves."""

from __future__ import annotations

from PySide6.QtWidgets import QVBoxLayout, QWidget

from app.views.panels.run.plot import PlotPanel
from app.views.panels.run.status import StatusPanel


class RunPanel(QWidget):
    """Status above, plot below."""

    def __init__(self) -> None:
        super().__init__()
        self.status = StatusPanel()
        self.plot = PlotPanel()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(12, 8, 12, 8)
        layout.setSpacing(8)
        layout.addWidget(self.status)
        layout.addWidget(self.plot, 1)
