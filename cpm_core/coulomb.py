"""The Coulomb force between the free particles, eq. (9)."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.kernels import compiled

Array = NDArray[np.float64]

_WORTH_A_THREAD = 600
"""Particles from which on two threads finish earlier than one."""

_SAME_SPOT = 1e-60
"""Squared distance below which two particles stand on the same spot; a bound instead of a branch keeps the loop on
vector registers, and a pair on one spot adds its vanishing distance, which is nothing."""


def coulomb_force(positions: ArrayLike, method: str = "auto", targets: NDArray[np.int64] | None = None) -> Array:
    """Coulomb force on every particle from all the others, eq. (9) with unit charges.

    Parameters
    ----------
    positions : array_like, shape (N, 2)
        Positions of the particles [px].
    method : {"auto", "exact"}
        How the sum is carried out; "auto" takes the fastest, which so far is the exact sum.
    targets : ndarray of int64, shape (M,), optional
        Indices of the particles whose force is wanted; all of them unless given.

    Returns
    -------
    ndarray, shape (N, 2) or (M, 2)
        ``sum_j (r_i - r_j) / |r_i - r_j|^3``, not normalised. Particles on the very same spot do not act on each other.

    Raises
    ------
    ValueError
        For positions of another shape, or an unknown method.
    """
    points = np.asarray(positions, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"positions have the shape {points.shape} but must be (N, 2).")
    if method not in ("auto", "exact"):
        raise ValueError(f'method is {method!r} but must be "auto" or "exact".')
    wanted = np.arange(len(points)) if targets is None else targets
    force = np.empty((len(wanted), 2))
    columns = np.ascontiguousarray(points.T)
    if len(points) * len(wanted) < _WORTH_A_THREAD**2:
        _exact_sum(columns, wanted, force)
    else:
        middle = len(wanted) // 2
        other = _thread().submit(_exact_sum, columns, wanted[:middle], force[:middle])
        _exact_sum(columns, wanted[middle:], force[middle:])
        other.result()
    return force


@lru_cache(maxsize=1)
def _thread() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=1, thread_name_prefix="coulomb")


@compiled
def _exact_sum(columns: Array, targets: NDArray[np.int64], force: Array) -> None:
    y, x = columns[0], columns[1]
    count = y.size
    for n in range(targets.size):
        i = targets[n]
        y_i, x_i = y[i], x[i]
        f_y, f_x = 0.0, 0.0
        for j in range(count):
            d_y, d_x = y_i - y[j], x_i - x[j]
            squared = d_y * d_y + d_x * d_x
            squared = max(squared, _SAME_SPOT)
            weight = 1.0 / (squared * np.sqrt(squared))
            f_y += weight * d_y
            f_x += weight * d_x
        force[n, 0] = f_y
        force[n, 1] = f_x
