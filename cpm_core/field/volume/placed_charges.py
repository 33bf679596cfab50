"""Placed charges in a volume: their force is computed where particles are, and needs no field of its own.

Lengths are in units of the smallest side of a voxel. `charges`, shape (K, 4), are position and strength of each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cpm_core.field.placed_charges import (
    MOST,
    RADII,
    Charges,
    at_scale,
    placed_force_at,
    placed_potential,
    pull,
    radius_at,
)
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask, Single
from cpm_core.numerics.vectors import Vector, difference, dot, length, moved, row_of, scaled

HELD = 0.8
"""Force of charges across an edge that it holds particles against, in units of the Lorentz force away from edges."""


@dataclass(frozen=True, eq=False, slots=True)
class VolumeCharges:
    """What placed charges change in the fields of a volume of this shape; it has the methods of `PlacedChargeCache`."""

    shape: tuple[int, ...]

    def of(self, field: VolumeField, _scale: int, _charges: Charges) -> VolumeField:
        """The field itself: particles feel the charges directly."""
        return field

    def force(self, field: VolumeField, scale: int, charges: Charges) -> Single:
        """Lorentz force on the voxels of a scale, shape (3, P, R, C), with that of the charges."""
        force, placed = field.lorentz, in_units(charges, scale, self.shape, field.pitch)
        for plane in range(force.shape[1] if len(placed) else 0):
            places = _places(plane, force.shape[2:], field.pitch)
            force[:, plane] += np.moveaxis(placed_force_at(placed, radius_at(scale), places), -1, 0)
        return force

    def potential(self, field: VolumeField, charges: Charges) -> Array:
        """Potential on the voxels of the volume, shape (P, R, C), with that of the charges; see `ImageFields`."""
        potential, placed = field.potential.copy(), in_units(charges, 0, self.shape, field.pitch)
        for plane in range(len(potential) if len(placed) else 0):
            places = _places(plane, potential.shape[1:], field.pitch)
            potential[plane] += field.slope * placed_potential(placed, radius_at(0), places)
        return potential


def _places(plane: int, shape: tuple[int, ...], pitch: Vector) -> Array:
    """Positions [units] of the voxels of a plane, shape (R, C, 3)."""
    rows, cols = np.indices(shape)
    return np.asarray(np.stack([np.full(shape, plane), rows, cols], axis=-1) * np.array(pitch))


class Placed(NamedTuple):
    """Charges as particles at a scale feel them: position and strength of each, shape (K, 4), and `RADIUS` there."""

    charges: Array
    radius: float


NOTHING_PLACED = Placed(np.zeros((0, 4)), 1.0)
"""No charges."""


def in_units(charges: Charges, scale: int, shape: tuple[int, ...], pitch: Vector) -> Array:
    """Position [units of a scale] and strength of each charge, shape (K, 4)."""
    return at_scale(charges, scale, shape) * (*pitch, 1.0)


def torn_off(placed: Placed, places: Array, normals: Array) -> Mask:
    """At which places on edges with these normals, shapes (N, 3), charges draw particles off the edge."""
    if not len(placed.charges):
        return np.zeros(len(places), np.bool_)
    across = np.einsum("ni,ni->n", placed_force_at(*placed, places), normals)
    return np.asarray(np.abs(across) > HELD)


@compiled
def placed_at(charges: Array, radius: float, place: Vector) -> Vector:
    """Force of charges at a place, in units of the Lorentz force away from edges."""
    total = (0.0, 0.0, 0.0)
    for k in range(len(charges)):
        away = scaled(difference(row_of(charges, k), place), 1.0 / radius)
        squared = dot(away, away)
        if squared < RADII**2:
            total = moved(total, charges[k, 3] * pull(squared), away)
    return scaled(total, min(1.0, MOST / (length(total) + 1e-30)))
