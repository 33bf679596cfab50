"""Ground: where and when particles have first sat on an edge.

Growth is not told by the number of particles, which crowd together and thin out again, but by the cells of the image
they have been in, a number that can only rise and is bounded. What has found no new ground for a while is let come to
rest, each neighbourhood by itself, so that every run ends and a front far away keeps nobody awake.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ground = NDArray[np.int32]

_CELL = 4.0
"""Side of the cells by which ground is counted [px]."""

_NEIGHBOURHOOD = 9
"""Cells across the neighbourhood whose news reaches a particle."""

_NEVER = -1


def unvisited(shape: tuple[int, ...]) -> Ground:
    """Ground of an image of this shape before any particle has sat on it."""
    return np.full(tuple(int(n / _CELL) + 1 for n in shape), _NEVER, np.int32)


def _cells(positions: Array, ground: Ground) -> tuple[NDArray[np.int64], ...]:
    index = ((positions + 0.5) / _CELL).astype(np.int64)
    return tuple(np.clip(index, 0, np.array(ground.shape) - 1).T)


def explore(ground: Ground, positions: Array, step: int) -> tuple[Ground, int]:
    """Mark the cells that particles on edges stand in.

    Parameters
    ----------
    ground : ndarray of int32, one dimension for each axis
        Step of the first visit of every cell, -1 for none.
    positions : ndarray, shape (N, D)
        The particles that sit on an edge [px].
    step : int
        The step now.

    Returns
    -------
    ground : ndarray of int32
        With these visits; the same array if there was no news.
    new : int
        Cells visited for the first time.
    """
    cells = _cells(positions, ground)
    fresh = ground[cells] == _NEVER
    if not fresh.any():
        return ground, 0
    after = ground.copy()
    after[tuple(axis[fresh] for axis in cells)] = step
    return after, int((after != ground).sum())


def renewed(ground: Ground, step: int) -> Ground:
    """Ground as if all that has been visited had just been found.

    Parameters
    ----------
    ground : ndarray of int32
        Step of the first visit of every cell.
    step : int
        The step now.

    Returns
    -------
    ndarray of int32
        The step now for every visited cell.
    """
    return np.where(ground == _NEVER, _NEVER, step).astype(np.int32)


def idle_steps(ground: Ground, positions: Array, step: int, elsewhere: int) -> NDArray[np.int64]:
    """Steps since there was new ground around each particle.

    Parameters
    ----------
    ground : ndarray of int32
        Step of the first visit of every cell.
    positions : ndarray, shape (N, D)
        Particles [px].
    step : int
        The step now.
    elsewhere : int
        Answer for particles far from all ground.

    Returns
    -------
    ndarray of int64, shape (N,)
        Steps.
    """
    newest = scipy.ndimage.maximum_filter(ground, size=_NEIGHBOURHOOD, mode="nearest")[_cells(positions, ground)]
    return np.where(newest == _NEVER, elsewhere, step - newest).astype(np.int64)
