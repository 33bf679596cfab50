"""Live wire: the strongest path along the edges from one place to another.

It is a path of least cost over the pixels; the stronger the edge, the cheaper the step (Mortensen and Barrett
1995, doi:10.1145/218380.218442), moved onto the ridge of the edge between the pixels. The costs from one place to all
pixels around it are found once, so that the path follows the pointer at once.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
import skimage

from cpm_core.field.scale_field import EDGE_END_FRACTION, ScaleField
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import lie_inside, nearest_pixels
from cpm_core.numerics.types import NO_POINTS, Array, Index, Position
from cpm_core.reconstruction.curve.gap_bridging import (
    BLOCKED_COST,
    EXTRA_COST_OFF_EDGE,
    UNBLOCKED_RADIUS,
    smooth_pixel_path,
)
from cpm_core.reconstruction.curve.subpixel import refine_to_ridge

_STRONG_EDGE_PERCENTILE = 90.0
"""Percentile of the edge strength above the floor that counts as a strong edge."""

_SEARCH_MARGIN = 24
"""Distance beyond its two places within which the path is searched [px]."""

_EXTENDED_SEARCH_MARGIN = 64
"""Margin of the search when the pointer has left the searched box [px]."""

_MAX_SNAP_DISTANCE = 2.0
"""Greatest distance by which the path is moved onto the ridge [px]."""

_PATH_SPACING = 1.0
"""Largest distance between the vertices of the path [px]."""

_MOVE_SMOOTHING = 2.0
"""Sigma, in vertices, by which the moves onto the ridge are smoothed where some vertices have none."""


class LiveWire:
    """Paths along the edges from one place.

    Parameters
    ----------
    scale_field : ScaleField
        Fields of the image itself.
    start : tuple of float
        Where all paths begin (row, col) [px].
    avoided : sequence of ndarray, each of shape (K, 2)
        Lines that a path neither follows nor crosses unless it has to.
    spared : sequence of tuple of float
        Further places around which nothing is avoided, since the path may end there.
    """

    def __init__(
        self,
        scale_field: ScaleField,
        start: Position,
        avoided: Sequence[Array] = (),
        spared: Sequence[Position] = (),
    ) -> None:
        self._field, self._start = scale_field, start
        self._avoided, self._spared = avoided, np.array([start, *spared], float)
        self._low, self._high = self._box_around(self._nearest_pixel(start), _SEARCH_MARGIN)
        self._search: skimage.graph.MCP_Geometric | None = None

    def path_to(self, place: Position) -> Array:
        """Find the path from the start to another place, both included, shape (K, 2) [px]."""
        ends = np.array([self._start, place], float)
        if np.linalg.norm(ends[1] - ends[0]) < _PATH_SPACING:
            return ends
        goal = self._nearest_pixel(place)
        low, high = self._box_around(goal, _SEARCH_MARGIN)
        if self._search is None or (low < self._low).any() or (high > self._high).any():
            self._search = self._extend_search(goal)
        pixels = (np.array(self._search.traceback(tuple(goal - self._low))) + self._low).astype(float)
        return snap_path_to_ridge(smooth_pixel_path(pixels, ends[0], ends[1]), self._field)

    def _nearest_pixel(self, place: Position) -> Index:
        return nearest_pixels(place, self._field.shape)

    def _box_around(self, pixel: Index, margin: int) -> tuple[Index, Index]:
        last = np.array(self._field.shape) - 1
        return np.clip(pixel - margin, 0, last), np.clip(pixel + margin, 0, last)

    def _extend_search(self, goal: Index) -> skimage.graph.MCP_Geometric:
        """Compute the costs of all pixels around the start and the goal, and around the searched box."""
        low, high = self._box_around(goal, _EXTENDED_SEARCH_MARGIN)
        self._low, self._high = np.minimum(self._low, low), np.maximum(self._high, high)
        window = tuple(slice(a, b + 1) for a, b in zip(self._low.tolist(), self._high.tolist(), strict=True))
        strength = self._field.edge_map[window]
        above = strength[strength >= self._field.floor]
        strong = (
            float(np.percentile(above, _STRONG_EDGE_PERCENTILE)) if above.size else max(self._field.strongest, 1e-300)
        )
        costs = 1.0 / (1.0 + EXTRA_COST_OFF_EDGE * np.minimum(strength / strong, 1.0))
        avoided = np.concatenate([NO_POINTS, *(polyline.sample_path(line, 0.25) for line in self._avoided)])
        away = np.linalg.norm(avoided[:, None] - self._spared, axis=2).min(axis=1)
        pixels = np.rint(avoided[away > UNBLOCKED_RADIUS]).astype(np.int64) - self._low
        pixels = pixels[lie_inside(pixels, costs.shape)]
        costs[tuple(np.unique(pixels, axis=0).T)] += BLOCKED_COST
        search = skimage.graph.MCP_Geometric(costs)
        search.find_costs([tuple(self._nearest_pixel(self._start) - self._low)])
        return search


def snap_path_to_ridge(path: Array, scale_field: ScaleField) -> Array:
    """Move a path near edges, shape (K, 2), onto their ridges; both ends stay.

    Where there is no edge near enough, it stays as well, and in between it fades from one to the other.
    """
    path = polyline.resample_path(path, _PATH_SPACING)
    inner = path[1:-1]
    if not len(inner):
        return path
    ridge, found = refine_to_ridge(inner, scale_field)
    found &= np.linalg.norm(ridge - inner, axis=1) <= _MAX_SNAP_DISTANCE
    found &= scale_field.strength_at(ridge) >= EDGE_END_FRACTION * scale_field.floor
    move = np.where(found[:, None], ridge - inner, 0.0)
    calm = scipy.ndimage.gaussian_filter1d(move, _MOVE_SMOOTHING, axis=0, mode="nearest")
    alone = scipy.ndimage.minimum_filter1d(found, 5, mode="nearest") == 0
    place = np.where(alone[:, None], inner + calm, ridge)
    moved = np.concatenate([path[:1], place, path[-1:]])
    kept = [0]  # the vertices at which it does not turn back
    for n in range(1, len(moved) - 1):
        along = moved[n] - moved[kept[-1]]
        if along @ (moved[n + 1] - moved[n - 1]) > 0.0 and np.linalg.norm(along) > 0.1 * _PATH_SPACING:
            kept.append(n)
    return moved[[*kept, len(moved) - 1]]


def snap_place_to_ridge(place: Position, scale_field: ScaleField, reach: float) -> Position:
    """Move a place to the ridge of an edge within reach [px]; without one return the place itself."""
    ridge, found = refine_to_ridge(np.array([place]), scale_field)
    strong = scale_field.strength_at(ridge)[0] >= scale_field.floor
    if found[0] and strong and np.linalg.norm(ridge[0] - place) <= reach:
        return tuple(ridge[0].tolist())
    return place
