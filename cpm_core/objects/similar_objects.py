"""The objects of an image that are similar to a selected one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from cpm_core.numerics.grids import find_largest_part
from cpm_core.objects.all_objects import build_proposal
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.boundaries.similar_pixels import find_similar_pixels
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Selection

_SIZE_RANGE = (0.2, 4.0)
"""Smallest and largest area of a similar object, as fractions of the selected one's area."""

_MIN_TRUNCATED_SIZE = 0.05
"""Least area of a similar object cut by the image border, as a fraction of the selected one's area."""

_MIN_RELATIVE_STRENGTH = 0.3
"""Least boundary strength of similar objects, as a fraction of the selected one's."""


def find_similar_objects(partition: Partition, chosen: Selection) -> Iterator[Selection]:
    """Find the objects similar to a selected one, from the top left to the bottom right.

    Their gray level differs from the surroundings of the selected object in the same direction, and their size and the
    strength of their boundary are similar. Where two bodies touch, they are split at the neck between them. Objects
    that the border of the image cuts are closed along it, and may be smaller.
    """
    mask, area = chosen.mask, chosen.region.size
    if not area:
        return
    parts = split_at_necks(
        find_similar_pixels(partition.values, mask, partition.interest), float(np.sqrt(area / np.pi))
    )
    parts[mask] = 0
    limit, strength = np.array(partition.shape) - 1, _measure_boundary_strength(chosen)
    boxes = enumerate(scipy.ndimage.find_objects(parts), start=1)
    for number, box in ((number, box) for number, box in boxes if box):
        body = parts[box] == number
        cut = any(part.start == 0 or part.stop > last for part, last in zip(box, limit.tolist(), strict=True))
        if (_MIN_TRUNCATED_SIZE if cut else _SIZE_RANGE[0]) * area <= np.count_nonzero(body) <= _SIZE_RANGE[1] * area:
            mask = np.zeros(partition.shape, bool)
            mask[box] = find_largest_part(body)
            other = build_proposal(partition, mask)
            if _measure_boundary_strength(other) >= _MIN_RELATIVE_STRENGTH * strength:
                yield other


def _measure_boundary_strength(selection: Selection) -> float:
    """Measure the mean edge strength along the boundary [gray levels / px]."""
    lengths = np.array([contour.length for contour in selection.contours])
    strengths = np.array([contour.strength for contour in selection.contours])
    return float(lengths @ strengths / lengths.sum()) if len(lengths) else 0.0
