"""The layer of the edge map."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg

from app.model.text.language import tr
from app.session.exchange.messages import Overlays
from app.session.session import Session
from app.views.canvas.coordinates import image_rectangle
from app.views.canvas.items.pens import cached
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.options import Choice
from app.views.theme import colour_maps

_MAPS = ("inferno", "magma", "plasma", "viridis", "cividis", colour_maps.GREY)
_MOST = 235
"""Opacity of the strongest edges, of 255."""


class EdgeMapLayer(Layer):
    """The edge map, half transparent and fully so where there is no edge."""

    name = "edge_map"
    title = tr("Edge map")
    tip = tr("Strength of the edges that attract the particles.")
    shortcut = "Ctrl+4"
    initially = False
    colours = ("#f98c0a",)
    options = (
        Choice(
            "map",
            tr("Colours"),
            {name: colour_maps.MAPS[name] for name in _MAPS},
            "inferno",
            tr("Colours from weak to strong edges."),
        ),
    )

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._item = pg.ImageItem()
        self._item.setZValue(1)
        self._item.setVisible(False)
        cached(self._item)
        self.add(self._item)
        self.follow_choice("map")
        session.overlays_changed.connect(self._show)
        session.image_changed.connect(lambda *_: self._item.setVisible(False))

    def show_or_hide(self) -> None:
        """Ask for the edge map only while it is seen."""
        self.session.want_overlay("edge_map", self.shown)
        if not self.shown:
            # hidden, not cleared: what is cached of an item would stay on screen when its extent vanishes
            self._item.setVisible(False)

    def follow_choice(self, name: str) -> None:
        """Change the colours."""
        opaque = np.linspace(0, _MOST, 256).astype(np.uint8)
        self._item.setLookupTable(np.column_stack([colour_maps.table(self.word("map")), opaque]))

    def _show(self, overlays: Overlays) -> None:
        shades = overlays.arrays.get("edge_map")
        self._item.setVisible(self.shown and shades is not None)
        if self.shown and shades is not None:
            self._item.setImage(shades, levels=(0, 255), rect=image_rectangle(shades.shape))
