"""What speaks for a body of a volume: its shape, and the edges along its surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.image.region import Region
from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import expand_window, measure_depth
from cpm_core.numerics.types import Array
from cpm_core.objects.boundaries.background import measure_edge_steps
from cpm_core.objects.boundaries.necks import measure_hull
from cpm_core.objects.confidence import (
    BodyFeatures,
    ChoiceFeatures,
    InnerFeatures,
    estimate_body_confidence,
    estimate_inner_confidence,
    score_choice,
)
from cpm_core.objects.prior.body_prediction import BodyPrediction
from cpm_core.objects.prior.stable_regions import MIN_RELATIVE_EDGE, SAME_GAP_SHARE
from cpm_core.objects.selection import Selection, remark_on_doubt

MIN_INNER_CONFIDENCE = 0.5
"""Least probability with which what lies in a body is an object of its own."""

_LEAST_SURFACE_SHARE = 0.5
"""Least volume within the surface of a body, in the volume of its steps."""

_SAME_SCORE = 0.2
"""Difference between scores of bodies around a click that says nothing; then the one with fewer gaps is meant."""

_MAX_THIN_SPHERICITY = 0.4
"""Largest sphericity of something thin, such as a tree of vessels."""

_RING = 2.0, 5.0
"""Distances from an inner part between which gray levels are those around it [smallest sides of a voxel]."""

_RING_MARGIN = 6
"""Width of the margin around an inner part in which these are looked for [voxels]."""

_MIN_RING_SIZE = 20
"""Number of voxels from which their gray levels are known."""

_LOWER_RANK = 0.1587
"""Quantile of normal noise one standard deviation below its mean."""

_LEAST_NOISE = 0.0005
"""Least standard deviation of smoothed gray levels around an inner part, as a fraction of their range in the volume."""

_OWN_DEPTH = 1.5
"""Depth in an inner part beyond which gray levels are its own [smallest sides of a voxel]."""

_MIN_OWN_SIZE = 10
"""Number of such voxels below which all of its voxels count."""


def find_meant_body(
    bodies: Sequence[BodyPrediction], point: Array, build: Callable[[BodyPrediction], Selection]
) -> Selection:
    """Find the body that a click means among those around it: compact, with edges all around, rather a small one.

    A piece of something thin means the whole: of thin bodies with edges all around it is the largest.

    Parameters
    ----------
    bodies : sequence of BodyPrediction
        The bodies.
    point : ndarray, shape (3,)
        Where the click is [smallest sides of a voxel].
    build : callable
        Build the selection of one of them; only asked for those that are small enough to be the one.
    """
    volumes = [_LEAST_SURFACE_SHARE * body.measure_volume_around(point) for body in bodies]
    found: list[tuple[float, ChoiceFeatures, Selection]] = []
    for number in np.argsort(volumes, kind="stable").tolist():
        most = score_choice(ChoiceFeatures(1.0, max(volumes[number], 1.0), 0.0))
        if found and most < max(score for score, _, _ in found):
            break
        one = build(bodies[number])
        if one.has_boundary:
            features = measure_choice(one)
            found.append((score_choice(features), features, one))
    if not found:
        return build(bodies[0])
    most = max(score for score, _, _ in found)
    _, best, meant = min((one for one in found if one[0] >= most - _SAME_SCORE), key=lambda each: each[1].gap_share)
    if best.sphericity < _MAX_THIN_SPHERICITY:
        whole = [
            (features.volume, one)
            for _, features, one in found
            if features.sphericity < _MAX_THIN_SPHERICITY and features.gap_share <= best.gap_share + SAME_GAP_SHARE
        ]
        _, meant = max(whole, key=lambda each: each[0])
    return meant


def measure_choice(found: Selection) -> ChoiceFeatures:
    """Measure what tells whether a body around a click is meant; by its surface alone, since this is fast."""
    surface, steps = _measure_steps(found)
    rises = steps * np.sign(np.median(steps)) if len(steps) else steps
    sphericity = _measure_sphericity(surface)
    volume = max(surface.volume / float(np.prod(surface.spacing)), 1.0)
    gaps = np.count_nonzero(rises < MIN_RELATIVE_EDGE * np.median(rises)) / len(rises) if len(rises) else 1.0
    return ChoiceFeatures(sphericity, volume, gaps)


def rate_body(found: Selection) -> Selection:
    """Rate the body of a volume: return it with its confidence, and with a remark if that is almost zero."""
    return remark_on_doubt(replace(found, confidence=estimate_body_confidence(measure_body(found))))


def measure_body(found: Selection) -> BodyFeatures:
    """Measure what the confidence of a body is estimated from."""
    surface, steps = _measure_steps(found)
    deviation = float(steps.std()) if len(steps) else 0.0
    volume = float(found.region.count)
    return BodyFeatures(
        steadiness=abs(float(steps.mean())) / deviation if deviation else 1.0,
        solidity=volume / measure_hull(found.region.mask),
        volume=volume,
        cut_share=1.0 - len(steps) / len(surface.vertices),
    )


def rate_inner_part(found: Selection, body: Region) -> Selection:
    """Rate what lies in a body: return it with its confidence, and with a remark if that is almost zero."""
    return remark_on_doubt(replace(found, confidence=estimate_inner_confidence(measure_inner_part(found, body))))


def measure_inner_part(found: Selection, body: Region) -> InnerFeatures:
    """Measure what the confidence of what lies in a body is estimated from."""
    surface, steps = _measure_steps(found)
    assert found.image is not None
    values, sides = found.image.values, np.array(surface.spacing) / min(surface.spacing)
    window = expand_window(found.region.window, _RING_MARGIN, values.shape)
    near, part, inside = values[window], found.region.cut_out(window), body.cut_out(window)
    away = scipy.ndimage.distance_transform_edt(~part, sides)
    ring = inside & (away > _RING[0]) & (away <= _RING[1]) & (measure_depth(inside, sides) > _RING[0])
    if np.count_nonzero(ring) < _MIN_RING_SIZE:
        ring = ~part & (away <= _RING[1])
    core = measure_depth(part, sides) > _OWN_DEPTH
    if np.count_nonzero(core) < _MIN_OWN_SIZE:
        core = part
    rise, least = float(np.median(near[core]) - np.median(near[ring])), _LEAST_NOISE * float(np.ptp(values))
    smooth = scipy.ndimage.gaussian_filter(near, 1.0 / sides)
    deviation, noise, texture = (  # on the side away from the edge, and from other parts like it
        max(float(np.median(levels) - np.quantile(levels, _LOWER_RANK)), least)
        for levels in (-np.sign(rise) * near[core], np.sign(rise) * near[ring], np.sign(rise) * smooth[ring])
    )
    return InnerFeatures(
        contrast=abs(rise) / texture,
        sharpness=float(np.median(steps)) / rise if rise and len(steps) else 0.0,
        unevenness=deviation / noise,
        volume=float(found.region.count),
        sphericity=_measure_sphericity(surface),
    )


def _measure_sphericity(surface: Surface) -> float:
    """Measure the area of a ball of the volume within a surface, in areas of the surface."""
    return float(min(np.cbrt(36.0 * np.pi * surface.volume**2) / surface.area, 1.0))


def _measure_steps(found: Selection) -> tuple[Surface, Array]:
    """Measure how gray levels rise across the surface of a body; return the surface, too."""
    surface, image = found.surface, found.image
    if surface is None or image is None:
        raise ValueError("a body without voxels, or of an unknown volume, cannot be measured.")
    return surface, measure_edge_steps(image.values, surface)
