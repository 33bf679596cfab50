"""Placed charges in a volume: their force is computed where particles are, and needs no field of its own.

Lengths are in units of the smallest side of a voxel. `charges`, shape (K, 4), are position and strength of each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cpm_core.field.placed_charges import MOST, RADII, Charges, at_scale, depth, pull, radius_at
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Mask, Single
from cpm_core.numerics.vectors import Vector, difference, dot, length, moved, row_of, scaled

HELD = 0.8
"""Force of charges across an edge that it holds particles against, in units of the Lorentz force away from edges."""

_LEAST_PLANES = 2
"""Planes that are worth a thread."""


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
        if len(placed):
            work = (placed, radius_at(scale), field.pitch)
            share(lambda first, last: _add_forces(*work, first, last, force), force.shape[1], _LEAST_PLANES)
        return force

    def potential(self, field: VolumeField, charges: Charges) -> Array:
        """Potential on the voxels of the volume, shape (P, R, C), with that of the charges; see `ImageFields`."""
        potential, placed = field.potential.copy(), in_units(charges, 0, self.shape, field.pitch)
        if len(placed):
            work = (placed, radius_at(0), field.pitch, field.slope)
            share(lambda first, last: _add_potentials(*work, first, last, potential), len(potential), _LEAST_PLANES)
        return potential


class Placed(NamedTuple):
    """Charges as particles at a scale feel them: position and strength of each, shape (K, 4), and `RADIUS` there."""

    charges: Array
    radius: float


NOTHING_PLACED = Placed(np.zeros((0, 4)), 1.0)
"""No charges."""


def in_units(charges: Charges, scale: int, shape: tuple[int, ...], pitch: Vector) -> Array:
    """Position [units of a scale] and strength of each charge, shape (K, 4)."""
    return at_scale(charges, scale, shape) * (*pitch, 1.0)


def near_charges(charges: Array, radius: float, places: Array) -> Mask:
    """Which places, shape (N, 3), lie within the reach of at least one charge."""
    near = np.zeros(len(places), np.bool_)
    for charge in charges:
        away = places - charge[:3]
        near |= np.einsum("ni,ni->n", away, away) < (RADII * radius) ** 2
    return near


def torn_off(placed: Placed, places: Array, normals: Array) -> Mask:
    """At which places on edges with these normals, shapes (N, 3), charges draw particles off the edge."""
    if not len(placed.charges):
        return np.zeros(len(places), np.bool_)
    across = np.empty(len(places))
    _across(*placed, places, normals, across)
    return np.asarray(np.abs(across) > HELD)


@compiled
def _across(charges: Array, radius: float, places: Array, normals: Array, across: Array) -> None:
    for i in range(len(places)):
        across[i] = dot(placed_at(charges, radius, row_of(places, i)), row_of(normals, i))


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


@compiled
def placed_depth(charges: Array, radius: float, place: Vector) -> float:
    """Potential of charges at a place, whose slope is their force but for the cut of its size."""
    total = 0.0
    for k in range(len(charges)):
        away = scaled(difference(row_of(charges, k), place), 1.0 / radius)
        squared = dot(away, away)
        if squared < RADII**2:
            total -= charges[k, 3] * radius * depth(squared)
    return total


def placed_potential(charges: Array, radius: float, places: Array) -> Array:
    """Potential of charges at places, shape (N, 3); shape (N,)."""
    potential = np.zeros(len(places))
    _depths(charges, radius, places, potential)
    return potential


@compiled
def _depths(charges: Array, radius: float, places: Array, potential: Array) -> None:
    for i in range(len(places)):
        potential[i] = placed_depth(charges, radius, row_of(places, i))


@compiled
def _add_forces(charges: Array, radius: float, pitch: Vector, first: int, last: int, force: Single) -> None:
    for i in range(first, last):
        for j in range(force.shape[2]):
            for k in range(force.shape[3]):
                more = placed_at(charges, radius, (i * pitch[0], j * pitch[1], k * pitch[2]))
                for axis in range(3):
                    force[axis, i, j, k] += more[axis]


@compiled
def _add_potentials(
    charges: Array, radius: float, pitch: Vector, slope: float, first: int, last: int, potential: Array
) -> None:
    for i in range(first, last):
        for j in range(potential.shape[1]):
            for k in range(potential.shape[2]):
                place = (i * pitch[0], j * pitch[1], k * pitch[2])
                potential[i, j, k] += slope * placed_depth(charges, radius, place)
