"""A level as it is felt with placed charges.

Their force is added to the Lorentz force on the pixels, around each of them alone. A run copies what it feels once, and
when charges are dragged writes anew what they leave and what they reach; it may have no more than a thousandth of a
second for it. Each thread has a copy of its own, so that nobody sees one half written.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from threading import local

import numpy as np

from cpm_core.field.placed_charges import Charges, at_scale, box_of, changed, placed_force, placed_potential, radius_at
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Array


@dataclass(frozen=True, eq=False, slots=True)
class _Kept:
    """The last level with charges, without them, and what they were."""

    plain: ScaleField
    charged: ScaleField
    charges: Charges


class PlacedChargeCache:
    """Levels with placed charges, for a thread the one that it has last asked for.

    Parameters
    ----------
    shape : tuple of int
        Shape of the image.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._shape = shape
        self._local = local()

    def of(self, scale_field: ScaleField, scale: int, charges: Charges) -> ScaleField:
        """A level with charges; what has been returned to this thread before is no longer valid.

        Parameters
        ----------
        scale_field : ScaleField
            Without charges.
        scale : int
            Of the level.
        charges : tuple of PlacedCharge
            In px of the image.

        Returns
        -------
        ScaleField
            The level itself when there are no charges.
        """
        if not charges:
            self._local.kept = None
            return scale_field
        kept: _Kept | None = getattr(self._local, "kept", None)
        if kept is None or kept.plain is not scale_field:
            kept = _Kept(scale_field, replace(scale_field, packed=scale_field.packed.copy()), ())
        dirty = changed(kept.charges, charges)
        if dirty:
            radius = radius_at(scale)
            box = box_of(at_scale(dirty, scale, self._shape), radius, scale_field.shape)
            force = placed_force(at_scale(charges, scale, self._shape), radius, box)
            window = (slice(*box[:2]), slice(*box[2:]), slice(2))
            kept.charged.packed[window] = scale_field.packed[window] + force
            kept = replace(kept, charges=charges)
        self._local.kept = kept
        return kept.charged


def charged_force(scale_field: ScaleField, charges: Array, scale: int) -> Array:
    """Lorentz force on the pixels of a level with that of charges, shapes (K, 3) and (2, H, W)."""
    force = scale_field.lorentz.astype(float)
    if len(charges):
        box = box_of(charges, radius_at(scale), scale_field.shape)
        force[:, slice(*box[:2]), slice(*box[2:])] += np.moveaxis(placed_force(charges, radius_at(scale), box), -1, 0)
    return force


def charged_potential(scale_field: ScaleField, charges: Array) -> Array:
    """Potential on the pixels of the image with that of charges, shapes (K, 3) and (H, W); see `Engine.potential`."""
    potential = scale_field.potential.copy()
    for number in range(len(charges)):
        charge = charges[number : number + 1]
        top, bottom, left, right = box_of(charge, radius_at(0), scale_field.shape)
        places = np.mgrid[top:bottom, left:right].reshape(2, -1).T
        placed = placed_potential(charge, radius_at(0), places).reshape(bottom - top, right - left)
        potential[top:bottom, left:right] += scale_field.slope * placed
    return potential
