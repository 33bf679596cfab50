"""What speaks for a body of a volume: its shape, the edges along its surface, and whether it is several that touch.

A body is split where the parts are nearly convex together, as nuclei are that touch, but not the parts of a skull.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.image.surface import Surface
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.background import measure_edge_steps
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.confidence import BodyFeatures, ChoiceFeatures, estimate_body_confidence, score_choice
from cpm_core.objects.selection import Selection

_MIN_SOLIDITY = 0.75
"""Least volume of the parts of a body, in volumes of their convex hulls, with which it is split."""

_MIN_RELATIVE_STEP = 0.35
"""Rise of gray levels across a surface, in medians of it along the surface, below which there is a gap."""

_TO_FACES = 0.5 * np.concatenate([np.eye(3), -np.eye(3)])
"""The way from the center of a voxel to those of its faces [voxels]."""


def split_at_clear_necks(mask: Mask, sides: Array) -> list[Mask]:
    """Split a body, shape (P, R, C), at its necks if the parts are nearly convex; else return it as it is.

    `sides` are those of a voxel, shape (3,), the smallest being 1.
    """
    labels = split_at_necks(mask, sides=sides)
    parts = [labels == number for number in range(1, int(labels.max()) + 1)]
    if len(parts) > 1 and np.count_nonzero(mask) >= _MIN_SOLIDITY * sum(map(_measure_hull, parts)):
        return parts
    return [mask]


def find_meant_body(found: Sequence[Selection]) -> Selection:
    """Find the body that a click means among those around it: compact, with edges all around, rather a small one."""
    return max(found, key=lambda one: score_choice(measure_choice(one)) if one.has_boundary else -np.inf)


def measure_choice(found: Selection) -> ChoiceFeatures:
    """Measure what tells whether a body around a click is meant; by its surface alone, since this is fast."""
    surface, steps = _measure_steps(found)
    rises = steps * np.sign(np.median(steps)) if len(steps) else steps
    volume = max(surface.volume / float(np.prod(surface.spacing)), 1.0)
    gaps = np.count_nonzero(rises < _MIN_RELATIVE_STEP * np.median(rises)) / len(rises) if len(rises) else 1.0
    return ChoiceFeatures(volume / float(scipy.spatial.ConvexHull(surface.vertices).volume), volume, gaps)


def rate_body(found: Selection) -> Selection:
    """Rate the body of a volume: return it with its confidence."""
    return replace(found, confidence=estimate_body_confidence(measure_body(found)))


def measure_body(found: Selection) -> BodyFeatures:
    """Measure what the confidence of a body is estimated from."""
    surface, steps = _measure_steps(found)
    deviation = float(steps.std()) if len(steps) else 0.0
    volume = float(found.region.count)
    return BodyFeatures(
        steadiness=abs(float(steps.mean())) / deviation if deviation else 1.0,
        solidity=volume / _measure_hull(found.region.mask),
        volume=volume,
        cut_share=1.0 - len(steps) / len(surface.vertices),
    )


def _measure_steps(found: Selection) -> tuple[Surface, Array]:
    """Measure how gray levels rise across the surface of a body; return the surface, too."""
    surface, image = found.surface, found.image
    if surface is None or image is None:
        raise ValueError("a body without voxels, or of an unknown volume, cannot be measured.")
    return surface, measure_edge_steps(image.values, surface)


def _measure_hull(mask: Mask) -> float:
    """Measure the volume of the convex hull of the voxels of a mask [voxels]."""
    shell = np.argwhere(mask & ~scipy.ndimage.binary_erosion(mask))
    corners = (shell[:, None] + _TO_FACES).reshape(-1, 3)
    return float(scipy.spatial.ConvexHull(corners).volume) if len(shell) else 0.0
