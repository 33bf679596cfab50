"""The layers of edge map, potential and electric field."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, QTimer
from PySide6.QtGui import QColor

from app.model.display.display_image import DisplayImage, Shades
from app.model.display.flow_lines import Seen, flow_lines
from app.model.text.language import tr
from app.session.scene import Scene
from app.views.canvas.items.item import cached, line_pen, to_xy
from app.views.canvas.items.tiled_image import TiledImage
from app.views.canvas.layers.layer import Choice, Layer, Requests, Switch
from app.views.theme import color_maps, theme
from cpm_core.numerics.types import Array

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


ARROW_SPACING = 22.0
"""Least distance between two arrows of the field [px of the screen]."""

LINE_SPACING = 30.0
"""Distance between two flow lines [px of the screen]."""

_DELAY = 60
"""Time without a change of the visible part after which flow lines are computed again [ms]."""

_HEAD = 6.0
"""Length of an arrow head [px of the screen]."""

_ARROWS, _LINES = "arrows", "lines"


class FieldLayer(Layer):
    """Arrows along the Lorentz force, or its flow lines; their density follows the zoom."""

    name = "field"
    title = tr("Field")
    tip = tr("Direction in which edges pull.")
    shortcut = "Alt+9"
    initially = False
    in_slices = True
    colors = (theme.FIELD,)
    options = (
        Choice(
            "way",
            tr("Show as"),
            {_ARROWS: tr("Arrows"), _LINES: tr("Flow lines")},
            _ARROWS,
            tr("The length of an arrow shows the strength of the force; flow lines follow its direction."),
        ),
    )

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self._item = pg.PlotCurveItem(pen=line_pen(theme.FIELD, 1.0), antialias=True)
        self._item.setZValue(2)
        cached(self._item)
        self.add(self._item)
        self._field: Array | None = None
        self._redraw_later = QTimer(self)
        self._redraw_later.setSingleShot(True)
        self._redraw_later.setInterval(_DELAY)
        self._redraw_later.timeout.connect(self._draw)
        view.sigRangeChanged.connect(self._follow_range)

    @property
    def drawn(self) -> Array:
        """Points drawn (row, col), shape (N, 2)."""
        x, y = self._item.getData()
        return np.empty((0, 2)) if x is None else np.stack([y, x], axis=1)

    def show_or_hide(self) -> None:
        """Request the field only while it is shown."""
        self.requests.want_overlay("field", self.shown)
        self._show()

    def follow_choice(self, name: str) -> None:
        """Switch between arrows and lines."""
        self._draw()

    def follow(self, before: Scene) -> None:
        """Show another field, or none."""
        if self.scene.overlays.get("field") is not before.overlays.get("field"):
            self._show()

    def _show(self) -> None:
        field = self.scene.overlays.get("field") if self.shown else None
        self._use(None if field is None else np.asarray(field, dtype=float))

    def _use(self, field: Array | None) -> None:
        # the same field is delivered again when another overlay is requested as well
        if field is None or self._field is None or not np.shares_memory(field, self._field):
            self._field = field
            self._draw()

    def _follow_range(self, *_: object) -> None:
        if self._field is None:
            return
        if self.word("way") == _ARROWS:
            self._draw()
        else:
            # lines take longer than arrows, and existing ones remain correct while the image moves
            self._redraw_later.start()

    def _draw(self) -> None:
        self._item.setVisible(self._field is not None)
        if self._field is None:
            return
        pixel = float(self.view.viewPixelSize()[0])
        if self.word("way") == _ARROWS:
            lines = arrow_lines(*arrows(self._field, self.view.viewRect(), pixel))
            connected: NDArray[np.int32] = np.arange(1, len(lines) + 1, dtype=np.int32) % 2
        else:
            seen = self.view.viewRect()
            rectangle = Seen(seen.top(), seen.left(), seen.bottom(), seen.right())
            lines, connected = line_points(flow_lines(self._field, rectangle, LINE_SPACING * pixel), _HEAD * pixel)
        self._item.setData(*to_xy(lines), connect=connected)


def line_points(lines: list[Array], head: float) -> tuple[Array, NDArray[np.int32]]:
    """Points of lines with a head at the end of each, and whether each point is connected to the next.

    Parameters
    ----------
    lines : list of ndarray, shape (K, 2)
        Positions (row, col), at least two.
    head : float
        Length of a head [px of the image].

    Returns
    -------
    points : ndarray, shape (N, 2)
        (row, col).
    connected : ndarray of int32, shape (N,)
        0 where a piece ends.
    """
    if not lines:
        return np.empty((0, 2)), np.empty(0, np.int32)
    ends = np.array([line[-1] for line in lines])
    along = ends - np.array([line[-2] for line in lines])
    along *= head / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    across = 0.5 * np.stack([along[:, 1], -along[:, 0]], axis=1)
    heads = np.stack([ends - along + across, ends, ends - along - across], axis=1).reshape(-1, 2)
    points = np.concatenate([*lines, heads])
    connected = np.ones(len(points), np.int32)
    lengths = np.array([len(line) for line in lines])
    connected[np.cumsum(lengths) - 1] = 0
    connected[len(points) - len(heads) + 2 :: 3] = 0
    return points, connected


def arrows(field: Array, seen: QRectF, pixel: float) -> tuple[Array, Array]:
    """Starts and ends of arrows, evenly spaced within the visible part.

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
    grid = np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1).reshape(-1, 2)
    vectors = field[:, grid[:, 0], grid[:, 1]].T * (0.85 * stride)
    starts = grid - 0.5 * vectors
    return starts, starts + vectors


def arrow_lines(starts: Array, ends: Array) -> Array:
    """Pairs of points, shape (6 N, 2), that draw a shaft and two barbs for each arrow."""
    vectors = ends - starts
    across = np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)
    left = ends - 0.30 * vectors + 0.18 * across
    right = ends - 0.30 * vectors - 0.18 * across
    return np.stack([starts, ends, left, ends, right, ends], axis=1).reshape(-1, 2)
