"""The layers of the area of a start, of edge map, potential and electric field."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor

from cpm_app.model.display.display_image import INSIDE_SHADE, DisplayImage
from cpm_app.model.text.language import tr
from cpm_app.session.scene import Scene
from cpm_app.session.worker.prepared_methods import AREA_OVERLAY
from cpm_app.views.items.item import enable_caching, line_pen, to_xy
from cpm_app.views.items.tiled_image import TiledImage
from cpm_app.views.layers.layer import Layer, LegendEntry
from cpm_app.views.theme import color_maps, theme
from cpm_core.numerics import Array
from cpm_core.numerics.grids import grid_points
from cpm_core.numerics.types import Pixels

_AREA_OPACITIES = (18, 150)
"""Opacity of the area of a start inside, and at its rim, out of 255."""

_MAX_EDGE_OPACITY = 235
"""Opacity of the strongest edges, out of 255."""

_POTENTIAL_OPACITY = 0.75
"""Opacity of the potential over the image when the layer is fully opaque."""


class ScalarOverlay(Layer):
    """A scalar overlay, shape (H, W), in the colors of a map; the worker computes it only while it is shown."""

    initially_shown = False
    z: ClassVar[float]
    """Place in the stack of layers."""
    color_map: ClassVar[str]
    """Name of the color map."""

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._item = TiledImage(self.z)
        self._item.setVisible(False)
        enable_caching(self._item)
        self.add_items(self._item)

    @property
    def shades(self) -> Pixels | None:
        """Shades shown, before the color map is applied; None while nothing is shown."""
        return self._item.display.shades if self._item.display is not None and self._item.isVisible() else None

    def apply_visibility(self) -> None:
        """Request the overlay only while it is shown."""
        if self.session is not None:
            self.session.set_overlay_enabled(self.name, self.shown)
        if self.shown:  # reading the colors is slow
            self._item.set_color_table(self.color_table())
        self._show_overlay()

    def show_scene(self, before: Scene) -> None:
        """Show newer values, or none."""
        if self.scene.overlays is not before.overlays:
            self._show_overlay()

    def _show_overlay(self) -> None:
        shades = self.scene.overlays.get(self.name) if self.shown else None
        # hidden, not cleared: the cached picture of an item stays on screen when its extent vanishes
        self._item.setVisible(isinstance(shades, DisplayImage))
        if isinstance(shades, DisplayImage):
            self._item.show_image(shades)

    def color_table(self) -> np.ndarray:
        """Return the colors of the 256 shades, shape (256, 3) or (256, 4), uint8."""
        return color_maps.color_table(self.color_map)


class StartAreaLayer(ScalarOverlay):
    """The area by which a run is limited, tinted, with a rim; nothing is shown while there is no limit."""

    name = AREA_OVERLAY
    title = tr("Area of the start")
    tip = tr(
        "What the start is in or around, up to the edges that enclose it. Outside it particles go only as far as the "
        "reach allows."
    )
    initially_shown = True
    colors = (theme.AREA_COLOR,)
    z = 0.95

    def create_items(self) -> None:
        """Create the items of the layer, and request the area."""
        super().create_items()
        self.apply_visibility()

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Return the entry of the area."""
        count = int(self.shades is not None)
        return (LegendEntry(count, tr("area of the start"), self.tip, theme.AREA_COLOR, "area"),)

    def color_table(self) -> np.ndarray:
        """Return one color, shape (256, 4), faint inside the area and clear at its rim."""
        opacity = np.interp(np.arange(256), (0, INSIDE_SHADE, 255), (0, *_AREA_OPACITIES))
        color = QColor(theme.AREA_COLOR)
        return np.column_stack([np.tile((color.red(), color.green(), color.blue()), (256, 1)), opacity]).astype(
            np.uint8
        )


class EdgeMapLayer(ScalarOverlay):
    """The edge map, half transparent, and fully transparent where there is no edge."""

    name = "edge_map"
    title = tr("Edge map")
    tip = tr("Strength of the edges that attract the particles.")
    shortcut = "Alt+7"
    colors = ("#f98c0a",)
    z = 1.0
    color_map = "inferno"

    def color_table(self) -> np.ndarray:
        """Return colors, shape (256, 4), whose opacity grows with the strength of the edge."""
        return np.column_stack([super().color_table(), np.linspace(0, _MAX_EDGE_OPACITY, 256).astype(np.uint8)])


class PotentialLayer(ScalarOverlay):
    """The potential in colors."""

    name = "potential"
    title = tr("Potential")
    tip = tr("Potential of the edges and of placed charges: particles slide down, from bright to dark.")
    shortcut = "Alt+8"
    colors = ("#7c7b78",)
    z = 0.9
    color_map = "cividis"

    def apply_opacity(self) -> None:
        """Set the opacity so that the image remains visible below the colors."""
        self._item.setOpacity(_POTENTIAL_OPACITY * self.opacity)


ARROW_SPACING = 22.0
"""Minimum distance between two arrows of the field [px of the screen]."""


class FieldLayer(Layer):
    """Arrows along the Lorentz force; their density follows the zoom, and their length shows its strength."""

    name = "field"
    title = tr("Field")
    tip = tr("Direction in which edges pull.")
    shortcut = "Alt+9"
    initially_shown = False
    colors = (theme.FIELD_COLOR,)

    def create_items(self) -> None:
        """Create the items of the layer."""
        self.arrows = pg.PlotCurveItem(pen=line_pen(theme.FIELD_COLOR, 1.0), antialias=True, connect="pairs")
        self.arrows.setZValue(2)
        enable_caching(self.arrows)
        self.add_items(self.arrows)
        self.view.sigRangeChanged.connect(self._draw_arrows)

    def apply_visibility(self) -> None:
        """Request the field only while it is shown."""
        if self.session is not None:
            self.session.set_overlay_enabled("field", self.shown)
        self._draw_arrows()

    def show_scene(self, before: Scene) -> None:
        """Show another field, or none."""
        if self.scene.overlays is not before.overlays:
            self._draw_arrows()

    def _draw_arrows(self, *_: object) -> None:
        field = self.scene.overlays.get("field") if self.shown else None
        self.arrows.setVisible(field is not None)
        if field is not None:
            pixel = float(self.view.viewPixelSize()[0])
            self.arrows.setData(
                *to_xy(build_arrow_lines(*find_arrow_ends(np.asarray(field), self.view.viewRect(), pixel)))
            )


def find_arrow_ends(field: Array, seen: QRectF, pixel: float) -> tuple[Array, Array]:
    """Find the starts and ends of arrows, evenly spaced within the visible part.

    Parameters
    ----------
    field : ndarray, shape (2, H, W)
        Vectors of at most unit length.
    seen : QRectF
        Visible part of the canvas.
    pixel : float
        Size of a pixel of the screen [px of the image].

    Returns
    -------
    starts, ends : ndarray, shape (N, 2)
        (row, col).
    """
    stride = max(1, int(np.ceil(ARROW_SPACING * pixel)))
    rows = np.arange(stride // 2, field.shape[1], stride)
    cols = np.arange(stride // 2, field.shape[2], stride)
    rows = rows[(rows >= seen.top()) & (rows <= seen.bottom())]
    cols = cols[(cols >= seen.left()) & (cols <= seen.right())]
    grid = grid_points((rows, cols))
    vectors = field[:, grid[:, 0], grid[:, 1]].T * (0.85 * stride)
    starts = grid - 0.5 * vectors
    return starts, starts + vectors


def build_arrow_lines(starts: Array, ends: Array) -> Array:
    """Build pairs of points that draw a shaft and two barbs for each arrow.

    Parameters
    ----------
    starts, ends : ndarray, shape (N, 2)
        (row, col) [px].

    Returns
    -------
    ndarray, shape (6 N, 2)
        Ends of three segments for each arrow.
    """
    vectors = ends - starts
    across = np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)
    left = ends - 0.30 * vectors + 0.18 * across
    right = ends - 0.30 * vectors - 0.18 * across
    return np.stack([starts, ends, left, ends, right, ends], axis=1).reshape(-1, 2)
