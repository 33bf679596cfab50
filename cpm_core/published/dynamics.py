"""Algorithm 1, part 2: the particles, in the plane and in space by the same lines.

Names are the symbols of the paper. Its text leaves open which particles are neighbors: here two of which no other one
is nearer to their middle; and which of two that are too near is deleted: the newer one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.model.state import Particles
from cpm_core.numerics.types import Array
from cpm_core.numerics.vectors import keep_apart

NEAREST = 0.1
"""Part of the particles, the nearest to each, that the Coulomb force is summed over (section 3.5.1)."""


def advance(
    p: Particles, lorentz: Array, w1: float, w2: float, beta: float, dt: float, d_min: float, d_max_t: float,
    normalize: Callable[[Array], Array], next_identity: int,
) -> tuple[Particles, int, int]:  # fmt: skip
    """Take one step, lines 4 to 7; return the particles, and how many were inserted and deleted.

    `lorentz` is ``F_l`` at the particles, shape (N, D), `normalize` what makes ``F_c`` of the sums of eq. (9).
    """
    F_c = normalize(coulomb_sums(p.position).T).T  # line 4
    F = w1 * F_c + w2 * lorentz  # line 5
    p, F, born, deleted = insert_and_delete(p, F, d_min, d_max_t, next_identity)  # line 6
    return update(p, F, beta, dt), born, deleted  # line 7


def coulomb_sums(r: Array) -> Array:
    """Sum eq. (9) for particles at `r`, shape (N, D), each over the nearest tenth of the others."""
    k = math.ceil(NEAREST * (len(r) - 1))
    if k < 1:
        return np.zeros(r.shape)
    nearest = scipy.spatial.cKDTree(r).query(r, k + 1)  # itself as well, which adds nothing
    distance, j = map(np.asarray, nearest)
    weight = np.divide(1.0, distance * distance * distance, out=np.zeros(distance.shape), where=distance > 0.0)
    return np.stack([x * weight.sum(axis=1) - (weight * x[j]).sum(axis=1) for x in r.T], axis=1)


def insert_and_delete(
    p: Particles, F: Array, d_min: float, d_max_t: float, next_identity: int
) -> tuple[Particles, Array, int, int]:
    """Delete and insert particles, with the force on them, shape (N, D) (section 3.6); return how many were, too.

    One that would be deleted at once is not inserted.
    """
    kept = keep_apart(p.position, 0.5 * d_min)
    p, F = p.keep(kept), F[kept]
    tree = scipy.spatial.cKDTree(p.position)
    i, j = tree.query_pairs(d_min + d_max_t, output_type="ndarray").T
    distance, middle = np.linalg.norm(p.position[i] - p.position[j], axis=1), 0.5 * (p.position[i] + p.position[j])
    free = np.flatnonzero((distance > d_min) & (tree.query(middle)[0] > 0.499 * distance))
    free = free[np.lexsort((j[free], i[free]))]
    free = free[keep_apart(middle[free], 0.5 * d_min)]
    i, j = i[free], j[free]
    new = replace(
        Particles.at_rest(middle[free], next_identity),
        velocity=0.5 * (p.velocity[i] + p.velocity[j]),
        force=0.5 * (p.force[i] + p.force[j]),
    )
    return p.append(new), np.concatenate([F, 0.5 * (F[i] + F[j])]), len(new), int((~kept).sum())


def update(p: Particles, F: Array, beta: float, dt: float) -> Particles:
    """Advance the particles by eq. (12) to (15), without damping force `F`, shape (N, D)."""
    r, v = p.position, p.velocity
    a = F - beta * v  # eq. (12)
    a_1, a_2 = p.force[:, 0], p.force[:, 1]  # at the last two steps
    da_dt = (3.0 * a - 4.0 * a_1 + a_2) / (2.0 * dt)  # eq. (15)
    return replace(
        p,
        position=r + dt * v + dt**2 / 2.0 * a + dt**3 / 6.0 * da_dt,  # eq. (14)
        velocity=v + dt * a + dt**2 / 2.0 * da_dt,
        force=np.stack([a, a_1], axis=1),
        distance=np.column_stack([np.linalg.norm(r, axis=1), p.distance[:, :-1]]),
    )


def convergence(distance: Array) -> float:
    """Return epsilon of eq. (23) [px] from ``|r|`` at the last T steps, newest first, shape (N, T).

    It asks for all particles at all of these steps: NaN while one is younger, so that no run ends while it inserts.
    """
    signs = (-1.0) ** np.arange(1, distance.shape[1] + 1)
    return abs(float((signs * distance).sum())) / len(distance)
