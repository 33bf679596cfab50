"""Flow lines: the ways that a particle without inertia would take along a field, evenly spread over what is seen.

Seeds lie on a grid; all lines grow at once, by Euler steps of half a spacing's fraction along the direction of the
field, and end where the field vanishes or another line has been before (after Jobard and Lefer 1997,
doi:10.1007/978-3-7091-6876-9_5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.types import Array, Index

_STEPS = 24
"""Points of a line, at most, ahead of its seed and behind it."""

_STRIDE = 0.16
"""Length of a step, in spacings of the seeds."""

_CELL = 0.34
"""Side of a cell that only one line may pass through, in spacings."""

_WEAK = 1e-3
"""Strength, compared with the strongest that is seen, under which a field has no direction."""

_SHORT = 4
"""Points under which a line is not worth drawing."""

_CURLED = 0.4
"""Distance from its beginning to its end, in spacings, under which a line only turns round in a trough."""


class Seen(NamedTuple):
    """The part of the image that is seen (row, col) [px]."""

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
        Where lines are wanted.
    spacing : float
        Distance between two seeds [px].

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
    # On a grid that does not depend on what is seen, lines stay where they are while the image is moved.
    rows = np.arange(np.ceil(top / spacing - 0.5), np.floor(bottom / spacing - 0.5) + 1)
    cols = np.arange(np.ceil(left / spacing - 0.5), np.floor(right / spacing - 0.5) + 1)
    seeds = (np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1).reshape(-1, 2) + 0.5) * spacing
    if not len(seeds):
        return []
    points, first, last = _grow(field, seeds, Seen(top, left, bottom, right), spacing)
    everyone = np.arange(len(points))
    way = points[everyone, last] - points[everyone, first]
    worth = (last - first + 1 >= _SHORT) & (np.hypot(way[:, 0], way[:, 1]) >= _CURLED * spacing)
    return [points[i, first[i] : last[i] + 1] for i in np.flatnonzero(worth)]


def _grow(field: Array, seeds: Array, seen: Seen, spacing: float) -> tuple[Array, Index, Index]:
    """Points of all lines, shape (N, 2 K + 1, 2), and which of them are the first and the last of each."""
    count = len(seeds)
    points = np.zeros((count, 2 * _STEPS + 1, 2))
    points[:, _STEPS] = seeds
    ends = {-1: np.full(count, _STEPS), 1: np.full(count, _STEPS)}
    side = _CELL * spacing
    shape = (int((seen.bottom - seen.top) / side) + 1, int((seen.right - seen.left) / side) + 1)
    owner = np.full(shape, -1)
    everyone = np.arange(count)
    least = _WEAK * float(np.abs(field[:, ::4, ::4]).max(initial=1e-300))

    def claim(who: Index, at: Array) -> Index:
        """Those of them in whose cell nobody else has been."""
        row, col = ((at - (seen.top, seen.left)) / side).astype(int).T
        free = (owner[row, col] == -1) | (owner[row, col] == who)
        row, col, who = row[free], col[free], who[free]
        owner[row, col] = who
        return np.asarray(who[owner[row, col] == who])

    going = {way: claim(everyone, seeds) for way in (1, -1)}
    for step in range(_STEPS):
        for way in (1, -1):
            who = going[way]
            at = points[who, _STEPS + way * step]
            direction, strength = _direction(field, at)
            to = at + way * _STRIDE * spacing * direction
            inside = (to >= (seen.top, seen.left)).all(axis=1) & (to <= (seen.bottom, seen.right)).all(axis=1)
            inside &= strength > least
            who, to = who[inside], to[inside]
            points[who, _STEPS + way * (step + 1)] = to
            who = claim(who, to)
            ends[way][who] = _STEPS + way * (step + 1)
            going[way] = who
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
