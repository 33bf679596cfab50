"""The Coulomb force, beside a bare loop over all pairs."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import log

import numpy as np

from cpm_core.model.coulomb import coulomb_force
from cpm_core.numerics.jit import reordered
from cpm_core.numerics.types import Array
from tests.benchmarks.speed.measurement import Measurement, Patience, milliseconds_of
from tests.benchmarks.speed.scenes import along_curves

_COUNTS = (1_000, 4_000, 16_000, 64_000, 256_000)
_MOST_PAIRS = 16_000
"""Largest number of particles for the loop over all pairs."""

_PLACES = 50
"""Particles at which the force is compared with the direct sum."""


def coulomb_forces(patience: Patience) -> Iterator[Measurement]:
    """The force on numbers of particles that quadruple from row to row."""
    _compile_loops()
    before: tuple[int, float] | None = None
    for count in (500, 2_000) if patience.quick else _COUNTS:
        points = along_curves(count)
        works = [partial(coulomb_force, points)] + ([partial(all_pairs, points)] if count <= _MOST_PAIRS else [])
        ours, *pairs = milliseconds_of(patience, *works)
        growth = None if before is None else log(ours / before[1]) / log(len(points) / before[0])
        before = len(points), ours
        yield Measurement(
            "coulomb",
            f"Coulomb force, {len(points)} particles",
            ours,
            "ms",
            "loop over all pairs, 1 core" if pairs else None,
            pairs[0] if pairs else None,
            coulomb_error(points, coulomb_force(points)),
            growth,
        )


def _compile_loops() -> None:
    """Compile the loops of every method, some of which no run needs, before times are taken."""
    points = along_curves(400)
    for method in ("exact", "tree"):
        coulomb_force(points, method)
    all_pairs(points)


def all_pairs(points: Array) -> Array:
    """Force (N, 2) on points (N, 2) by eq. (9) literally, in one loop over all pairs on one core."""
    row, col = np.ascontiguousarray(points.T)
    force = np.empty((2, len(points)))
    _all_pairs(row, col, force)
    return force.T


@reordered
def _all_pairs(row: Array, col: Array, force: Array) -> None:
    for i in range(row.size):
        down, right = 0.0, 0.0
        for j in range(row.size):
            r, c = row[i] - row[j], col[i] - col[j]
            squared = max(r * r + c * c, 1e-60)
            weight = 1.0 / (squared * np.sqrt(squared))
            down += weight * r
            right += weight * c
        force[0, i] = down
        force[1, i] = right


def coulomb_error(points: Array, force: Array) -> float:
    """Root of the mean squared error of a force at some particles, as a fraction of that of the direct sum there."""
    wrong, size = 0.0, 0.0
    for i in np.random.default_rng(0).integers(0, len(points), _PLACES):
        apart = points[i] - points
        cube = np.hypot(apart[:, 0], apart[:, 1]) ** 3
        cube[cube == 0.0] = np.inf
        exact = (apart / cube[:, None]).sum(axis=0)
        wrong += float(((force[i] - exact) ** 2).sum())
        size += float((exact**2).sum())
    return float(np.sqrt(wrong / size))
