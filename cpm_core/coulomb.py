"""The Coulomb force between the free particles, eq. (9)."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.kernels import compiled

Array = NDArray[np.float64]
Real = np.floating[Any]
Reals = NDArray[Real]

_WORTH_A_THREAD = 600
"""Particles from which on two threads finish earlier than one."""

_SAME_SPOT = {np.float32: 1e-10, np.float64: 1e-60}
"""Squared distance below which two particles stand on the same spot; a bound instead of a branch keeps the loop on
vector registers, and a pair on one spot adds its vanishing distance, which is nothing."""


def coulomb_force(positions: ArrayLike, method: str = "auto", targets: NDArray[np.int64] | None = None) -> Array:
    """Coulomb force on every particle from all the others, eq. (9) with unit charges.

    Parameters
    ----------
    positions : array_like, shape (N, 2)
        Positions of the particles [px].
    method : {"auto", "exact", "single"}
        How the sum is carried out: "exact" in double precision; "single" in single precision, about four times as
        fast, with a relative error around 1e-5 for positions below some thousand px. "auto" is "exact".
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
    if method not in ("auto", "exact", "single"):
        raise ValueError(f'method is {method!r} but must be "auto", "exact" or "single".')
    wanted = np.arange(len(points)) if targets is None else targets
    precision = np.float32 if method == "single" else np.float64
    columns: Reals = np.ascontiguousarray(
        (points - points.mean(axis=0)).T if len(points) else points.T, dtype=precision
    )
    one, tiny = precision(1.0), precision(_SAME_SPOT[precision])
    force = np.empty((len(wanted), 2), dtype=precision)
    if len(points) * len(wanted) < _WORTH_A_THREAD**2:
        _pair_sum(columns, one, tiny, wanted, force)
    else:
        middle = len(wanted) // 2
        other = _thread().submit(_pair_sum, columns, one, tiny, wanted[:middle], force[:middle])
        _pair_sum(columns, one, tiny, wanted[middle:], force[middle:])
        other.result()
    return force.astype(np.float64, copy=False)


@lru_cache(maxsize=1)
def _thread() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=1, thread_name_prefix="coulomb")


@compiled
def _pair_sum(columns: Reals, one: Real, tiny: Real, targets: NDArray[np.int64], force: Reals) -> None:
    """Sum eq. (9) for some targets, in the precision of all its arguments alike."""
    y, x = columns[0], columns[1]
    for n in range(targets.size):
        y_i, x_i = y[targets[n]], x[targets[n]]
        f_y, f_x = one - one, one - one
        for j in range(y.size):
            d_y, d_x = y_i - y[j], x_i - x[j]
            squared = max(d_y * d_y + d_x * d_x, tiny)
            weight = one / (squared * np.sqrt(squared))
            f_y += weight * d_y
            f_x += weight * d_x
        force[n, 0] = f_y
        force[n, 1] = f_x
