"""All bodies of a volume: what closed surfaces enclose, split at necks, and how likely each is an object.

A body is split where the parts are nearly convex together, as nuclei are that touch, but not the parts of a skull.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.image.region import Region
from cpm_core.numerics.grids import expand_window, find_label_boxes
from cpm_core.numerics.types import Array, Callback, Index, Mask
from cpm_core.objects.background import measure_edge_steps
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.confidence import BodyFeatures, estimate_body_confidence
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumePartition

_MIN_SOLIDITY = 0.75
"""Least volume of the parts of a body, in volumes of their convex hulls, with which it is split."""

_TO_FACES = 0.5 * np.concatenate([np.eye(3), -np.eye(3)])
"""The way from the center of a voxel to those of its faces [voxels]."""


def find_bodies_everywhere(partition: VolumePartition, check: Callback = lambda: None) -> Iterator[Selection]:
    """Find all bodies inside the surface of a volume, split at necks, each with its confidence.

    `check` is called between them, and may raise to end the search.
    """
    labels: Index = partition.labels
    solid = set(partition.solid_bodies.tolist())
    for number, box in (found for found in find_label_boxes(labels) if found[0] in solid):
        check()
        window = expand_window(box, 1, partition.shape)
        parts = split_body(labels[window] == number, partition.voxel_sides)
        if len(parts) > 1:
            first = [side.start for side in window]
            yield from (build_body(partition, Region.from_mask(part, first)) for part in parts)
            continue
        boundary = partition.extract_boundary(np.array([number]))
        if len(boundary.faces):
            yield build_body(partition, Region(surface=boundary))


def build_body(partition: VolumePartition, region: Region) -> Selection:
    """Build the selection of a body, with its deepest voxel as its positive point, and its confidence."""
    depth = scipy.ndimage.distance_transform_edt(np.pad(region.mask, 1))[1:-1, 1:-1, 1:-1]
    deepest = np.argwhere(depth == depth.max())[:1] + np.array(region.origin, float)
    return rate_body(partition.build_selection(region, deepest))


def split_body(mask: Mask, sides: Array) -> list[Mask]:
    """Split a body, shape (P, R, C), at its necks if the parts are nearly convex; else return it as it is.

    `sides` are those of a voxel, shape (3,), the smallest being 1.
    """
    labels = split_at_necks(mask, sides=sides)
    parts = [labels == number for number in range(1, int(labels.max()) + 1)]
    if len(parts) > 1 and np.count_nonzero(mask) >= _MIN_SOLIDITY * sum(map(_measure_hull, parts)):
        return parts
    return [mask]


def rate_body(found: Selection) -> Selection:
    """Rate the body of a volume: return it with its confidence."""
    return replace(found, confidence=estimate_body_confidence(measure_body(found)))


def measure_body(found: Selection) -> BodyFeatures:
    """Measure what the confidence of a body is estimated from."""
    surface, image = found.surface, found.image
    if surface is None or image is None:
        raise ValueError("a body without voxels, or of an unknown volume, cannot be measured.")
    steps = measure_edge_steps(image.values, surface)
    deviation = float(steps.std()) if len(steps) else 0.0
    volume = float(found.region.count)
    return BodyFeatures(
        steadiness=abs(float(steps.mean())) / deviation if deviation else 1.0,
        solidity=volume / _measure_hull(found.region.mask),
        volume=volume,
        cut_share=1.0 - len(steps) / len(surface.vertices),
    )


def _measure_hull(mask: Mask) -> float:
    """Measure the volume of the convex hull of the voxels of a mask [voxels]."""
    shell = np.argwhere(mask & ~scipy.ndimage.binary_erosion(mask))
    corners = (shell[:, None] + _TO_FACES).reshape(-1, 3)
    return float(scipy.spatial.ConvexHull(corners).volume) if len(shell) else 0.0
