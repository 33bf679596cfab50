"""Where lines cross the links between neighboring pixels.

A link joins the centers of two pixels with a common side. A closed line crosses exactly those links that connect pixels
inside it with pixels outside: it cuts the plane to the pixel, and each crossing is known to a fraction of a pixel.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Extent, Mask, Single, record

_CROSSING_OFFSET = np.array([1.37e-7, 2.61e-7])
"""Displacement of all lines [px], so that none runs through the center of a pixel, whose side would be undefined."""


@record
class Crossings:
    """Links that lines cross.

    Attributes
    ----------
    right, down : ndarray of float32, shape (H, W)
        Where a line crosses the link from each pixel to its right and to its lower neighbor, as a fraction of the link
        from 0 to 1; -1 where no line does.
    """

    right: Single
    down: Single

    def with_fallback(self, others: Crossings) -> Crossings:
        """Fill in crossings of others where these have none."""
        right, down = (
            np.where(own >= 0.0, own, other) for own, other in ((self.right, others.right), (self.down, others.down))
        )
        return Crossings(right, down)

    @property
    def pixels(self) -> Mask:
        """Pixels with at least one crossed link, shape (H, W)."""
        found = (self.right >= 0.0) | (self.down >= 0.0)
        found[:, 1:] |= self.right[:, :-1] >= 0.0
        found[1:] |= self.down[:-1] >= 0.0
        return found


def find_crossings(paths: Iterable[Array], shape: Extent) -> Crossings:
    """Find the links that paths, each of shape (K, 2) [px], cross in an image of this shape."""
    right, down = (np.full(shape, -1.0, dtype=np.float32) for _ in range(2))
    for path in paths:
        _mark_crossed_links(np.ascontiguousarray(path + _CROSSING_OFFSET), right, down)
    return Crossings(right, down)


@compiled
def _mark_crossed_links(path: Array, right: Single, down: Single) -> None:
    """Mark the links that a path crosses."""
    rows, cols = right.shape
    for k in range(len(path) - 1):
        (y, x), (v, u) = path[k], path[k + 1]
        for r in range(max(int(np.ceil(min(y, v))), 0), min(int(np.floor(max(y, v))), rows - 1) + 1):
            at = x + (u - x) * (r - y) / (v - y)
            c = int(np.floor(at))
            if 0 <= c < cols:
                right[r, c] = at - c
        for c in range(max(int(np.ceil(min(x, u))), 0), min(int(np.floor(max(x, u))), cols - 1) + 1):
            at = y + (v - y) * (c - x) / (u - x)
            r = int(np.floor(at))
            if 0 <= r < rows:
                down[r, c] = at - r
