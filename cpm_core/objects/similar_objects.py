"""The objects of an image or a volume that are similar to a selected one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from cpm_core.image.region import Region
from cpm_core.numerics.grids import expand_window, find_label_boxes, find_largest_part, first_pixel
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.all_objects import build_proposal
from cpm_core.objects.boundaries.background import measure_edge_steps
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.boundaries.similar_pixels import find_similar_pixels, measure_radius
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumePartition

_SIZE_RANGE = (0.2, 4.0)
"""Smallest and largest size of a similar object, as fractions of the selected one's size."""

_MIN_TRUNCATED_SIZE = 0.05
"""Least area of a similar object cut by the image border, as a fraction of the selected one's area."""

_OBJECT_RIM_WIDTH = 4
"""Width of the surroundings of an object with whose gray level its own is compared [px]."""

_TRIMMED_WIDTH = 2
"""Depth to which an object is trimmed; deeper, its texture is its own [px]."""

_MIN_RELATIVE_STRENGTH = 0.3
"""Least boundary strength of similar objects, as a fraction of the selected one's."""


_MIN_FREE_SHARE = 0.5
"""Least share of an object that is not excluded: less is a remainder of what is known."""


def find_similar_objects(
    partition: Partition | VolumePartition, chosen: Selection, excluded: Mask | None = None
) -> Iterator[Selection]:
    """Find the objects similar to a selected one, from the top left to the bottom right.

    Their gray level differs from the surroundings of the selected object in the same direction, and their size and the
    strength of their boundary are similar. Where two bodies touch, they are split at the neck between them. Objects
    that the border of the image cuts are closed along it, and may be smaller. Pixels that are `excluded`, an array in
    the shape of the image, belong to none of them, and what lies mostly in these is left out.
    """
    mask, area = chosen.mask, chosen.region.count
    if not area:
        return
    sides = partition.voxel_sides if isinstance(partition, VolumePartition) else np.ones(2)
    similar = find_similar_pixels(partition.values, mask, partition.interest, sides)
    parts = split_at_necks(similar, measure_radius(mask, sides), sides)
    taken = mask if excluded is None else mask | excluded
    limit, strength = np.array(partition.shape) - 1, _measure_boundary_strength(partition, chosen)
    for number, box in find_label_boxes(parts):
        whole = parts[box] == number
        body = whole & ~taken[box]
        if np.count_nonzero(body) < _MIN_FREE_SHARE * np.count_nonzero(whole):
            continue
        cut = any(part.start == 0 or part.stop > last for part, last in zip(box, limit.tolist(), strict=True))
        if (_MIN_TRUNCATED_SIZE if cut else _SIZE_RANGE[0]) * area <= np.count_nonzero(body) <= _SIZE_RANGE[1] * area:
            other = _build_object(partition, Region.from_mask(find_largest_part(body), first_pixel(box)))
            if _measure_boundary_strength(partition, other) >= _MIN_RELATIVE_STRENGTH * strength:
                yield other


def _build_object(partition: Partition | VolumePartition, region: Region) -> Selection:
    """Build the selection of what has been found."""
    region = _trim_to_half_level(partition.values, region)
    if isinstance(partition, VolumePartition):
        return partition.rate_region(region)
    return build_proposal(partition, region.paste(partition.shape))


def _trim_to_half_level(values: Array, region: Region) -> Region:
    """Leave out rim pixels of an object that differ less from it than from its surroundings, as particles would.

    An outline that keeps to the rim of similar pixels would have notches, since edges lie deeper.
    """
    window = expand_window(region.window, _OBJECT_RIM_WIDTH, values.shape)
    near, body = scipy.ndimage.gaussian_filter(values[window], 1.0), region.cut_out(window)
    away = scipy.ndimage.distance_transform_edt(~body)
    rim = near[(away > 1.0) & (away <= _OBJECT_RIM_WIDTH)]
    if not len(rim):
        return region
    own, around = float(np.median(near[body])), float(np.median(rim))
    kept = body & ((near - 0.5 * (own + around)) * (own - around) > 0.0)
    kept |= scipy.ndimage.binary_erosion(body, iterations=_TRIMMED_WIDTH)
    return Region.from_mask(find_largest_part(kept), first_pixel(window)) if kept.any() else region


def _measure_boundary_strength(partition: Partition | VolumePartition, selection: Selection) -> float:
    """Measure the mean edge strength along the boundary, of a body by how much gray levels rise across it."""
    if isinstance(partition, VolumePartition):
        surface = selection.surface
        return 0.0 if surface is None else abs(float(measure_edge_steps(partition.values, surface).mean()))
    lengths = np.array([contour.length for contour in selection.contours])
    strengths = np.array([contour.strength for contour in selection.contours])
    return float(lengths @ strengths / lengths.sum()) if len(lengths) else 0.0
