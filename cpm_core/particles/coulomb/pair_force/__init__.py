"""Pairs of particles that are near each other: their part of eq. (9) in a run, nearest neighbors, and their energy.

A run sums pairs in single precision over a list of the particles in the cells around one, relative to that cell: see
`plane`. What is beyond the reach of the list is carried by a mesh (`mesh_force`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Single

Bits = NDArray[np.int32]

LANES = 16
"""Lists are filled up to a multiple of it, so that their sums use vector registers to the end."""

FILLER = 1e6
"""Coordinate that fills up a list [px]; its force is next to nothing, and its cube is still a number."""

SAME_SPOT = 1e-10
"""Squared distance below which two particles are at the same position: a bound instead of a branch keeps the loop on
vector registers, and such a pair adds its vanishing distance, which is nothing."""

NEAREST = 0.1
"""Least distance of two particles in their energy [px], which thus stays finite."""

_INFINITE = np.float32(np.inf).view(np.int32)
"""Bits of infinity."""


@compiled
def two_nearest(squared: Single, bits: Bits, length: int) -> tuple[float, float]:
    """Least two of some squared distances, other than zero; `bits` views the same memory, which is overwritten.

    The bits of positive numbers have the order of the numbers, and integers are compared many at once.
    """
    first = _INFINITE
    for j in range(length):
        here = bits[j]
        here = here if here > 0 else _INFINITE
        first = here if here < first else first
    second, ties = _INFINITE, 0
    for j in range(length):
        here = bits[j]
        ties += 1 if here == first else 0
        here = here if here > first else _INFINITE
        second = here if here < second else second
    bits[0], bits[1] = first, first if ties > 1 else second
    return squared[0], squared[1]
