"""The layer of the potential."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor

from app.model.text.language import tr
from app.session.exchange.messages import Overlays
from app.session.session import Session
from app.views.canvas.coordinates import image_rectangle, to_xy
from app.views.canvas.items.pens import cached, line_pen
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.options import Choice, Switch
from app.views.theme import colour_maps

_MAPS = ("cividis", "viridis", "magma", "plasma", colour_maps.GREY)
_VEIL = 0.75
"""Opacity over the image below, where the layer itself is fully opaque."""

_LINE = "#d8ffffff"


class PotentialLayer(Layer):
    """The potential in colours, with lines along which it is constant: particles slide across them, downwards."""

    name = "potential"
    title = tr("Potential")
    tip = tr("Potential of the edges and of placed charges: particles slide down, from bright to dark.")
    shortcut = "Ctrl+6"
    initially = False
    colours = ("#7c7b78",)
    options = (
        Choice(
            "map",
            tr("Colours"),
            {name: colour_maps.MAPS[name] for name in _MAPS},
            "cividis",
            tr("Colours from low to high potential."),
        ),
        Switch("lines", tr("Lines of equal potential"), True, tr("Lines that the force stands upright on.")),
    )

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._item = pg.ImageItem()
        self._item.setZValue(0.9)
        pen = line_pen("#ffffff", 1.0)
        pen.setColor(QColor(_LINE))
        self._lines = pg.PlotCurveItem(pen=pen, antialias=True, connect="finite")
        self._lines.setZValue(1.9)
        for item in (self._item, self._lines):
            item.setVisible(False)
            cached(item)
        self.add(self._item, self._lines)
        self.fade()
        self.follow_choice("map")
        session.overlays_changed.connect(self._show)
        session.image_changed.connect(lambda *_: self._hide())

    def show_or_hide(self) -> None:
        """Ask for what is seen only."""
        self.session.want_overlay("potential", self.shown)
        self.session.want_overlay("iso_lines", self.shown and bool(self.chosen["lines"]))
        if not self.shown:
            self._hide()

    def follow_choice(self, name: str) -> None:
        """Change the colours, or ask for the lines."""
        if name == "map":
            self._item.setLookupTable(colour_maps.table(self.word("map")))
        else:
            self.show_or_hide()

    def fade(self) -> None:
        """The colours always let something of the image through."""
        self._item.setOpacity(_VEIL * self.opacity)
        self._lines.setOpacity(self.opacity)

    def _hide(self) -> None:
        self._item.setVisible(False)
        self._lines.setVisible(False)

    def _show(self, overlays: Overlays) -> None:
        shades, lines = overlays.arrays.get("potential"), overlays.arrays.get("iso_lines")
        self._item.setVisible(self.shown and shades is not None)
        self._lines.setVisible(self.shown and lines is not None)
        if self.shown and shades is not None:
            self._item.setImage(shades, levels=(0, 255), rect=image_rectangle(shades.shape))
        if self.shown and lines is not None:
            self._lines.setData(*to_xy(np.asarray(lines, dtype=float)))
