"""Snapping: an object whose boundary runs near contours grows or shrinks to them."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Index, Mask, Single
from cpm_core.objects.boundaries.crossings import Crossings

MAX_BOUNDARY_SHIFT = 3.0
"""Largest distance over which a boundary moves onto a contour [px]."""


def snap_to_contours(mask: Mask, lines: Crossings, width: float) -> Mask:
    """Snap the boundary of an object to contours within `width`, at most `MAX_BOUNDARY_SHIFT`; shapes (H, W).

    Pixels deeper in the object, or farther away from it, stay. Each pixel between goes to the side that
    is nearer along paths that cross no line. Where lines make no difference to that, it stays as it is.
    """
    width = min(width, MAX_BOUNDARY_SHIFT)
    within, beyond = (
        scipy.ndimage.distance_transform_edt(np.pad(part, 1, mode="edge"))[1:-1, 1:-1] > width for part in (mask, ~mask)
    )
    most = int(2.0 * width + 2.0)
    free = np.full(mask.shape, -1.0, np.float32)
    wanted, plain = (
        np.sign(_count_uncrossed_steps(beyond, right, down, most) - _count_uncrossed_steps(within, right, down, most))
        for right, down in ((lines.right, lines.down), (free, free))
    )
    return np.where(wanted == plain, mask, wanted > 0)


@compiled
def _count_uncrossed_steps(start: Mask, right: Single, down: Single, most: int) -> Index:
    """Count the steps over uncrossed links from the true pixels to each other one; `most` where there are more."""
    rows, cols = start.shape
    steps = np.full((rows, cols), most)
    queue = np.empty((rows * cols, 2), np.int64)
    end = 0
    for r in range(rows):
        for c in range(cols):
            if start[r, c]:
                steps[r, c] = 0
                queue[end, 0], queue[end, 1] = r, c
                end += 1
    at = 0
    while at < end:
        r, c = queue[at, 0], queue[at, 1]
        at += 1
        if steps[r, c] + 1 >= most:
            continue
        for y, x, crossed in (
            (r, c + 1, c + 1 < cols and right[r, c] >= 0.0),
            (r, c - 1, c > 0 and right[r, c - 1] >= 0.0),
            (r + 1, c, r + 1 < rows and down[r, c] >= 0.0),
            (r - 1, c, r > 0 and down[r - 1, c] >= 0.0),
        ):
            if 0 <= y < rows and 0 <= x < cols and not crossed and steps[r, c] + 1 < steps[y, x]:
                steps[y, x] = steps[r, c] + 1
                queue[end, 0], queue[end, 1] = y, x
                end += 1
    return steps
