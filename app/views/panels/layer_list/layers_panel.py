"""The panel of the layers, which is their legend as well."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QCheckBox, QFrame, QHBoxLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from app.model.text.language import tr
from app.views.canvas.layers import Layers
from app.views.panels.layer_list.layer_row import LayerRow
from app.views.theme import theme


class LayersPanel(QWidget):
    """A row a layer.

    Parameters
    ----------
    layers : Layers
        What it switches.
    """

    def __init__(self, layers: Layers) -> None:
        super().__init__()
        self.rows = {layer.name: LayerRow(layer) for layer in layers}
        self.boxes: dict[str, QCheckBox] = {name: row.box for name, row in self.rows.items()}
        scrolled = QWidget()
        scrolled.setObjectName("scrolled")
        column = QVBoxLayout(scrolled)
        column.setContentsMargins(0, 0, 8, 0)
        column.setSpacing(3)
        for row in self.rows.values():
            column.addWidget(row)
            row.unfolded.connect(self._bring_into_view)
        column.addLayout(_legend())
        column.addStretch(1)
        self._area = area = QScrollArea()
        area.setWidget(scrolled)
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(6, 8, 4, 4)
        outer.addWidget(area)

    def _bring_into_view(self) -> None:
        row = self.sender()
        if isinstance(row, LayerRow):
            # only after the layout has made room for the settings is it known where they lie
            QTimer.singleShot(0, row, lambda: self._area.ensureWidgetVisible(row, 0, 4))


def _legend() -> QHBoxLayout:
    """What is seen of the contours besides their own colors."""
    row = QHBoxLayout()
    row.setContentsMargins(20, 4, 0, 0)
    row.setSpacing(16)
    junction = QLabel(tr("◆ Junctions"))
    junction.setStyleSheet(f"color: {theme.JUNCTION}")
    junction.setToolTip(tr("Where contours meet."))
    # Its color is that of the text: on the canvas it is told by its dashes.
    bridge = QLabel(tr("╍╍ Bridged gaps"))
    bridge.setToolTip(tr("Where a contour was led over a gap in its edge."))
    row.addWidget(junction)
    row.addWidget(bridge)
    row.addStretch(1)
    return row
