"""Averages along edges: over the line that an edge follows through a pixel, and not across it.

A wide Gaussian removes noise, but moves edges. An average along an edge can be as long as the edge is straight or
evenly bent (line integral convolution: Cabral and Leedom 1993, doi:10.1145/166117.166151; the direction is that of the
structure tensor: Weickert 1999, doi:10.1023/A:1008009714131).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array

_REACH = 3.0
"""Where the Gaussian along a line ends, in its standard deviations."""

_DOUBT = 5.0
"""Power of the coherence that remains of a weight after one standard deviation along the line."""

_LEAST_WEIGHT = 0.02
"""Fraction of a weight below which a line is not followed any further."""


class Directions(NamedTuple):
    """Directions of edges.

    Attributes
    ----------
    row, col : ndarray, shape (H, W)
        Unit vector along the edge; its sign has no meaning.
    coherence : ndarray, shape (H, W)
        From 0 at corners and in noise, where gradients have all directions, to 1 on a straight edge.
    """

    row: Array
    col: Array
    coherence: Array


def directions(values: Array, inner: float, outer: float) -> Directions:
    """Directions of the edges of an image, shape (H, W), by its structure tensor.

    `inner` is the Gaussian before the gradient, `outer` the one over which directions are averaged [px].
    """
    down, right = (scipy.ndimage.gaussian_filter(values, inner, order, mode="nearest") for order in ((1, 0), (0, 1)))
    products = (down * down, right * right, down * right)
    rows, cols, mixed = (scipy.ndimage.gaussian_filter(product, outer, mode="nearest") for product in products)
    total = rows + cols
    spread = np.sqrt((rows - cols) ** 2 + 4.0 * mixed**2)
    coherence = np.divide(spread, total, out=np.zeros_like(total), where=total > 1e-12 * float(total.max(initial=0.0)))
    # half of the angle of (rows - cols, 2 mixed): roots instead of arc tangent, sine and cosine
    some = np.maximum(spread, 1e-300)
    cosine, sine = np.where(spread > 0.0, (rows - cols) / some, 1.0), 2.0 * mixed / some
    larger = np.sqrt(0.5 + 0.5 * np.abs(cosine))
    smaller, first = 0.5 * sine / larger, cosine >= 0.0
    row, col = np.where(first, -smaller, -np.copysign(larger, sine)), np.where(first, larger, np.abs(smaller))
    return Directions(row, col, np.clip(coherence, 0.0, 1.0))


def averaged_along(values: Array, way: Directions, length: float) -> Array:
    """Averages of an image, shape (H, W), along the lines that follow its edges in the directions `way`.

    `length` is the standard deviation of the Gaussian along a line [px]. The average is shorter where directions are
    uncertain, so that it does not pass corners.
    """
    steps = np.arange(1 + int(_REACH * length))
    weights = np.exp(-0.5 * (steps / max(length, 1e-9)) ** 2)
    trust = way.coherence ** (_DOUBT / max(length, 1e-9))
    return _follow(np.ascontiguousarray(values), way.row, way.col, trust, weights)


@compiled
def _follow(values: Array, down: Array, right: Array, trust: Array, weights: Array) -> Array:
    rows, cols = values.shape
    out = np.empty_like(values)
    for i in range(rows):
        for j in range(cols):
            total, weight = weights[0] * values[i, j], weights[0]
            for way in (-1.0, 1.0):
                y, x, left = float(i), float(j), 1.0
                last_y, last_x = way * down[i, j], way * right[i, j]
                for k in range(1, len(weights)):
                    near_y, near_x = int(y + 0.5), int(x + 0.5)
                    to_y, to_x = down[near_y, near_x], right[near_y, near_x]
                    if to_y * last_y + to_x * last_x < 0.0:
                        to_y, to_x = -to_y, -to_x
                    last_y, last_x = to_y, to_x
                    y, x, left = y + to_y, x + to_x, left * trust[near_y, near_x]
                    if left < _LEAST_WEIGHT or y < 0.0 or x < 0.0 or y > rows - 1.0 or x > cols - 1.0:
                        break
                    r, c = min(int(y), rows - 2), min(int(x), cols - 2)
                    v, u = y - r, x - c
                    above = values[r, c] + u * (values[r, c + 1] - values[r, c])
                    below = values[r + 1, c] + u * (values[r + 1, c + 1] - values[r + 1, c])
                    share = weights[k] * left
                    total += share * (above + v * (below - above))
                    weight += share
            out[i, j] = total / weight
    return out
