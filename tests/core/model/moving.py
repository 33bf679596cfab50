"""Scale fields made by hand, and the force of eq. (12) in double precision: the truth for the tests of the kernels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core import Parameters
from cpm_core.field.scale_field import ScaleField
from cpm_core.model.plane.births import EdgeContact
from cpm_core.model.plane.motion import edge_contact_at
from cpm_core.model.plane.repulsion import build_plane_cells

Array = NDArray[np.float64]

NEIGHBOR_RANGE = 8.0
"""Largest distance to a neighbor, in d_min + d_max."""


def edge_contact(positions: Array, scale_field: ScaleField, distance: float) -> EdgeContact:
    """Edge contact of particles, with neighbors up to a distance."""
    return EdgeContact(
        *edge_contact_at(positions, scale_field), build_plane_cells(positions, scale_field.shape, distance)
    )


def even_scale_field(
    shape: tuple[int, ...],
    lorentz: tuple[float, ...],
    normal: tuple[float, ...] | None = None,
    strength: float = 0.0,
    floor: float = 1.0,
) -> ScaleField:
    """A scale field on which the Lorentz force, the gradient and the edge strength are the same everywhere."""
    dimension = len(shape)
    normal = normal or dimension * (0.0,)
    packed = np.zeros((*shape, 2 * dimension + 1), np.float32)
    packed[..., :dimension], packed[..., dimension:-1], packed[..., -1] = lorentz, normal, strength
    return ScaleField(
        force=lambda: packed,
        slopes=lambda _: np.broadcast_to(np.reshape(normal, (-1, *(dimension * (1,)))), (dimension, *shape)),
        edge_map=np.full(shape, strength),
        values=np.zeros(shape),
        strongest=max(strength, 1.0),
        fixed_charges=np.full(shape, strength),
        floor=floor,
        holding=0.0,
        smoothing=1.0,
    )


def cloud(shape: tuple[int, ...], count: int, seed: int) -> Array:
    """Particles anywhere on an image of this shape."""
    return np.random.default_rng(seed).uniform(-0.5, np.array(shape) - 0.5, (count, len(shape)))


def crowds(shape: tuple[int, ...], seed: int) -> Array:
    """Particles anywhere on an image, some of them close together and some on the same spot, in multiples of 1/8 px."""
    rng = np.random.default_rng(seed)
    heap = rng.uniform(5.0, 9.0, (rng.integers(0, 20), len(shape)))
    points = np.concatenate([cloud(shape, int(rng.integers(0, 25)), seed), heap])
    return np.concatenate([np.round(8.0 * points) / 8.0, np.round(8.0 * heap[:3]) / 8.0])


def offsets(points: Array) -> tuple[Array, Array]:
    """Vectors between all pairs, and their lengths; infinite for particles at the same position."""
    apart = points[:, None] - points
    distance = np.linalg.norm(apart, axis=-1)
    distance[distance == 0.0] = np.inf
    return apart, distance


def coulomb(points: Array) -> Array:
    """Eq. (9)."""
    apart, distance = offsets(points)
    return np.asarray((apart / distance[..., None] ** 3).sum(axis=1))


def spacing(points: Array, parameters: Parameters) -> Array:
    """Mean distance to the two nearest."""
    _, distance = offsets(points)
    farthest = NEIGHBOR_RANGE * (parameters.d_min + parameters.d_max)
    nearest = np.sort(np.concatenate([distance, np.full((len(points), 2), np.inf)], axis=1), axis=1)[:, :2]
    return np.asarray(np.minimum(nearest, farthest).mean(axis=1))


def repulsion(points: Array, parameters: Parameters) -> Array:
    """Coulomb force scaled by half the squared spacing, less below d_min, and cut at one."""
    apart = spacing(points, parameters)
    scaled = coulomb(points) * (0.5 * apart**2 * np.minimum(1.0, apart / parameters.d_min))[:, None]
    return np.asarray(scaled / np.maximum(1.0, np.linalg.norm(scaled, axis=1))[:, None])
