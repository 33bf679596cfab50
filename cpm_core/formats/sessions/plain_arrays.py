"""Arrays in JSON: their bytes, compressed, as text; what is read is checked before it is unpacked."""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import DTypeLike, NDArray

from cpm_core.contours.packed_surface import packed, unpacked
from cpm_core.formats.sessions.plain_values import mapping
from cpm_core.parameters.quotation import shown


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
