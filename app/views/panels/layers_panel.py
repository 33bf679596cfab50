"""The panel that switches layers on and off, and is their legend."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QWidget

from app.model.language import tr
from app.views import theme
from app.views.icons import swatch
from app.views.layers import Layers
from app.views.layers.layer import Layer


class LayersPanel(QWidget):
    """A check box a layer.

    Parameters
    ----------
    layers : Layers
        What it switches.
    """

    def __init__(self, layers: Layers) -> None:
        super().__init__()
        grid = QGridLayout(self)
        grid.setContentsMargins(12, 8, 12, 8)
        grid.setVerticalSpacing(4)
        self.boxes: dict[str, QCheckBox] = {}
        for index, layer in enumerate(layers):
            self.boxes[layer.name] = box = self._make_box(layer)
            grid.addWidget(box, index // 2, index % 2)
        below = grid.rowCount()
        junction = QLabel(tr("◆ Junctions"))
        junction.setStyleSheet(f"color: {theme.JUNCTION}")
        junction.setToolTip(tr("Where contours meet."))
        grid.addWidget(junction, below, 0)
        # Its colour is that of the text: on the canvas it is told by its dashes.
        bridge = QLabel(tr("╍╍ Bridged gaps"))
        bridge.setToolTip(tr("Where a contour was led over a gap in its edge."))
        grid.addWidget(bridge, below, 1)
        grid.setRowStretch(below + 1, 1)

    @staticmethod
    def _make_box(layer: Layer) -> QCheckBox:
        box = QCheckBox(layer.title)
        if layer.colours:
            box.setIcon(swatch(*layer.colours))
            box.setIconSize(QSize(16 * len(layer.colours), 14))
        box.setChecked(layer.shown)
        box.setToolTip(f"{layer.tip} ({layer.shortcut})" if layer.shortcut else layer.tip)
        box.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        box.toggled.connect(layer.set_shown)
        layer.changed.connect(lambda: box.setChecked(layer.shown))
        return box
