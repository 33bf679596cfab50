"""The panel that switches layers on and off, and is their legend."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QWidget

from app.views import theme
from app.views.icons import swatch


@dataclass(frozen=True, slots=True)
class LayerEntry:
    """A layer as it stands in panel and menu."""

    name: str
    title: str
    shortcut: str
    shown: bool
    colours: tuple[str, ...]
    tip: str


LAYERS = (
    LayerEntry("particles", "Particles", "Ctrl+1", True, (theme.MOVING, theme.RESTING), "Moving, and nearly at rest."),
    LayerEntry("contours", "Contours", "Ctrl+2", True, (theme.CLOSED, theme.OPEN), "Closed, and open."),
    LayerEntry(
        "drawing",
        "Drawing",
        "Ctrl+3",
        True,
        (theme.DRAWING, theme.REGION, theme.BARRIER),
        "What a run starts from, regions of interest, and barriers.",
    ),
    LayerEntry(
        "edge_map", "Edge map", "Ctrl+4", False, ("#f98c0a",), "Strength of the edges that attract the particles."
    ),
    LayerEntry("field", "Field", "Ctrl+5", False, (theme.FIELD,), "Direction in which edges pull."),
)


class LayersPanel(QWidget):
    """A check box a layer."""

    toggled = Signal(str, bool)
    """Name of a layer and whether it is to be seen."""

    def __init__(self) -> None:
        super().__init__()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(4)
        self.boxes: dict[str, QCheckBox] = {}
        for index, entry in enumerate(LAYERS):
            box = QCheckBox(entry.title)
            box.setIcon(swatch(*entry.colours))
            box.setIconSize(QSize(16 * len(entry.colours), 14))
            box.setChecked(entry.shown)
            box.setToolTip(f"{entry.tip} ({entry.shortcut})")
            box.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            box.toggled.connect(lambda shown, name=entry.name: self.toggled.emit(name, shown))
            self.boxes[entry.name] = box
            grid.addWidget(box, index // 2, index % 2)
        junction = QLabel("◆ Junctions")
        junction.setStyleSheet(f"color: {theme.JUNCTION}")
        junction.setToolTip("Where contours meet.")
        grid.addWidget(junction, len(LAYERS) // 2, 1)
        # Its colour is that of the text: on the canvas it is told by its dashes.
        bridge = QLabel("╍╍ Bridged gaps")
        bridge.setToolTip("Where a contour was led over a gap in its edge.")
        grid.addWidget(bridge, len(LAYERS) // 2 + 1, 1)
