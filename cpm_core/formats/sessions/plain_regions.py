"""Where the particles of a run may be, in an image or in a volume, as plain JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cpm_core.formats.sessions.plain_values import from_plain, mapping, to_plain
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions, Extrusion, Pair, Place, VolumeRegions
from cpm_core.parameters.quotation import shown

_IMAGE, _VOLUME = "regions", "volume_regions"
NAMES = (_IMAGE, _VOLUME)
"""Entries that hold them."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two corners of a box, or a point of a plane and a direction across it."""

    places: tuple[Place, Place]


def regions_to_plain(regions: AnyRegions | None) -> dict[str, Any]:
    """An entry with the limits; none without any."""
    if regions is None:
        return {}
    return {_VOLUME if isinstance(regions, VolumeRegions) else _IMAGE: to_plain(regions)}


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


def _limit(plain: object, where: str) -> Pair | Extrusion:
    """A box or a plane as two places, or a line through slices."""
    if isinstance(plain, Mapping):
        return from_plain(Extrusion, plain, where)
    return from_plain(_Pair, {"places": plain}, where).places
