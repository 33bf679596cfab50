"""The Coulomb force of eq. (9), by the fastest method.

The number of targets M decides on the method, since the time of all methods is also proportional to N. Measured on two
cores with particles 1.5 px apart along circles: a pair takes 0.31 ns in double and 0.14 ns in single precision, and a
particle 300 to 400 ns by the tree. Up to 400 targets it does not pay to test on a sample whether single precision is
enough; from 1500 on the tree is faster than sums in single precision.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.real_numbers import checked_number, real_numbers
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters.quotation import shown
from cpm_core.particles.coulomb.direct_sum import pair_sums, usual_force
from cpm_core.particles.coulomb.fast_multipole import tree_force
from cpm_core.particles.coulomb.space import space_sums
from cpm_core.particles.coulomb.space_tree import space_tree_sums

METHODS = ("auto", "exact", "single", "tree")

_WORTH_A_SAMPLE = 400
"""Targets from which a test of single precision on a sample pays: at 400, 115 us against 122 us."""

_WORTH_A_TREE = 1500
"""Targets from which on the tree is faster than single precision: at 1200, 0.58 ms against 0.44 + 0.08 ms, at 1600,
0.69 ms against 0.76 + 0.08 ms, on one core; on two, all of these take half."""

_WORTH_A_TREE_IN_SPACE = 5000
"""Targets in space from which on the tree is faster than all pairs: at 4000, 29 ms against 25 to 52 ms of processor
time, at 8000, 109 ms against 52 to 95 ms, at 25,000, 870 ms against 140 to 290 ms."""


def coulomb_force(
    positions: ArrayLike, method: str = "auto", targets: ArrayLike | None = None, tolerance: float = 1e-3
) -> Array:
    """Coulomb force on every particle from all the others, eq. (9) with unit charges.

    Parameters
    ----------
    positions : array_like, shape (N, 2) or (N, 3)
        Positions of the particles [px].
    method : {"auto", "exact", "single", "tree"}
        How the sum is computed. "exact": pair by pair in double precision. "single": pair by pair, distances in double
        precision and the rest in single precision, in half the time; the error of each pair is 2e-7 of its force.
        "tree": by a fast multipole method, whose time grows in proportion to N, in space with N log N. "auto": the
        fastest of these that keeps the tolerance. In space "single" has double precision.
    targets : array_like of int, shape (M,), optional
        Indices of the particles whose force is computed; by default all of them.
    tolerance : float
        Relative error that "auto" and "tree" may make: root of the sum of the squared errors of all particles over
        that of their forces. From 1e-12 to 0.1.

    Returns
    -------
    ndarray, shape (N, D) or (M, D)
        ``sum_j (r_i - r_j) / |r_i - r_j|^3``, not normalized. Particles at the same position do not act on each other;
        this includes particles nearer to each other than 1e-18 of the extent of all.

    Raises
    ------
    ValueError
        For positions of another shape, that are no finite numbers, or whose forces would be none, an unknown method,
        targets that are no particles, or a tolerance out of range.

    Examples
    --------
    >>> cpm.coulomb_force(np.array([(0.0, 0.0), (0.0, 2.0)])).round(3).tolist()
    [[0.0, -0.25], [0.0, 0.25]]
    """
    points = real_numbers(positions)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ValueError(f"positions have the shape {points.shape} but must be (N, 2) or (N, 3).")
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method is {shown(method)} but must be one of {', '.join(METHODS)}.")
    checked_number("tolerance", tolerance, lambda error: 1e-12 <= error <= 0.1, "from 1e-12 to 0.1")
    wanted = None if targets is None else _checked(targets, len(points))
    if not len(points):
        return np.zeros((0, points.shape[1]))
    unit, scale = _in_unit_of_extent(points)
    force = (_unit_force_in_space if points.shape[1] == 3 else _unit_force)(unit, method, wanted, tolerance)
    return _in_pixels(force, scale)


def _in_unit_of_extent(points: Array) -> tuple[Array, float]:
    """Positions in a unit of length in which the extent of the particles is about one, and that unit, exactly."""
    with np.errstate(over="ignore", invalid="ignore"):
        sides = points.max(axis=0) - points.min(axis=0)
    if not np.isfinite(sides.sum()):
        raise ValueError("positions must be finite numbers; there are others among them, or they lie too far apart.")
    extent = float(sides.max())
    scale = float(2.0 ** np.floor(np.log2(extent))) if extent > 0.0 else 1.0
    return points / scale, scale


def _in_pixels(force: Array, scale: float) -> Array:
    """Force between positions in a unit of length as that between the positions themselves; `force` is changed."""
    with np.errstate(over="ignore"):
        force /= scale
        force /= scale
    if not np.isfinite(force).all():
        raise ValueError(
            f"positions lie within {scale:.2g} px, so near to each other that forces have no number: give them in "
            "another unit."
        )
    return force


def _unit_force_in_space(points: Array, method: str, wanted: Index | None, tolerance: float) -> Array:
    """Force on some particles of a unit cube, or on all of them."""
    targets = np.arange(len(points)) if wanted is None else wanted
    if method == "tree" or (method == "auto" and len(targets) > _WORTH_A_TREE_IN_SPACE):
        return space_tree_sums(points, tolerance, targets)
    return space_sums(points, targets)


def _unit_force(points: Array, method: str, wanted: Index | None, tolerance: float) -> Array:
    """Force on some particles of the unit square, or on all of them."""
    y, x = points[:, 0].copy(), points[:, 1].copy()
    count = len(y) if wanted is None else len(wanted)
    single = method == "single"
    if method == "tree" or (method == "auto" and count > _WORTH_A_TREE):
        return tree_force(y, x, tolerance, wanted)
    if method == "auto" and count > _WORTH_A_SAMPLE:
        single = usual_force(y, x, tolerance)[1]
    return pair_sums(y, x, np.arange(len(y)) if wanted is None else wanted, single)


def _checked(targets: ArrayLike, count: int) -> Index:
    indices = np.asarray(targets)
    if indices.ndim != 1 or (indices.size and indices.dtype.kind not in "iu"):
        raise ValueError(f"targets must be a list of indices, not {indices.dtype} of the shape {indices.shape}.")
    if indices.size and not (indices.min() >= 0 and indices.max() < count):
        raise ValueError(
            f"targets go from {indices.min()} to {indices.max()} but must be indices of the {count} particles."
        )
    return indices.astype(np.int64, copy=False)
