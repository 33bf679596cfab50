"""Flow lines: paths of a particle without inertia along a field, evenly spaced over the visible part of the image.

Seeds lie on a grid. All lines grow at once, by Euler steps of a fraction of the spacing along the direction of the
field, and end where the field vanishes or at another line (after Jobard and Lefer 1997,
doi:10.1007/978-3-7091-6876-9_5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.types import Array, Index

_STEPS = 24
"""Maximum number of points of a line on either side of its seed."""

_STRIDE = 0.16
"""Length of a step, in spacings of the seeds."""

_CELL = 0.34
"""Side of a cell that only one line may cross, in spacings."""

_WEAK = 1e-3
"""Strength, as a fraction of the largest visible one, below which a field has no direction."""

_SHORT = 4
"""Number of points below which a line is not drawn."""

_CURLED = 0.4
"""Distance of its ends, in spacings, below which a line only turns around in a minimum, and is not drawn."""


class Seen(NamedTuple):
    """The visible part of the image (row, col) [px]."""

    top: float
    left: float
    bottom: float
    right: float


def flow_lines(field: Array, seen: Seen, spacing: float) -> list[Array]:
    """Lines along a field.

    Parameters
    ----------
    field : ndarray, shape (2, H, W)
        Vectors (row, col).
    seen : Seen
        The visible part of the image.
    spacing : float
        Distance of two seeds [px].

    Returns
    -------
    list of ndarray, shape (K, 2)
        Positions (row, col), in the direction of the field.
    """
    height, width = field.shape[1:]
    top, bottom = max(seen.top, 0.0), min(seen.bottom, height - 1.0)
    left, right = max(seen.left, 0.0), min(seen.right, width - 1.0)
    if top >= bottom or left >= right:
        return []
    # The grid does not depend on the visible part, so that lines stay in place while the image is moved.
    rows = np.arange(np.ceil(top / spacing - 0.5), np.floor(bottom / spacing - 0.5) + 1)
    cols = np.arange(np.ceil(left / spacing - 0.5), np.floor(right / spacing - 0.5) + 1)
    seeds = (np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1).reshape(-1, 2) + 0.5) * spacing
    if not len(seeds):
        return []
    points, first, last = _grow(field, seeds, Seen(top, left, bottom, right), spacing)
    every = np.arange(len(points))
    way = points[every, last] - points[every, first]
    long_enough = (last - first + 1 >= _SHORT) & (np.hypot(way[:, 0], way[:, 1]) >= _CURLED * spacing)
    return [points[i, first[i] : last[i] + 1] for i in np.flatnonzero(long_enough)]


def _grow(field: Array, seeds: Array, seen: Seen, spacing: float) -> tuple[Array, Index, Index]:
    """Points of all lines, shape (N, 2 K + 1, 2), and the indices of the first and the last point of each."""
    count = len(seeds)
    points = np.zeros((count, 2 * _STEPS + 1, 2))
    points[:, _STEPS] = seeds
    ends = {-1: np.full(count, _STEPS), 1: np.full(count, _STEPS)}
    side = _CELL * spacing
    shape = (int((seen.bottom - seen.top) / side) + 1, int((seen.right - seen.left) / side) + 1)
    owner = np.full(shape, -1)
    every = np.arange(count)
    least = _WEAK * float(np.abs(field[:, ::4, ::4]).max(initial=1e-300))

    def claim(lines: Index, at: Array) -> Index:
        """Those lines whose cell is free or their own."""
        row, col = ((at - (seen.top, seen.left)) / side).astype(int).T
        free = (owner[row, col] == -1) | (owner[row, col] == lines)
        row, col, lines = row[free], col[free], lines[free]
        owner[row, col] = lines
        return np.asarray(lines[owner[row, col] == lines])

    going = {way: claim(every, seeds) for way in (1, -1)}
    for step in range(_STEPS):
        for way in (1, -1):
            lines = going[way]
            at = points[lines, _STEPS + way * step]
            direction, strength = _direction(field, at)
            to = at + way * _STRIDE * spacing * direction
            inside = (to >= (seen.top, seen.left)).all(axis=1) & (to <= (seen.bottom, seen.right)).all(axis=1)
            inside &= strength > least
            lines, to = lines[inside], to[inside]
            points[lines, _STEPS + way * (step + 1)] = to
            lines = claim(lines, to)
            ends[way][lines] = _STEPS + way * (step + 1)
            going[way] = lines
    return points, ends[-1], ends[1]


def _direction(field: Array, at: Array) -> tuple[Array, Array]:
    """Unit vectors of a field at positions, shape (N, 2), and its strength there; bilinear."""
    corner = np.minimum(at.astype(int), (field.shape[1] - 2, field.shape[2] - 2))
    row, col = corner.T
    down, right = (at - corner).T
    vector = (
        field[:, row, col] * (1 - down) * (1 - right)
        + field[:, row + 1, col] * down * (1 - right)
        + field[:, row, col + 1] * (1 - down) * right
        + field[:, row + 1, col + 1] * down * right
    ).T
    strength = np.hypot(vector[:, 0], vector[:, 1])
    return vector / np.maximum(strength, 1e-300)[:, None], strength
