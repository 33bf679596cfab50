"""Sums in a fixed order that vector registers of any width can follow.

A compiled loop that adds numbers one after the other cannot use vector registers, and one that may reorder its sums
gives other last bits on a processor with other registers. Here the order is fixed: number j is added to lane
``j % LANES``, and in the end the lanes are added in pairs. Registers of 4, 8 or 16 numbers give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from cpm_core.numerics.types import Single

LANES = 16
"""Lanes of a sum; lists are filled up to a multiple of it."""

_BYTES = 4
"""Bytes of a number: those of an array in single precision begin at a multiple of it."""


def _typed(context: Any, one: Any, other: Any, length: Any) -> tuple[Any, Any]:
    """Types of `sums_in_lanes`, and what writes its instructions."""
    values = types.Array(types.float32, 1, "C")
    return types.UniTuple(types.float32, 2)(values, values, types.intp), _emit_sums


sums_in_lanes: Callable[[Single, Single, int], tuple[float, float]] = cast(Any, intrinsic(_typed))
"""Sums of the first numbers of two arrays in single precision, a multiple of `LANES` of them, in a compiled loop.

Two, since each addition waits for the one before. Written in the language of the compiler, which has vectors of
numbers; neither Python nor Numba's part of it does.
"""


def _emit_sums(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Instructions that sum vectors of `LANES` numbers."""
    lanes = ir.VectorType(ir.FloatType(), LANES)
    arrays = [
        cgutils.create_struct_proxy(kind)(context, builder, array)
        for kind, array in zip(signature.args[:2], arguments[:2], strict=True)
    ]
    totals = [cgutils.alloca_once_value(builder, ir.Constant(lanes, None)) for _ in arrays]
    length = arguments[2]
    kind = length.type
    with cgutils.for_range_slice(builder, kind(0), length, kind(LANES), kind) as (first, _):
        for array, total in zip(arrays, totals, strict=True):
            place = builder.bitcast(builder.gep(array.data, [first]), lanes.as_pointer())
            builder.store(builder.fadd(builder.load(total), builder.load(place, align=_BYTES)), total)
    sums = [_emit_fold(builder, builder.load(total)) for total in totals]
    return context.make_tuple(builder, signature.return_type, sums)


def _emit_fold(builder: Any, left: Any) -> Any:
    """Instructions that add the halves of a vector until one number is left."""
    count = LANES
    while count > 1:
        count //= 2
        halves = (range(count), range(count, 2 * count))
        masks = (ir.Constant(ir.VectorType(ir.IntType(32), count), list(half)) for half in halves)
        left = builder.fadd(*[builder.shuffle_vector(left, left, mask) for mask in masks])
    return builder.extract_element(left, ir.IntType(32)(0))
