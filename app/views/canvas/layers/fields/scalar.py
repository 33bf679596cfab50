"""The layers of the edge map and of the potential: values at all pixels, shown by colors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor

from app.model.display.display_image import DisplayImage, Shades
from app.model.text.language import tr
from app.session.scene import Scene
from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.item import cached, line_pen
from app.views.canvas.items.tiled_image import TiledImage
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.options import Choice, Switch
from app.views.theme import color_maps

_STRONGEST = 235
"""Opacity of the strongest edges, out of 255."""

_VEIL = 0.75
"""Opacity of the potential over the image where the layer itself is fully opaque."""

_LINE = "#d8ffffff"


def _maps(names: Sequence[str], tip: str) -> Choice:
    return Choice("map", tr("Colors"), {name: color_maps.MAPS[name] for name in names}, names[0], tip)


class ScalarOverlay(Layer):
    """An overlay of the worker, shape (H, W), in the colors of a map; it is requested only while shown."""

    initially = False
    in_slices = True
    z: ClassVar[float]
    """Place in the stack of layers."""

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self._item = TiledImage(self.z)
        self._item.setVisible(False)
        cached(self._item)
        self.add(self._item)
        self.follow_choice("map")

    @property
    def shades(self) -> Shades | None:
        """Shades shown, before the color map is applied; None while nothing is shown."""
        return self._item.display.shades if self._item.display is not None and self._item.isVisible() else None

    def show_or_hide(self) -> None:
        """Request the overlay only while it is shown."""
        self.requests.want_overlay(self.name, self.shown)
        self._show()

    def follow(self, before: Scene) -> None:
        """Show newer values, or none."""
        if self.scene.overlays.get(self.name) is not before.overlays.get(self.name):
            self._show()

    def _show(self) -> None:
        shades = self.scene.overlays.get(self.name) if self.shown else None
        # hidden, not cleared: the cached image of an item would stay on screen when its extent vanishes
        self._item.setVisible(isinstance(shades, DisplayImage))
        if isinstance(shades, DisplayImage):
            self._item.show_image(shades)

    def follow_choice(self, name: str) -> None:
        """Change the colors."""
        self._item.use_table(self.table())

    def table(self) -> np.ndarray:
        """Colors of the 256 shades."""
        return color_maps.table(self.word("map"))


class EdgeMapLayer(ScalarOverlay):
    """The edge map, half transparent, and fully transparent where there is no edge."""

    name = "edge_map"
    title = tr("Edge map")
    tip = tr("Strength of the edges that attract the particles.")
    shortcut = "Alt+7"
    colors = ("#f98c0a",)
    options = (
        _maps(
            ("inferno", "magma", "plasma", "viridis", "cividis", color_maps.GRAY),
            tr("Colors from weak to strong edges."),
        ),
    )
    z = 1.0

    def table(self) -> np.ndarray:
        """Colors whose opacity grows with the strength of the edge."""
        return np.column_stack([super().table(), np.linspace(0, _STRONGEST, 256).astype(np.uint8)])


class PotentialLayer(ScalarOverlay):
    """The potential in colors, with lines of equal potential."""

    name = "potential"
    title = tr("Potential")
    tip = tr("Potential of the edges and of placed charges: particles slide down, from bright to dark.")
    shortcut = "Alt+8"
    colors = ("#7c7b78",)
    options = (
        _maps(
            ("cividis", "viridis", "magma", "plasma", color_maps.GRAY),
            tr("Colors from low to high potential."),
        ),
        Switch("lines", tr("Lines of equal potential"), True, tr("Lines that are perpendicular to the force.")),
    )
    z = 0.9

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        pen = line_pen("#ffffff", 1.0)
        pen.setColor(QColor(_LINE))
        self._lines = pg.PlotCurveItem(pen=pen, antialias=True, connect="finite")
        self._lines.setZValue(1.9)
        self._lines.setVisible(False)
        cached(self._lines)
        self.add(self._lines)
        self.fade()

    @property
    def lined(self) -> bool:
        """Whether lines of equal potential are shown."""
        return bool(self._lines.isVisible())

    def show_or_hide(self) -> None:
        """Request the lines as well, where they are shown."""
        super().show_or_hide()
        self.requests.want_overlay("iso_lines", self.shown and bool(self.chosen["lines"]))
        self._show_lines()

    def follow(self, before: Scene) -> None:
        """Show newer lines as well, or none."""
        super().follow(before)
        if self.scene.overlays.get("iso_lines") is not before.overlays.get("iso_lines"):
            self._show_lines()

    def _show_lines(self) -> None:
        lines = self.scene.overlays.get("iso_lines") if self.shown else None
        self._lines.setVisible(lines is not None)
        if lines is not None:
            self._lines.setData(*to_xy(np.asarray(lines, dtype=float)))

    def follow_choice(self, name: str) -> None:
        """Change the colors, or request the lines."""
        if name == "map":
            super().follow_choice(name)
        else:
            self.show_or_hide()

    def fade(self) -> None:
        """Set the opacity; the image always remains visible below the colors."""
        self._item.setOpacity(_VEIL * self.opacity)
        self._lines.setOpacity(self.opacity)
