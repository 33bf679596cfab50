"""Values of a session as plain JSON and back: shapes, parameters, limits of particles, arrays, and frozen dataclasses.

Dataclasses may hold numbers, text, truth values, literals, tuples and dataclasses of them: all that shapes consist of.
Values that are read are checked against the types; one that does not fit raises ValueError with one sentence.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cpm_core.contours.packed_surface import MOST_VOXELS, packed, unpacked
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions, Extrusion, Pair, Place, VolumeRegions, Voxels
from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import shown
from cpm_core.shapes import SHAPES, Shape

T = TypeVar("T")

LARGEST = 1e6
"""Largest absolute value of a number: far outside of any image, and sums of such numbers do not overflow."""

_FARTHEST = 10**6
"""Largest number of a voxel, far outside of any volume."""


def to_plain(value: object) -> Any:
    """A dataclass, or the value of one of its fields, as plain JSON."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple | list):
        return [to_plain(item) for item in value]
    if isinstance(value, bool | str | int) or value is None:
        return value
    return float(value)  # type: ignore[arg-type]  # numbers of NumPy as well


def from_plain(kind: type[T], plain: object, where: str) -> T:
    """A dataclass of type `kind` from a mapping of its fields; those with a default may be missing.

    ValueError when a field is missing, unknown, or not of its type, or the dataclass rejects a value; `where` names the
    dataclass in the sentence, as in ``"shape 3"``.
    """
    plain = mapping(plain, where)
    hints = get_type_hints(kind, include_extras=True)
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    unknown = sorted(str(name) for name in plain if name not in fields)
    if unknown:
        raise ValueError(f"{where} has a value {shown(unknown[0])}, but only {', '.join(fields)} are known.")
    given: dict[str, Any] = {}
    for name, field in fields.items():
        if name in plain:
            given[name] = _value(hints[name], plain[name], f"{name} of {where}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ValueError(f"{where} has no {name}.")
    try:
        return kind(**given)
    except ValueError as error:
        raise ValueError(f"{where} cannot be used: {error}") from error


def shape_to_plain(shape: Shape) -> dict[str, Any]:
    """A shape as plain JSON: its kind and the values of its fields."""
    kind = next(name for name, made in SHAPES.items() if type(shape) is made)
    return {"shape": kind, **to_plain(shape)}


def shape_from_plain(plain: object, where: str) -> Shape:
    """A shape from plain JSON; ValueError when it is not a valid shape."""
    values = dict(mapping(plain, where))
    kind = values.pop("shape", None)
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ValueError(f"{where} is of the kind {shown(kind)} but must be one of {', '.join(SHAPES)}.")
    return from_plain(SHAPES[kind], values, f"{where} ({kind})")


def parameters_from_plain(plain: object) -> tuple[Parameters, tuple[str, ...]]:
    """Parameters from plain JSON, and the names that are unknown.

    Missing parameters have their defaults. ValueError when `plain` is not a mapping, or a value is out of range.
    """
    given = dict(mapping(plain, "parameters"))
    known = {field.name for field in dataclasses.fields(Parameters)}
    values = {name: value for name, value in given.items() if name in known}
    for name, value in values.items():
        if not isinstance(value, str):
            number(value, name, 1e9)
    return Parameters(**values), tuple(sorted(set(given) - known))


def mapping(value: object, where: str) -> Mapping[str, Any]:
    """An object with named values, else ValueError."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} is {shown(value)} but must be an object with named values.")
    return value


def number(value: object, where: str, largest: float = LARGEST) -> float:
    """A finite number that is not too large, else ValueError."""
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= largest:
        return float(value)
    raise ValueError(f"{where} is {shown(value)} but must be a number from {-largest:g} to {largest:g}.")


def items(value: object, where: str = "runs") -> list[Any]:
    """A list, else ValueError."""
    if not isinstance(value, list):
        raise ValueError(f"{where} is {shown(value)} but must be a list.")
    return value


def _value(hint: Any, plain: object, where: str) -> Any:
    origin = get_origin(hint)
    if origin is Annotated:  # a tuple of as many numbers as the annotation allows
        kind, *counts = get_args(hint)
        found = _value(kind, plain, where)
        if len(found) not in counts:
            raise ValueError(f"{where} is {shown(plain)} but must be a list of {' or '.join(map(str, counts))} values.")
        return found
    if origin is tuple:
        hints = get_args(hint)
        listed = items(plain, where)
        if hints[-1] is Ellipsis:
            hints = hints[:1] * len(listed)
        if len(listed) != len(hints):
            raise ValueError(f"{where} is {shown(plain)} but must be a list of {len(hints)} values.")
        return tuple(_value(each, item, where) for each, item in zip(hints, listed, strict=True))
    if origin is Literal:
        if plain not in get_args(hint) or isinstance(plain, bool):
            allowed = ", ".join(shown(item) for item in get_args(hint))
            raise ValueError(f"{where} is {shown(plain)} but must be one of {allowed}.")
        return plain
    if hint is float:
        return number(plain, where)
    if hint is int:
        if number(plain, where) != math.floor(number(plain, where)):
            raise ValueError(f"{where} is {shown(plain)} but must be a whole number.")
        return int(number(plain, where))
    if hint in (str, bool):
        if not isinstance(plain, hint):
            raise ValueError(f"{where} is {shown(plain)} but must be {'text' if hint is str else 'true or false'}.")
        return plain
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return from_plain(hint, plain, where)
    raise TypeError(f"{where} is of the type {hint}, which session files cannot store")


def array_to_plain(array: NDArray[Any]) -> dict[str, Any]:
    """An array of numbers as plain JSON, exactly."""
    return {"shape": list(array.shape), "data": packed(array)}


def array_from_plain(plain: object, dtype: DTypeLike, shape: tuple[int | None, ...], where: str) -> NDArray[Any]:
    """An array of this type and shape, None for any length along an axis; else ValueError, which names `where`."""
    given = mapping(plain, where)
    sides = given.get("shape")
    if not (
        isinstance(sides, list)
        and len(sides) == len(shape)
        and all(type(side) is int and side >= 0 for side in sides)
        and all(wanted in (None, side) for side, wanted in zip(sides, shape, strict=True))
    ):
        wanted = " x ".join("any" if side is None else str(side) for side in shape)
        raise ValueError(f"{where} has the shape {shown(sides)} but must have {wanted} entries.")
    return unpacked(given.get("data"), dtype, math.prod(sides), where).reshape(sides)


_IMAGE, _VOLUME = "regions", "volume_regions"
NAMES = (_IMAGE, _VOLUME)
"""Entries that hold the limits of particles in an image, and in a volume."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two corners of a box, or a point of a plane and a direction across it."""

    places: tuple[Place, Place]


@dataclass(frozen=True, slots=True)
class _Voxel:
    """Index of a voxel, or the number of voxels along each axis."""

    voxel: tuple[int, int, int]


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
        tuple(_limit(one, where) for one in items(kinds.get(kind, []), where)) for kind in ("interest", "barriers")
    )
    return VolumeRegions(interest, barriers)


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
    shape, first = _whole(plain.get("shape"), 1, where), plain.get("first")
    count = math.prod(shape)
    if count > MOST_VOXELS:
        raise ValueError(f"shape of {where} is {shown(shape)} but may be {MOST_VOXELS:,} voxels at most.")
    bits = unpacked(plain["voxels"], np.uint8, -(-count // 8), where)
    mask = np.unpackbits(bits, count=count).reshape(shape).astype(np.bool_)
    return Voxels(mask, None if first is None else _whole(first, -_FARTHEST, where))


def _whole(given: object, low: int, where: str) -> tuple[int, ...]:
    """Three whole numbers, not lower than `low` and not far beyond any volume; else ValueError."""
    numbers = from_plain(_Voxel, {"voxel": given}, where).voxel
    if min(numbers) < low:
        raise ValueError(f"{where} holds {shown(numbers)} but must be whole numbers from {low}.")
    return numbers
