"""Scale fields with placed charges.

Their force is added to the Lorentz force on the pixels within their reach. A run copies the packed force field once;
when charges are dragged, it writes only the pixels around their old and new positions, which may take no more than a
millisecond. Each thread has its own copy, so that none reads a field that is partly written.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from threading import local

import numpy as np

from cpm_core.field.placed_charges import Charges, at_scale, box_of, changed, placed_force, placed_potential, radius_at
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Array


@dataclass(frozen=True, eq=False, slots=True)
class _Kept:
    """The last scale field, without and with charges, and the charges."""

    plain: ScaleField
    charged: ScaleField
    charges: Charges


class PlacedChargeCache:
    """Scale fields of an image of this shape with placed charges; for each thread, the last one it has used is kept."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._shape = shape
        self._local = local()

    def of(self, scale_field: ScaleField, scale: int, charges: Charges) -> ScaleField:
        """Scale field of a scale with charges, in px of the image; the field itself when there are none.

        What this thread has received before is no longer valid.
        """
        if not charges:
            self._local.kept = None
            return scale_field
        kept: _Kept | None = getattr(self._local, "kept", None)
        if kept is None or kept.plain is not scale_field:
            kept = _Kept(scale_field, replace(scale_field, force=cache(scale_field.packed.copy)), ())
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

    def force(self, scale_field: ScaleField, scale: int, charges: Charges) -> Array:
        """Lorentz force on the pixels of a scale, shape (2, H, W), with that of charges."""
        force, placed = scale_field.lorentz.astype(float), at_scale(charges, scale, self._shape)
        if len(placed):
            box = box_of(placed, radius_at(scale), scale_field.shape)
            more = placed_force(placed, radius_at(scale), box)
            force[:, slice(*box[:2]), slice(*box[2:])] += np.moveaxis(more, -1, 0)
        return force

    def potential(self, scale_field: ScaleField, charges: Charges) -> Array:
        """Potential on the pixels of the image, shape (H, W), with that of charges; see `ImageFields`."""
        potential, placed = scale_field.potential.copy(), at_scale(charges, 0, self._shape)
        for number in range(len(placed)):
            charge = placed[number : number + 1]
            top, bottom, left, right = box_of(charge, radius_at(0), scale_field.shape)
            places = np.mgrid[top:bottom, left:right].reshape(2, -1).T
            well = placed_potential(charge, radius_at(0), places).reshape(bottom - top, right - left)
            potential[top:bottom, left:right] += scale_field.slope * well
        return potential
