"""Ground: where and when particles have first sat on an edge.

Growth is not told by the number of particles, which crowd together and thin out again, but by the cells of the image
they have been in, a number that can only rise and is bounded. What has found no new ground for a while is let come to
rest, each neighbourhood by itself, so that every run ends and a front far away keeps nobody awake.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array

Steps = NDArray[np.int32]

_CELL = 4.0
"""Side of the cells by which ground is counted [px]."""

_REACH = 4
"""Cells to each side that the news of a cell reaches."""

_NEVER = -1


class Coverage(NamedTuple):
    """What is known of the ground of an image; a plain tuple for the compiled loops.

    Attributes
    ----------
    found : ndarray of int32, shape (h, w)
        Step of the first visit of every cell, -1 for none.
    latest : ndarray of int32, shape (h, w)
        Step of the latest first visit among the cells around each, -1 for none.
    """

    found: Steps
    latest: Steps

    @property
    def size(self) -> int:
        """Cells visited so far."""
        return int(np.count_nonzero(self.found != _NEVER))


def no_coverage(shape: tuple[int, ...]) -> Coverage:
    """Ground of an image of this shape before any particle has sat on it."""
    cells = np.full(tuple(int(n / _CELL) + 1 for n in shape), _NEVER, np.int32)
    return Coverage(cells, cells)


def cover(coverage: Coverage, positions: Array, on_edge: NDArray[np.bool_], step: int) -> tuple[Coverage, int]:
    """Mark the cells that particles on edges stand in.

    Parameters
    ----------
    coverage : Coverage
        Before.
    positions : ndarray, shape (N, 2)
        The particles [px].
    on_edge : ndarray of bool, shape (N,)
        Which of them sit on an edge.
    step : int
        The step now.

    Returns
    -------
    coverage : Coverage
        With these visits; the same one if there was no news.
    new : int
        Cells visited for the first time.
    """
    if not _count_fresh(coverage.found, positions, on_edge):
        return coverage, 0
    after = Coverage(coverage.found.copy(), coverage.latest.copy())
    return after, int(_mark(after, positions, on_edge, step))


def renewed(coverage: Coverage, step: int) -> Coverage:
    """Ground as if all that has been visited had just been found, at the step now."""
    return Coverage(*(np.where(cells == _NEVER, _NEVER, step).astype(np.int32) for cells in coverage))


def renewed_near(coverage: Coverage, places: Array, reach: float, step: int) -> Coverage:
    """Ground as if there were news in all cells within reach of places, shape (K, 2) [px], at the step now."""
    latest = coverage.latest.copy()
    for place in places:
        parts, away = [], []
        for along, x in zip(latest.shape, place, strict=True):
            first, last = (min(max(int((x + sign * reach + 0.5) / _CELL), 0), along - 1) for sign in (-1, 1))
            parts.append(slice(first, last + 1))
            middle = _CELL * (np.arange(first, last + 1) + 0.5) - 0.5
            away.append(np.maximum(np.abs(middle - x) - 0.5 * _CELL, 0.0))
        latest[tuple(parts)][away[0][:, None] ** 2 + away[1] ** 2 < reach**2] = step
    return Coverage(coverage.found, latest)


def idle_at(coverage: Coverage, positions: Array, step: int, elsewhere: int) -> NDArray[np.int64]:
    """Steps since there was new ground around each particle, shape (N,); see `idle_steps`."""
    idle = np.empty(len(positions), np.int64)
    _idle_at(coverage.latest, positions, step, elsewhere, idle)
    return idle


@compiled
def _idle_at(latest: Steps, position: Array, step: int, elsewhere: int, idle: NDArray[np.int64]) -> None:
    for i in range(len(position)):
        idle[i] = idle_steps(latest, position[i, 0], position[i, 1], step, elsewhere)


@compiled
def idle_steps(latest: Steps, y: float, x: float, step: int, elsewhere: int) -> int:
    """Steps since there was new ground around a place [px]; `elsewhere` for a place far from all ground."""
    newest = latest[_own(y, latest.shape[0]), _own(x, latest.shape[1])]
    return elsewhere if newest == _NEVER else step - newest


@compiled
def _own(place: float, along: int) -> int:
    return int(min(max(int((place + 0.5) / _CELL), 0), along - 1))


@compiled
def _count_fresh(found: Steps, position: Array, on_edge: NDArray[np.bool_]) -> int:
    """Particles that sit on ground nobody has been on."""
    fresh = 0
    for i in range(len(position)):
        if on_edge[i] and found[_own(position[i, 0], found.shape[0]), _own(position[i, 1], found.shape[1])] == _NEVER:
            fresh += 1
    return fresh


@compiled
def _mark(coverage: Coverage, position: Array, on_edge: NDArray[np.bool_], step: int) -> int:
    """Mark the visits in place and return how many cells they are."""
    found, latest = coverage.found, coverage.latest
    new = 0
    for i in range(len(position)):
        row, col = _own(position[i, 0], found.shape[0]), _own(position[i, 1], found.shape[1])
        if on_edge[i] and found[row, col] == _NEVER:
            found[row, col] = step
            new += 1
            for r in range(max(row - _REACH, 0), min(row + _REACH + 1, found.shape[0])):
                for c in range(max(col - _REACH, 0), min(col + _REACH + 1, found.shape[1])):
                    latest[r, c] = step
    return new
