"""A scale field in which only some edges attract and hold particles."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

import numpy as np
import scipy

from cpm_core.field.scale_field import ScaleField, least_strength, packed_force
from cpm_core.numerics.types import Mask

_FULL, _GONE = 1.5, 3.0
"""Distances from the ridge of an edge up to which its strength is kept, and from which nothing is left [px]; between
them it is tapered, so that no new ridge arises."""

_ALONG = 2.0
"""Distance from the ridge up to which a contour may run [px]."""


def limited_to(scale_field: ScaleField, ridge: Mask) -> ScaleField:
    """The same field with the fixed charges and the edges around some pixels only.

    `ridge`, shape (H, W), are the pixels of the ridges that stay. The largest edge strength, and the least one for edge
    contact, are those of the edges that stay.
    """
    away = scipy.ndimage.distance_transform_edt(~ridge) if ridge.any() else np.full(ridge.shape, np.inf)
    kept = np.clip((_GONE - away) / (_GONE - _FULL), 0.0, 1.0).astype(scale_field.edge_map.dtype, copy=False)
    strength = scale_field.edge_map * kept
    same = scale_field.fixed_charges is scale_field.edge_map
    charged = strength if same else scale_field.fixed_charges * kept
    strongest = float(strength.max(initial=0.0))
    made_of = charged, scale_field.gradient, strength, strongest, scale_field.exponent
    return replace(
        scale_field,
        force=cache(partial(packed_force, *made_of)),
        edge_map=strength,
        strongest=strongest,
        fixed_charges=charged,
        floor=min(scale_field.floor, least_strength(strongest)),
        reached=away <= _ALONG,
    )
