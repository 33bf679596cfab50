"""What the particles of a leaf of the tree feel."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.coulomb.direct_sum import pairs_of
from cpm_core.particles.coulomb.expansions import INVERSE

Boxes = NDArray[np.int32]

_LEAST_RADIUS = 1e-15
"""Radius of the smallest leaf whose own unit of length is used: seen from a smaller one, single precision would have no
number for the squared distance of the farthest particle."""


@compiled
def sum_near(
    y: Array,
    x: Array,
    order: Index,
    box: Array,
    boxes: Index,
    flags: Mask,
    leaves: int,
    near: Boxes,
    near_end: Index,
    local: Array,
    side: int,
    single: bool,
    force: Array,
) -> None:
    """Force on the particles of some leaves, from the derivatives at their centers and from the leaves near them."""
    widest = y.size // leaves + 1
    u, v, f = np.empty((side, widest)), np.empty((side, widest)), np.empty((2, widest))
    near_y, near_x = np.empty(y.size), np.empty(y.size)
    for row in range(boxes.size):
        node = boxes[row]
        if node < leaves or not flags[node]:
            continue
        # Lengths in about radii of the leaf, of which single precision has the most; powers of two round nothing.
        scale = math.ldexp(1.0, -math.frexp(box[node, 2])[1]) if box[node, 2] > _LEAST_RADIUS else 1.0
        count = 0
        for n in range(near_end[row], near_end[row + 1]):
            k = near[n] - leaves
            for j in range(y.size * k // leaves, y.size * (k + 1) // leaves):
                near_y[count], near_x[count] = scale * y[j], scale * x[j]
                count += 1
        start, end = y.size * (node - leaves) // leaves, y.size * (node - leaves + 1) // leaves
        for i in range(end - start):
            u[0, i], v[0, i], f[0, i], f[1, i] = 1.0, 1.0, 0.0, 0.0
            for n in range(1, side):
                u[n, i] = u[n - 1, i] * ((y[start + i] - box[node, 0]) * INVERSE[n])
                v[n, i] = v[n - 1, i] * ((x[start + i] - box[node, 1]) * INVERSE[n])
        for a in range(side - 1):
            for b in range(side - 1 - a):
                l_y, l_x = local[row, (a + 1) * side + b], local[row, a * side + b + 1]
                for i in range(end - start):
                    weight = u[a, i] * v[b, i]
                    f[0, i] -= l_y * weight
                    f[1, i] -= l_x * weight
        for i in range(end - start):
            f_y, f_x = pairs_of(near_y[:count], near_x[:count], scale * y[start + i], scale * x[start + i], single)
            force[order[start + i], 0] = f[0, i] + scale * scale * f_y
            force[order[start + i], 1] = f[1, i] + scale * scale * f_x
