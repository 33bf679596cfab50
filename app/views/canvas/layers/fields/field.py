"""The layer of the electric field."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, QTimer

from app.model.display.flow_lines import Seen, flow_lines
from app.model.text.language import tr
from app.session.scene import Scene
from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.item import cached, line_pen
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.options import Choice
from app.views.theme import theme
from cpm_core.numerics.types import Array

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
