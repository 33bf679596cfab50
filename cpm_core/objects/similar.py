"""All like this: the other objects of an image that resemble a chosen one."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Mask
from cpm_core.objects.boundaries.alike import alike
from cpm_core.objects.boundaries.necks import bodies
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Selection

_SIZE = 0.2, 4.0
"""Area of others, as fractions of that of the chosen one."""

_CUT = 0.05
"""Least area of one that the border of the image cuts, as the same fraction."""

_EDGE = 0.3
"""Least strength of the boundary of others, as a fraction of that of the chosen one's."""


def similar(partition: Partition, selection: Selection) -> tuple[Selection, ...]:
    """Find objects like a chosen one.

    Others have a gray level that differs from the surroundings of the chosen object in the same direction, a similar
    size, and a boundary of similar strength. Where the bodies of two touch, they are parted at the neck between them.
    What the border of the image cuts is closed along it, and may be smaller.

    Parameters
    ----------
    partition : Partition
        The image.
    selection : Selection
        The chosen object.

    Returns
    -------
    tuple of Selection
        The chosen one first, then the others from the top left to the bottom right, none of which overlap; empty when
        nothing is chosen.

    Examples
    --------
    >>> partition = cpm.partition(cpm.example("disks"))
    >>> len(cpm.similar(partition, partition.select([(32, 18)])))
    2
    """
    if not selection.mask.any():
        return ()
    area = float(np.count_nonzero(selection.mask))
    radius = np.sqrt(area / np.pi)
    parts = bodies(alike(partition.values, selection.mask, partition.interest), radius)
    parts[selection.mask] = 0
    found = [selection]
    limit = np.array(partition.shape) - 1
    strength = _boundary_strength(selection)
    boxes = enumerate(scipy.ndimage.find_objects(parts), start=1)
    for number, box in ((number, box) for number, box in boxes if box):
        body = parts[box] == number
        cut = any(part.start == 0 or part.stop > last for part, last in zip(box, limit.tolist(), strict=True))
        least = _CUT if cut else _SIZE[0]
        if not least * area <= np.count_nonzero(body) <= _SIZE[1] * area:
            continue
        mask = np.zeros(partition.shape, np.bool_)
        mask[box] = _largest(body)
        depth = scipy.ndimage.distance_transform_edt(mask)
        deepest = np.argwhere(depth == depth.max())[:1]  # as a place inside
        other = partition.selection_of(mask, deepest.astype(float))
        if _boundary_strength(other) >= _EDGE * strength:
            found.append(other)
    return tuple(found)


def _largest(mask: Mask) -> Mask:
    """The largest connected part of a mask."""
    parts, _ = scipy.ndimage.label(mask)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return np.asarray(parts == sizes.argmax())


def _boundary_strength(selection: Selection) -> float:
    """Mean edge strength along the boundary [gray levels / px]."""
    lengths = np.array([contour.length for contour in selection.contours])
    strengths = np.array([contour.strength for contour in selection.contours])
    return float(lengths @ strengths / lengths.sum()) if len(lengths) else 0.0
