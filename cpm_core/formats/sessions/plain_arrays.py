"""Arrays in JSON: their bytes, compressed, as text; what is read is checked before it is unpacked."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cpm_core.formats.sessions.plain_values import mapping
from cpm_core.parameters.quotation import shown

_LARGEST = 256 * 2**20
"""Most bytes of an array that is read."""

_FAST = 1
"""Level of compression: bits of positions hardly become fewer, however long one tries."""


def array_to_plain(array: NDArray[Any]) -> dict[str, Any]:
    """An array of numbers as plain JSON, exactly."""
    data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<"), copy=False).tobytes()
    return {"shape": list(array.shape), "data": base64.b64encode(zlib.compress(data, _FAST)).decode()}


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
    kind = np.dtype(dtype).newbyteorder("<")
    data = _unpacked(given, math.prod(sides) * kind.itemsize, where)
    return np.frombuffer(data, kind).reshape(sides).astype(dtype)


def _unpacked(given: Mapping[str, Any], size: int, where: str) -> bytes:
    """Exactly `size` bytes, however much the text would unpack to."""
    text = given.get("data")
    if not isinstance(text, str) or size > _LARGEST:
        raise ValueError(f"{where} holds no array that can be read.")
    try:
        unpacking = zlib.decompressobj()
        data = unpacking.decompress(base64.b64decode(text, validate=True), size + 1)
    except (zlib.error, binascii.Error, ValueError) as error:
        raise ValueError(f"{where} is damaged.") from error
    if len(data) != size or not unpacking.eof:
        raise ValueError(f"{where} is damaged: it does not hold what its shape says.")
    return data
