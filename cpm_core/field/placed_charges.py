"""Charges that the user places in the image, and the force by which they act on the particles.

The fixed charges of the image act by the direction of their field alone: away from edges the Lorentz force has unit
size, however strong the edges. This is the unit for placed charges. At the distance ``d``, in units of `CHARGE_RADIUS`,
a charge of strength ``q`` has the potential of a charge that is softened, and faded out at `CHARGE_REACH`,

    U(d) = -c q RADIUS (1 - (d / 4)^3)^3 / (1 + d^4)^(1/4),

and its force is the slope of it. The potential is flat at the center, so that many particles have room there. The force
is about ``q`` at `CHARGE_RADIUS`, near its maximum, 0.7 q at twice the distance, and 0.3 q at three times. A charge of
one thus pulls at its radius as strongly as edges do, and a charge of two draws particles off edges there. The forces of
several charges add up. Their sum is cut at `MAX_PLACED_FORCE`: beyond it a step would carry particles across edges. It
counts in eq. (12) as a part of the Lorentz force, with the weight w2.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cpm_core.field.scale_field import ScaleField
from cpm_core.image.pyramid import to_scale
from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.real_numbers import as_real_array, check_finite_number
from cpm_core.numerics.types import Array, Extent, Mask, frozen
from cpm_core.numerics.vectors import Vector, dot, move_along, row_of, scale_vector, subtract_vectors, vector_length
from cpm_core.parameters.formatting import quote_value

CHARGE_RADIUS = 16.0
"""Distance at which a charge of one pulls as strongly as the field of the edges [px of the image]."""

CHARGE_REACH_IN_RADII = 4.0
"""Radii beyond which a charge has no effect."""

CHARGE_REACH = CHARGE_REACH_IN_RADII * CHARGE_RADIUS
"""Distance beyond which a charge has no effect [px of the image]."""

MAX_PLACED_FORCE = 4.0
"""Largest size of the sum of the forces of all placed charges, in units of the Lorentz force away from edges."""

MAX_CHARGE_STRENGTH = 10.0
"""Largest strength of a charge, attracting or repelling."""

_PIXELS_PER_WINDOW = 2**16
"""Number of pixels whose forces are computed together."""

_LEFT_AT_RADIUS = 1.0 - CHARGE_REACH_IN_RADII**-3
"""Factor that fading out leaves of the potential at the radius."""

_FORCE_NORM = 1.0 / (9.0 * _LEFT_AT_RADIUS**2 / CHARGE_REACH_IN_RADII**3 * 2.0**-0.25 + _LEFT_AT_RADIUS**3 * 2.0**-1.25)
"""Factor that makes the force of a charge of one equal to one at its radius."""


@frozen
class PlacedCharge:
    """Charge placed by the user.

    Parameters
    ----------
    position : tuple of float
        Row and column, or plane, row and column in a volume [px of the image]; may lie outside it.
    strength : float
        From -10 to 10: above 0 it attracts the particles, below 0 it repels them. A charge of one pulls at the distance
        `CHARGE_RADIUS` as strongly as the edges do.

    Raises
    ------
    ValueError
        For a strength out of range or a position that is not finite.

    Examples
    --------
    >>> cpm.PlacedCharge((32, 50), 1.5)
    PlacedCharge((32.0, 50.0), 1.5)
    >>> pulled = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8), charges=[cpm.PlacedCharge((32, 50), 1.5)])
    >>> pulled.provenance.shapes[0]["strength"]
    1.5
    """

    position: tuple[float, ...]
    strength: float

    def __post_init__(self) -> None:
        try:
            place = as_real_array(self.position)
        except (TypeError, ValueError):
            place = np.zeros(())
        if place.shape not in ((2,), (3,)):
            raise ValueError(
                f"the position of a placed charge is {quote_value(self.position)} but must be a row and a column, "
                "or a plane, a row and a column in a volume."
            )
        if not np.isfinite(place).all():
            numbers = ", ".join(f"{number:g}" for number in place)
            raise ValueError(f"the position of a placed charge is ({numbers}) but must be finite.")
        wanted = f"a number from {-MAX_CHARGE_STRENGTH:g} to {MAX_CHARGE_STRENGTH:g}"
        strength = check_finite_number(
            "the strength of a placed charge", self.strength, lambda number: abs(number) <= MAX_CHARGE_STRENGTH, wanted
        )
        object.__setattr__(self, "position", tuple(place.tolist()))
        object.__setattr__(self, "strength", strength)

    def __repr__(self) -> str:
        return f"PlacedCharge({self.position}, {self.strength})"


Charges = tuple[PlacedCharge, ...]


def sort_charges(charges: Sequence[PlacedCharge]) -> Charges:
    """Sort charges, so that the order in which they were placed does not matter."""
    return tuple(sorted(charges, key=lambda charge: (charge.position, charge.strength)))


def check_charges(charges: Sequence[PlacedCharge], axes: int) -> Charges:
    """Return the charges in order; raise ValueError for a position with another number of axes than the image."""
    for charge in charges:
        if not isinstance(charge, PlacedCharge):
            raise ValueError(f"a charge is {quote_value(charge)} but must be a PlacedCharge.")
        if len(charge.position) != axes:
            wanted, of = ("(plane, row, col)", "a volume") if axes == 3 else ("(row, col)", "an image")
            raise ValueError(f"the position of a placed charge is {charge.position} but must be {wanted} in {of}.")
    return sort_charges(charges)


def changed_charges(before: Charges, after: Charges) -> Charges:
    """Return the charges that are in one of two sets only."""
    one, other = Counter(before), Counter(after)
    return sort_charges([*(one - other).elements(), *(other - one).elements()])


def charges_at_scale(charges: Sequence[PlacedCharge], scale: int, shape: Extent) -> Array:
    """Return position [px of a scale of an image of this shape] and strength of each charge; shape (K, D + 1)."""
    if not charges:
        return np.zeros((0, len(shape) + 1))
    places = to_scale(np.array([charge.position for charge in charges]), scale, shape)
    return np.column_stack([places, [charge.strength for charge in charges]])


def charge_radius_at(scale: int) -> float:
    """Return `CHARGE_RADIUS` at a scale [px of the scale]."""
    return CHARGE_RADIUS * 0.5**scale


def near_charges(charges: Array, radius: float, places: Array) -> Mask:
    """Return a mask, shape (N,), of the places, shape (N, D), within reach of a charge, shape (K, D + 1)."""
    near = np.zeros(len(places), bool)
    for *place, _ in charges:
        near |= ((places - place) ** 2).sum(axis=1) < (CHARGE_REACH_IN_RADII * radius) ** 2
    return near


def windows_near_charges(
    charges: Array, radius: float, shape: Extent, pitch: Sequence[float] = (1.0, 1.0)
) -> Iterator[tuple[tuple[slice, ...], Array]]:
    """Yield windows of an image within reach of charges, and the positions of their pixels, shape (..., D).

    `pitch` are the sides of a pixel. Large windows are divided, so that they take little memory.
    """
    if not len(charges):
        return
    low = np.floor((charges[:, :-1].min(axis=0) - CHARGE_REACH_IN_RADII * radius) / pitch)
    high = np.ceil((charges[:, :-1].max(axis=0) + CHARGE_REACH_IN_RADII * radius) / pitch) + 1
    (first, *low), (last, *high) = (np.clip(end, 0, shape).astype(int).tolist() for end in (low, high))
    lines = max(1, _PIXELS_PER_WINDOW // max(1, int(np.prod(np.subtract(high, low)))))
    for line in range(first, last, lines):
        window = slice(line, min(line + lines, last)), *map(slice, low, high)
        yield window, np.moveaxis(np.mgrid[window], 0, -1) * np.array(pitch)


def placed_forces(charges: Array, radius: float, places: Array) -> Array:
    """Return the force, shape (..., D), of charges at places, in units of the Lorentz force away from edges.

    `charges` holds position and strength of each, shape (K, D + 1), `radius` is `CHARGE_RADIUS`, both in px of the
    scale.
    """
    force = np.zeros(places.shape)
    for *place, strength in charges:
        away = (place - places) / radius
        force += (strength * _charge_force(np.einsum("...i,...i->...", away, away)))[..., None] * away
    size = np.linalg.norm(force, axis=-1, keepdims=True)
    return force * np.minimum(1.0, MAX_PLACED_FORCE / np.maximum(size, 1e-30))


def placed_potential(charges: Array, radius: float, places: Array) -> Array:
    """Return the potential of charges at places, shape (..., D), whose slope is the force; shape (...).

    The unit is px of the scale times the unit of the Lorentz force; below 0 where particles are attracted. The cut of a
    sum of forces does not appear in it.
    """
    potential = np.zeros(places.shape[:-1])
    for *place, strength in charges:
        squared = np.minimum((((place - places) / radius) ** 2).sum(axis=-1), CHARGE_REACH_IN_RADII**2)
        left = 1.0 - squared * np.sqrt(squared) / CHARGE_REACH_IN_RADII**3
        potential -= strength * radius * _FORCE_NORM * left**3 / np.sqrt(np.sqrt(1.0 + squared**2))
    return potential


def _charge_force(squared: Any) -> Any:
    """Return the force of a charge of one at a squared distance, in units of the radius."""
    away = np.sqrt(squared)
    left = np.maximum(1.0 - squared * away / CHARGE_REACH_IN_RADII**3, 0.0)
    soft = 1.0 + squared**2
    return (
        _FORCE_NORM * left**2 / np.sqrt(np.sqrt(soft)) * (9.0 / CHARGE_REACH_IN_RADII**3 * away + left * squared / soft)
    )


charge_force = inlined(_charge_force)
"""`_charge_force` for compiled loops."""


def add_charges(shape: Extent, scale_field: ScaleField, scale: int, charges: Charges) -> ScaleField:
    """Add charges, in px of the image, to the scale field of an image of this shape."""
    packed, radius = scale_field.packed.copy(), charge_radius_at(scale)
    placed = charges_at_scale(charges, scale, shape) - (*scale_field.corner, 0.0)
    for window, places in windows_near_charges(placed, radius, scale_field.shape):
        packed[window][..., :2] += placed_forces(placed, radius, places)
    return replace(scale_field, force=lambda: packed)


HOLDING_FORCE = 0.8
"""Force of charges across an edge that it holds particles against, in units of the Lorentz force away from edges."""


class ChargesAtScale(NamedTuple):
    """Charges as felt at a scale: position and strength of each, shape (K, 4), and `CHARGE_RADIUS` there."""

    charges: Array
    radius: float


NO_PLACED_CHARGES = ChargesAtScale(np.zeros((0, 4)), 1.0)
"""No charges."""


def find_torn_off(placed: ChargesAtScale, places: Array, normals: Array) -> Mask:
    """Return a mask of the places on edges, shape (N, 3), where charges pull particles off; normals of shape (N, 3)."""
    if not len(placed.charges):
        return np.zeros(len(places), bool)
    across = np.einsum("ni,ni->n", placed_forces(*placed, places), normals)
    return np.abs(across) > HOLDING_FORCE


@compiled
def placed_force(charges: Array, radius: float, place: Vector) -> Vector:
    """Return the force of charges, shape (K, 4), at a place, in units of the Lorentz force away from edges."""
    total = (0.0, 0.0, 0.0)
    for k in range(len(charges)):
        away = scale_vector(subtract_vectors(row_of(charges, k), place), 1.0 / radius)
        squared = dot(away, away)
        if squared < CHARGE_REACH_IN_RADII**2:
            total = move_along(total, charges[k, 3] * charge_force(squared), away)
    return scale_vector(total, min(1.0, MAX_PLACED_FORCE / (vector_length(total) + 1e-30)))
