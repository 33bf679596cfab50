"""Tracing the ridge of the edges from point to point.

On the ridge the edge map has a maximum along the image gradient: its slope in that direction is zero and decreasing.
This zero line is a smooth curve without branches, and the gradient across it gives it a direction, with the bright side
always on the same hand. So each point has one successor, which is found by following the ridge in steps much shorter
than any structure that survives the smoothing: curves a pixel apart on both sides of a slit are never confused, and no
corner is cut, however far apart the points are.
"""

from __future__ import annotations

import numpy as np

from cpm_core.field.scale_field import EDGE_END_FRACTION, ScaleField
from cpm_core.image.regions import BarrierMap
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index
from cpm_core.reconstruction.curve.ridge import Ridge, ridge_arrays
from cpm_core.reconstruction.curve.ridge_tracing_kernels import (
    RidgeSearchLimits,
    RidgeSeeds,
    place_on_ridge,
    trace_seed_paths,
)

_MAX_STEP = 0.4
"""Greatest length of a step [px]."""

_MAX_STEP_IN_SPACINGS = 0.2
"""Greatest length of a step, in spacings."""

_LONGEST_BETWEEN_POINTS = 10.0
"""Greatest length of the ridge between two points, in d_min."""

_LONGEST_LOOSE_END = 5.0
"""Greatest length of the ridge beyond a last point, in d_min."""

_LONGEST_BETWEEN_POINTS_AT_REST = 50.0
"""Greatest length of the ridge between two points at the end of a run, in d_min: along a limb of two pixels the
electric field has one equilibrium for both sides, and one of them stays without particles."""

_LONGEST_DIP = 2.5
"""Greatest length, in d_min, over which the ridge between two points may be under the edge floor."""

_MIN_SEEDS_PER_THREAD = 300
"""Least number of seeds for a thread."""

_FADING_LENGTH = 1.6
"""Length over which an edge must not fade to less than `EDGE_END_FRACTION`, in d_min / 2; twice as much for a loose
end, as an abrupt end is blurred."""


def trace_ridges(points: Array, scale_field: ScaleField, d_min: float, at_rest: bool = False) -> tuple[Array, Index]:
    """Trace ridges from point to point.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Distinct points on the ridge, `refine_to_ridge` [px].
    scale_field : ScaleField
        Fields of the scale.
    d_min : float
        Spacing of particles [px]. The ridge is followed from a point for up to 10 spacings to the next one; without a
        next point 5 spacings are kept.
    at_rest : bool
        Whether all particles are at rest, so that the ridge is followed for up to 50 spacings.

    Returns
    -------
    vertices : ndarray, shape (M, 2)
        The points, then the vertices between and beyond them that keep contours on the ridge.
    edges : ndarray of int64, shape (E, 2)
        Pairs of vertices.
    """
    limits = RidgeSearchLimits(
        step=min(_MAX_STEP, _MAX_STEP_IN_SPACINGS * d_min),
        longest=(_LONGEST_BETWEEN_POINTS_AT_REST if at_rest else _LONGEST_BETWEEN_POINTS) * d_min,
        loose=_LONGEST_LOOSE_END * d_min,
        dip=_LONGEST_DIP * d_min,
        fading=0.5 * _FADING_LENGTH * d_min,
        floor=scale_field.floor,
        faintest=EDGE_END_FRACTION * scale_field.floor,
    )
    ridge = ridge_arrays(scale_field)
    seeds = _place_seeds(points, ridge, limits)
    walks = _RidgeWalks(ridge, scale_field.barrier_map, seeds, limits)
    every = np.arange(len(points))
    following = walks.follow_seeds(every, 1.0, loose=False)
    followed = np.zeros(len(points), np.bool_)
    followed[following[following >= 0]] = True
    behind = every[~followed]
    before = walks.follow_seeds(behind, -1.0)
    following[before[before >= 0]] = behind[before >= 0]
    walks.follow_seeds(every[following < 0], 1.0)
    return walks.vertices_and_edges()


def _place_seeds(points: Array, ridge: Ridge, limits: RidgeSearchLimits) -> RidgeSeeds:
    """Sort points into seeds by pixel, moved exactly onto the ridge."""
    place = np.array(points, dtype=float)
    ahead = np.zeros_like(place)
    run_in_parallel(
        lambda first, last: place_on_ridge(ridge, place, ahead, limits.step, first, last),
        len(place),
        _MIN_SEEDS_PER_THREAD,
    )
    shape = ridge.strength.shape
    np.clip(place, 0.0, np.array(shape) - 1.0, out=place)
    row, col = (place + 0.5).astype(np.int64).T
    pixel = row * shape[1] + col
    order = np.argsort(pixel, kind="stable")
    first = np.diff(pixel[order], prepend=-1) > 0
    head, following = np.full(shape, -1, np.int32), np.full(len(place), -1, np.int64)
    head.ravel()[pixel[order[first]]] = order[first]
    following[order[:-1]] = np.where(first[1:], -1, order[1:])
    return RidgeSeeds(place, ahead, head, following)


class _RidgeWalks:
    """Paths from seed to seed, collected as they are found."""

    def __init__(self, ridge: Ridge, barrier_map: BarrierMap, seeds: RidgeSeeds, limits: RidgeSearchLimits) -> None:
        self._walked = ridge, barrier_map, seeds, limits
        self._longest = int(2.0 * limits.longest / limits.step) + 2
        self._vertices, self._edges = [seeds.place], [np.empty((0, 2), np.int64)]
        self._count = len(seeds.place)

    def follow_seeds(self, seeds: Index, sign: float, loose: bool = True) -> Index:
        """Follow the ridge from some seeds ahead (1) or back (-1), and keep paths to a seed, and loose ones if `loose`.

        Returns the seed that each path has met, shape of `seeds`, -1 for none.
        """
        met = np.full(len(seeds), -1, np.int64)
        found: dict[int, list[tuple[Array, Index]]] = {}

        def follow_share(first: int, last: int) -> None:
            own = found[first] = []
            way = np.empty((self._longest + 2, 4))
            while first < last:
                room = 4 * (last - first) + 2 * self._longest
                vertices, edges = np.empty((room, 2)), np.empty((room, 2), np.int64)
                first, added, joined = trace_seed_paths(
                    *self._walked, seeds, met, sign, loose, first, last, way, vertices, edges
                )
                own.append((vertices[:added], edges[:joined]))

        run_in_parallel(follow_share, len(seeds), _MIN_SEEDS_PER_THREAD)
        for first in sorted(found):
            for vertices, edges in found[first]:
                self._vertices.append(vertices)
                self._edges.append(np.where(edges < 0, self._count - 1 - edges, edges))
                self._count += len(vertices)
        return met

    def vertices_and_edges(self) -> tuple[Array, Index]:
        """Return all vertices, the seeds first, shape (M, 2), and edges, shape (E, 2)."""
        return np.concatenate(self._vertices), np.concatenate(self._edges)
