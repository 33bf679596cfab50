"""Series for the potential 1 / r of particles in a plane, up to the fourth order.

The effect of a box of particles far away is given by its moments about its center c,

    M_ab = sum_j (c_y - y_j)^a (c_x - x_j)^b / (a! b!),

and the effect of far boxes inside a box by the derivatives L_ab of their potential at its center. Taylor's theorem
connects them: L_ab = sum_kl M_kl D_(a+k)(b+l), D being the derivatives of 1 / r at the vector between the centers; all
orders beyond the fourth are left out. A row of coefficients has ab at a * SIDE + b, so that indices add like the
orders.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import reordered
from cpm_core.numerics.types import Array, Index

Boxes = NDArray[np.int32]

ORDER = 4
SIDE = ORDER + 1
ROWS = SIDE * SIDE

LANES = 16
"""Far boxes that are processed side by side; a multiple of the length of the vector registers."""

INVERSE = 1.0 / np.maximum(np.arange(SIDE), 1)


@reordered
def gather_moments(
    y: Array, x: Array, box: Array, moments: Array, first: int, last: int, levels: int, leaves: int, side: int
) -> None:
    """Moments of the boxes `first` to `last` - 1 of a level and of `levels` levels below them, from below."""
    widest = max(y.size // leaves + 1, 2)
    u, v = np.empty((side, widest)), np.empty((side, widest))
    for down in range(levels + 1):
        for node in range(first << (levels - down), last << (levels - down)):
            start, end = y.size * (node - leaves) // leaves, y.size * (node - leaves + 1) // leaves
            count = end - start if node >= leaves else 2
            # The particles of a leaf, or the centers of the two boxes of any other.
            for i in range(count):
                there_y = y[start + i] if node >= leaves else box[2 * node + i, 0]
                there_x = x[start + i] if node >= leaves else box[2 * node + i, 1]
                u[0, i], v[0, i] = 1.0, 1.0
                for n in range(1, side):
                    u[n, i] = u[n - 1, i] * ((box[node, 0] - there_y) * INVERSE[n])
                    v[n, i] = v[n - 1, i] * ((box[node, 1] - there_x) * INVERSE[n])
            for a in range(side):
                for b in range(side - a):
                    total = 0.0
                    if node >= leaves:
                        for i in range(count):
                            total += u[a, i] * v[b, i]
                    else:
                        for child in range(2):
                            for k in range(a + 1):
                                for n in range(b + 1):
                                    m = moments[2 * node + child, (a - k) * side + b - n]
                                    total += m * u[k, child] * v[n, child]
                    moments[node, a * side + b] = total


@reordered
def add_far(box: Array, moments: Array, boxes: Index, far: Boxes, far_end: Index, local: Array, side: int) -> None:
    """Add the effect of the boxes that are far from some boxes to the derivatives at their centers.

    The derivatives of 1 / r follow from those of the two orders below, with n = a + b: n r^2 D_ab = -(2 n - 1) (a y
    D_(a-1)b + b x D_a(b-1)) - (n - 1) (a (a - 1) D_(a-2)b + b (b - 1) D_a(b-2)).
    """
    d, m = np.zeros(side * side * LANES), np.zeros(side * side * LANES)
    y, x, inverse = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    for row in range(boxes.size):
        node = boxes[row]
        for begin in range(far_end[row], far_end[row + 1], LANES):
            for lane in range(LANES):
                there = begin + lane < far_end[row + 1]
                source = far[begin + lane if there else begin]
                y[lane], x[lane] = box[node, 0] - box[source, 0], box[node, 1] - box[source, 1]
                inverse[lane] = 1.0 / (y[lane] * y[lane] + x[lane] * x[lane])
                d[lane] = np.sqrt(inverse[lane])
                for a in range(side):
                    for n in range(a * side, a * side + side - a):
                        m[n * LANES + lane] = moments[source, n] if there else 0.0
            for n in range(1, side):
                one, two = (1.0 - 2.0 * n) / n, (1.0 - n) / n
                for b in range(n + 1):
                    a = n - b
                    c_y, c_x, c_yy, c_xx = one * a, one * b, two * a * (a - 1), two * b * (b - 1)
                    out = (a * side + b) * LANES
                    d_y, d_x = max(out - side * LANES, 0), max(out - LANES, 0)
                    d_yy, d_xx = max(out - 2 * side * LANES, 0), max(out - 2 * LANES, 0)
                    for lane in range(LANES):
                        first = c_y * y[lane] * d[d_y + lane] + c_x * x[lane] * d[d_x + lane]
                        second = c_yy * d[d_yy + lane] + c_xx * d[d_xx + lane]
                        d[out + lane] = inverse[lane] * (first + second)
            for a in range(side):
                for b in range(side - a):
                    total = 0.0
                    for k in range(side - a - b):
                        in_d, in_m = ((a + k) * side + b) * LANES, k * side * LANES
                        for n in range((side - a - b - k) * LANES):
                            total += d[in_d + n] * m[in_m + n]
                    local[row, a * side + b] += total


@reordered
def hand_down(box: Array, boxes: Index, above: Index, local: Array, side: int) -> None:
    """Add the series of the parents of some boxes to theirs; the boxes come in the order of the tree."""
    u, v = np.ones(side), np.ones(side)
    for row in range(boxes.size):
        node, up = boxes[row], boxes[above[row]]
        if node == 1:
            continue
        for n in range(1, side):
            u[n] = u[n - 1] * (box[node, 0] - box[up, 0]) * INVERSE[n]
            v[n] = v[n - 1] * (box[node, 1] - box[up, 1]) * INVERSE[n]
        for a in range(side):
            for b in range(side - a):
                total = 0.0
                for k in range(side - a - b):
                    for n in range(side - a - b - k):
                        total += local[above[row], (a + k) * side + b + n] * u[k] * v[n]
                local[row, a * side + b] += total
