"""Where the particles of a run may be, in an image or in a volume, as plain JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cpm_core.contours.packed_surface import MOST_VOXELS, packed, unpacked
from cpm_core.formats.sessions.plain_values import from_plain, mapping, to_plain
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions, Extrusion, Pair, Place, VolumeRegions, Voxels
from cpm_core.parameters.quotation import shown

_IMAGE, _VOLUME = "regions", "volume_regions"
NAMES = (_IMAGE, _VOLUME)
"""Entries that hold them."""

_FARTHEST = 10**6
"""Largest number of a voxel, far outside of any volume."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two corners of a box, or a point of a plane and a direction across it."""

    places: tuple[Place, Place]


def regions_to_plain(regions: AnyRegions | None) -> dict[str, Any]:
    """An entry with the limits; none without any."""
    if regions is None:
        return {}
    if not isinstance(regions, VolumeRegions):
        return {_IMAGE: to_plain(regions)}
    kinds = {"interest": regions.interest, "barriers": regions.barriers}
    return {_VOLUME: {kind: [_limit_to_plain(limit) for limit in limits] for kind, limits in kinds.items()}}


def regions_from_plain(plain: Mapping[str, Any], where: str) -> AnyRegions | None:
    """The limits in an entry, None for no limits; ValueError when they cannot be any."""
    if _IMAGE in plain:
        return from_plain(Regions, plain[_IMAGE], where)
    if _VOLUME not in plain:
        return None
    kinds = mapping(plain[_VOLUME], where)
    interest, barriers = (
        tuple(_limit(one, where) for one in items(kinds.get(kind, []))) for kind in ("interest", "barriers")
    )
    return VolumeRegions(interest, barriers)


def items(plain: object) -> list[Any]:
    """A list, else ValueError."""
    if not isinstance(plain, list):
        raise ValueError(f"{shown(plain)} must be a list.")
    return plain


def _limit_to_plain(limit: Pair | Extrusion | Voxels) -> Any:
    if not isinstance(limit, Voxels):
        return to_plain(limit)
    first = None if limit.first is None else list(limit.first)
    return {"first": first, "shape": list(limit.mask.shape), "voxels": packed(np.packbits(limit.mask))}


def _limit(plain: object, where: str) -> Pair | Extrusion | Voxels:
    """A box or a plane as two places, a line through slices, or voxels."""
    if isinstance(plain, Mapping):
        return _voxels(plain, where) if "voxels" in plain else from_plain(Extrusion, plain, where)
    return from_plain(_Pair, {"places": plain}, where).places


def _voxels(plain: Mapping[str, Any], where: str) -> Voxels:
    """Voxels of a box, eight in a byte."""
    shape = _whole(plain.get("shape"), 1, f"shape of {where}")
    first = None if plain.get("first") is None else _whole(plain["first"], -_FARTHEST, f"first of {where}")
    count = math.prod(shape)
    if count > MOST_VOXELS:
        raise ValueError(f"shape of {where} is {shown(shape)} but may be {MOST_VOXELS:,} voxels at most.")
    bits = unpacked(plain["voxels"], np.uint8, -(-count // 8), where)
    return Voxels(np.unpackbits(bits, count=count).reshape(shape).astype(np.bool_), first)


def _whole(given: object, low: int, where: str) -> tuple[int, ...]:
    """Three whole numbers, not lower than `low` and not far beyond any volume; else ValueError."""
    if isinstance(given, list) and len(given) == 3:
        numbers = tuple(one for one in given if type(one) is int and low <= one <= _FARTHEST)
        if len(numbers) == len(given):
            return numbers
    raise ValueError(f"{where} is {shown(given)} but must be three whole numbers from {low} to {_FARTHEST}.")
