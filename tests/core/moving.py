"""Hand-made levels and the force of eq. (12) in double precision: what one compiled step is measured against."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core import Parameters
from cpm_core.dynamics.edge_contact import EdgeContact, contact_at
from cpm_core.field.scale_field import ScaleField
from cpm_core.particles.cell_list import build_cells

Array = NDArray[np.float64]

LONELY = 8.0
"""Distance to anybody that counts at most, in d_min + d_max."""


def survey(positions: Array, scale_field: ScaleField, distance: float) -> EdgeContact:
    """How particles stand, with neighbours up to a distance."""
    return EdgeContact(*contact_at(positions, scale_field), build_cells(positions, *scale_field.shape, distance))


def even_scale_field(
    shape: tuple[int, int],
    lorentz: tuple[float, float],
    normal: tuple[float, float] = (0.0, 0.0),
    strength: float = 0.0,
    floor: float = 1.0,
) -> ScaleField:
    """A level on which the Lorentz force, the gradient and the edge strength are the same everywhere."""
    packed = np.zeros((*shape, 5), np.float32)
    packed[..., :2], packed[..., 2:4], packed[..., 4] = lorentz, normal, strength
    return ScaleField(
        packed=packed,
        gradient=np.broadcast_to(np.array(normal)[:, None, None], (2, *shape)),
        edge_map=np.full(shape, strength),
        values=np.zeros(shape),
        strongest=max(strength, 1.0),
        fixed_charges=np.full(shape, strength),
        floor=floor,
        smoothing=1.0,
    )


def offsets(points: Array) -> tuple[Array, Array]:
    """Vectors between all pairs, and their lengths; infinite for particles on the very same spot."""
    apart = points[:, None] - points
    distance = np.hypot(apart[..., 0], apart[..., 1])
    distance[distance == 0.0] = np.inf
    return apart, distance


def coulomb(points: Array) -> Array:
    """Eq. (9)."""
    apart, distance = offsets(points)
    return np.asarray((apart / distance[..., None] ** 3).sum(axis=1))


def spacing(points: Array, parameters: Parameters) -> Array:
    """Mean distance to the two nearest."""
    _, distance = offsets(points)
    lonely = LONELY * (parameters.d_min + parameters.d_max)
    nearest = np.sort(np.concatenate([distance, np.full((len(points), 2), np.inf)], axis=1), axis=1)[:, :2]
    return np.asarray(np.minimum(nearest, lonely).mean(axis=1))


def repulsion(points: Array, parameters: Parameters) -> Array:
    """Coulomb force scaled by half the squared spacing, less below d_min, and cut at one."""
    apart = spacing(points, parameters)
    scaled = coulomb(points) * (0.5 * apart**2 * np.minimum(1.0, apart / parameters.d_min))[:, None]
    return np.asarray(scaled / np.maximum(1.0, np.hypot(*scaled.T))[:, None])
