"""Fields between the pixels, for any number of axes; `plane` has the same for the inner loops of a run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array


def interpolate(field: NDArray[np.floating], positions: Array) -> Array:
    r"""Multilinear interpolation of a field, shape (C, \*shape), at positions, shape (N, D), into shape (N, C).

    A position beyond the outermost pixels takes the value of the nearest point of the border.
    """
    out = np.empty((len(positions), len(field)))
    shape = np.array(field.shape[1:], dtype=np.int64)
    kept = field.dtype if field.dtype == np.float32 else np.float64  # a large field in single precision is not copied
    flat = np.ascontiguousarray(field, dtype=kept).reshape(len(field), -1)
    _interpolate(_read_only(flat), shape, _read_only(np.ascontiguousarray(positions, dtype=float)), out)
    return out


def _read_only(values: Array) -> Array:
    """A view that cannot be written to, as those of images: the loop is compiled once for all arrays."""
    view = values.view()
    view.flags.writeable = False
    return view


@compiled
def _interpolate(flat: Array, shape: NDArray[np.int64], positions: Array, out: Array) -> None:
    out[:] = 0.0
    for i in range(len(positions)):
        for corner in range(1 << shape.size):
            weight, index = 1.0, 0
            for k in range(shape.size):  # the bits of `corner` select one of the pixels around the position
                x = min(max(positions[i, k], 0.0), shape[k] - 1.0)
                low = min(np.int64(x), max(shape[k] - 2, 0))
                up = (corner >> k) & 1
                weight *= x - low if up else 1.0 - (x - low)
                index = index * shape[k] + min(low + up, shape[k] - 1)
            if weight != 0.0:
                for c in range(len(flat)):
                    out[i, c] += weight * flat[c, index]
