"""Values as JSON and back: frozen dataclasses by the types of their fields, arrays, shapes, limits, parameters.

Dataclasses may hold numbers, text, bytes, booleans, literals, voxels, tuples and dataclasses, or a union of these.
Values are checked against the types when they are read; a mismatch raises ValueError with a one-sentence message.
Arrays and bytes are compressed and written as text; they are checked before they are decompressed.
"""

from __future__ import annotations

import base64
import binascii
import contextlib
import dataclasses
import json
import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import DTypeLike

from cpm_core.image.region import MAX_BOX_VOXELS, Region
from cpm_core.image.regions import Regions
from cpm_core.image.surface import Surface
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.numerics.packed_mask import PackedMask
from cpm_core.numerics.types import JsonDict, JsonObject, Line, Numbers, Texts, frozen
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import quote_value
from cpm_core.shapes import SHAPES_BY_NAME, Shape

T = TypeVar("T")

LARGEST_NUMBER = 1e6
"""Largest magnitude of a number: far outside any image, yet sums of such numbers do not overflow."""

_REGION_TYPES: dict[str, type[AnyRegions]] = {"regions": Regions, "volume_regions": VolumeRegions}

_MAX_ARRAY_BYTES = 256 * 2**20
"""Largest array that is read [bytes]."""

_COMPRESSION_LEVEL = 1
"""Level of zlib: higher ones hardly shrink coordinates further, however long they take."""


@frozen
class _PackedBox:
    """Voxels of a box, eight to a byte."""

    first: tuple[int, int, int] | None
    shape: tuple[int, int, int]
    voxels: str


def to_json(value: object) -> Any:
    """Convert a dataclass, or the value of one of its fields, to JSON."""
    if isinstance(value, tuple | list):  # first, and without a call per coordinate, since most values are positions
        return [item if type(item) is float else to_json(item) for item in value]
    if isinstance(value, Region):
        return _region_to_json(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_json(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, bool | str | int) or value is None:
        return value
    return float(value)  # type: ignore[arg-type]  # numbers of NumPy as well


def from_json(kind: type[T], plain: object, where: str) -> T:
    """Build a dataclass of type `kind` from a mapping of its fields; fields with a default may be missing.

    ValueError when a field is missing, unknown or of the wrong type, or the dataclass rejects a value; `where` names
    the dataclass in the message, as in ``"shape 3"``.
    """
    plain = expect_mapping(plain, where)
    hints = get_type_hints(kind, include_extras=True)
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    unknown = sorted(str(name) for name in plain if name not in fields)
    if unknown:
        raise ValueError(f"{where} has a value {quote_value(unknown[0])}, but only {', '.join(fields)} are known.")
    given: JsonDict = {}
    for name, field in fields.items():
        if name in plain:
            given[name] = _parse_value(hints[name], plain[name], f"{name} of {where}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ValueError(f"{where} has no {name}.")
    try:
        return kind(**given)
    except ValueError as error:
        raise ValueError(f"{where} cannot be used: {error}") from error


def shape_to_json(shape: Shape) -> JsonDict:
    """Convert a shape to JSON: its kind and the values of its fields."""
    kind = next(name for name, made in SHAPES_BY_NAME.items() if type(shape) is made)
    return {"shape": kind, **to_json(shape)}


def shape_from_json(plain: object, where: str) -> Shape:
    """Build a shape from JSON; ValueError when it is not a valid shape."""
    values = dict(expect_mapping(plain, where))
    kind = values.pop("shape", None)
    if not isinstance(kind, str) or kind not in SHAPES_BY_NAME:
        raise ValueError(f"{where} is of the kind {quote_value(kind)} but must be one of {', '.join(SHAPES_BY_NAME)}.")
    return from_json(SHAPES_BY_NAME[kind], values, f"{where} ({kind})")


def parameters_from_json(plain: object) -> tuple[Parameters, Texts]:
    """Build parameters from JSON, and list the names that are unknown.

    Missing parameters have their defaults. ValueError when `plain` is not a mapping, or a value is out of range.
    """
    given = dict(expect_mapping(plain, "parameters"))
    known = {field.name for field in dataclasses.fields(Parameters)}
    values = {name: value for name, value in given.items() if name in known}
    for name, value in values.items():
        if not isinstance(value, str):
            expect_number(value, name, 1e9)
    return Parameters(**values), tuple(sorted(set(given) - known))


def expect_mapping(value: object, where: str) -> JsonObject:
    """Return a JSON object unchanged; ValueError for anything else."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} is {quote_value(value)} but must be an object with named values.")
    return value


def expect_number(value: object, where: str, largest: float = LARGEST_NUMBER) -> float:
    """Return a finite number within limits as float; ValueError for anything else."""
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= largest:
        return float(value)
    raise ValueError(f"{where} is {quote_value(value)} but must be a number from {-largest:g} to {largest:g}.")


def expect_list(value: object, where: str = "runs") -> list[Any]:
    """Return a list unchanged; ValueError for anything else."""
    return _expect_type(value, list, "a list", where)


def expect_text(value: object, where: str) -> str:
    """Return a text unchanged; ValueError for anything else."""
    return _expect_type(value, str, "text", where)


def _expect_type(value: object, kind: type[T], what: str, where: str) -> T:
    """Return a value of this type unchanged; ValueError for anything else."""
    if not isinstance(value, kind):
        raise ValueError(f"{where} is {quote_value(value)} but must be {what}.")
    return value


def _expect_whole_number(value: object, where: str) -> int:
    """Return a whole number as int; ValueError for anything else."""
    found = int(expect_number(value, where))
    if found != value:
        raise ValueError(f"{where} is {quote_value(value)} but must be a whole number.")
    return found


def _parse_value(hint: Any, plain: object, where: str) -> Any:
    """Parse a JSON value by the type hint of its field."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return _parse_union(inner, plain, where)
    if origin is Annotated:  # a tuple whose possible lengths the annotation lists
        kind, *counts = inner
        found = _parse_value(kind, plain, where)
        if len(found) not in counts:
            raise ValueError(
                f"{where} is {quote_value(plain)} but must be a list of {' or '.join(map(str, counts))} values."
            )
        return found
    if origin is tuple:
        listed = expect_list(plain, where)
        if inner[-1] is Ellipsis:
            inner = inner[:1] * len(listed)
        if len(listed) != len(inner):
            raise ValueError(f"{where} is {quote_value(plain)} but must be a list of {len(inner)} values.")
        return tuple(_parse_value(each, item, where) for each, item in zip(inner, listed, strict=True))
    if origin is Literal:
        if plain not in inner or isinstance(plain, bool):
            raise ValueError(
                f"{where} is {quote_value(plain)} but must be one of {', '.join(map(quote_value, inner))}."
            )
        return plain
    return _VALUE_PARSERS[hint](plain, where) if hint in _VALUE_PARSERS else from_json(hint, plain, where)


def _parse_union(kinds: tuple[Any, ...], plain: object, where: str) -> Any:
    """Parse a value as the first type of a union that fits."""
    if plain is None and type(None) in kinds:
        return None
    *others, last = (kind for kind in kinds if kind is not type(None))
    for kind in others:
        with contextlib.suppress(ValueError):
            return _parse_value(kind, plain, where)
    return _parse_value(last, plain, where)


@frozen
class _PackedSurface:
    """Triangles: vertices as float32, and the numbers of those of each triangle as int32, little-endian."""

    vertices: str
    faces: str


def _region_to_json(region: Region) -> JsonDict:
    """Convert a region to its boundary, its surface in single precision, and its pixels, eight in a byte."""
    if region.surface is None and region.pixels is None:
        return {"boundary": to_json(region.boundary)}
    found: JsonDict = {}
    if region.surface is not None:
        packed = {"vertices": region.surface.vertices.astype("<f4"), "faces": region.surface.faces.astype("<i4")}
        found = {name: _encode_bytes(values.tobytes()) for name, values in packed.items()}
    if region.pixels is not None:
        voxels = _encode_bytes(np.packbits(region.mask).tobytes())
        found |= {"first": to_json(region.first), "shape": region.pixels.shape, "voxels": voxels}
    return found


def _parse_region(plain: object, where: str) -> Region:
    """Parse a region."""
    given = expect_mapping(plain, where)
    if "boundary" in given:
        return Region(_parse_value(tuple[Line, ...], given["boundary"], f"boundary of {where}"))
    triangles = {name: given[name] for name in ("vertices", "faces") if name in given}
    box = {name: text for name, text in given.items() if name not in triangles}
    surface = _parse_surface(triangles, where) if triangles else None
    if triangles and not box:
        return Region(surface=surface)
    return replace(_parse_voxels(box, where), surface=surface)


def _parse_surface(plain: JsonObject, where: str) -> Surface:
    """Parse the closed surface of a region."""
    packed = from_json(_PackedSurface, plain, where)
    vertices, faces = (_decode_bytes(text, None, where) for text in (packed.vertices, packed.faces))
    if len(vertices) % 12 or len(faces) % 12:
        raise ValueError(f"{where} is damaged: it does not consist of triangles.")
    corners, numbers = np.frombuffer(vertices, "<f4"), np.frombuffer(faces, "<i4")
    try:
        surface = Surface(corners.reshape(-1, 3), numbers.reshape(-1, 3))
        Region(surface=surface)
    except ValueError as error:
        raise ValueError(f"{where} cannot be used: {error}") from error
    return surface


def _parse_voxels(plain: JsonObject, where: str) -> Region:
    """Parse the voxels of a region, checking their number before memory is allocated."""
    box = from_json(_PackedBox, plain, where)
    count = math.prod(box.shape)
    if min(box.shape) < 1 or count > MAX_BOX_VOXELS:
        raise ValueError(f"shape of {where} is {quote_value(box.shape)} but may be {MAX_BOX_VOXELS:,} voxels at most.")
    bits = _decode_bytes(box.voxels, -(-count // 8), where)
    mask = np.unpackbits(np.frombuffer(bits, np.uint8), count=count).reshape(box.shape).astype(bool)
    return Region(pixels=PackedMask.pack(mask), first=box.first)


_VALUE_PARSERS: dict[Any, Callable[[object, str], Any]] = {
    float: expect_number,
    int: _expect_whole_number,
    str: expect_text,
    bool: lambda plain, where: _expect_type(plain, bool, "true or false", where),
    Region: _parse_region,
}


def array_to_json(array: Numbers) -> JsonDict:
    """Convert an array of numbers of any shape to JSON, losslessly."""
    little_endian = array.astype(array.dtype.newbyteorder("<"), copy=False)
    return {"shape": list(array.shape), "data": _encode_bytes(little_endian.tobytes())}


def array_from_json(plain: object, dtype: DTypeLike, shape: tuple[int | None, ...], where: str) -> Numbers:
    """Build an array of this dtype and shape, where None allows any length; ValueError, naming `where`, otherwise."""
    given = expect_mapping(plain, where)
    sides = given.get("shape")
    if not (
        isinstance(sides, list)
        and len(sides) == len(shape)
        and all(type(side) is int and side >= 0 for side in sides)
        and all(wanted in (None, side) for side, wanted in zip(sides, shape, strict=True))
    ):
        wanted = " x ".join("any" if side is None else str(side) for side in shape)
        raise ValueError(f"{where} has the shape {quote_value(sides)} but must have {wanted} entries.")
    kind = np.dtype(dtype).newbyteorder("<")
    data = _decode_bytes(given.get("data"), math.prod(sides) * kind.itemsize, where)
    return np.frombuffer(data, kind).astype(dtype).reshape(sides)


def _encode_bytes(data: bytes) -> str:
    """Encode bytes as text, compressed."""
    return base64.b64encode(zlib.compress(data, _COMPRESSION_LEVEL)).decode()


def _decode_bytes(text: object, size: int | None, where: str) -> bytes:
    """Decode text of `_encode_bytes` that holds `size` bytes, or any number; ValueError, naming `where`, otherwise."""
    most = _MAX_ARRAY_BYTES if size is None else size
    if not isinstance(text, str) or most > _MAX_ARRAY_BYTES:
        raise ValueError(f"{where} holds no array that can be read.")
    try:
        unpacking = zlib.decompressobj()
        data = unpacking.decompress(base64.b64decode(text, validate=True), most + 1)
    except (zlib.error, binascii.Error, ValueError) as error:
        raise ValueError(f"{where} is damaged.") from error
    if size not in (None, len(data)) or len(data) > most or not unpacking.eof:
        raise ValueError(f"{where} is damaged: it does not hold what its shape says.")
    return data


def regions_to_json(regions: AnyRegions | None) -> JsonDict:
    """Convert limits to a JSON object of one entry; empty without limits."""
    return {name: to_json(regions) for name, kind in _REGION_TYPES.items() if isinstance(regions, kind)}


def regions_from_json(plain: JsonObject, where: str) -> AnyRegions | None:
    """Build the limits in a JSON object; None if it has none, ValueError when they are invalid."""
    return next((from_json(kind, plain[name], where) for name, kind in _REGION_TYPES.items() if name in plain), None)


def encode_json(content: JsonObject) -> bytes:
    """Encode an object as UTF-8, one line per entry of its lists and objects; ValueError for what JSON cannot hold."""
    lines = []
    for key, value in content.items():
        if isinstance(value, list) and value:
            entries, ends = [_dump_line(item) for item in value], "[]"
        elif isinstance(value, Mapping) and value and key != "image":
            entries, ends = [f"{_dump_line(name)}: {_dump_line(item)}" for name, item in value.items()], "{}"
        else:
            lines.append(f"  {_dump_line(key)}: {_dump_line(value)}")
            continue
        inner = ",\n".join(f"    {entry}" for entry in entries)
        lines.append(f"  {_dump_line(key)}: {ends[0]}\n{inner}\n  {ends[1]}")
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode(errors="backslashreplace")


def _dump_line(value: object) -> str:
    # File names may hold bytes that are not text; the caller encodes them as escapes.
    """Dump a value as JSON on one line."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, default=dict)
