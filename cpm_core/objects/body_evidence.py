"""What speaks for a body of a volume: its shape, and the edges along its surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from cpm_core.image.surface import Surface
from cpm_core.numerics.types import Array
from cpm_core.objects.boundaries.background import measure_edge_steps
from cpm_core.objects.boundaries.necks import measure_hull
from cpm_core.objects.confidence import BodyFeatures, ChoiceFeatures, estimate_body_confidence, score_choice
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
    sphericity = min(np.cbrt(36.0 * np.pi * surface.volume**2) / surface.area, 1.0)
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


def _measure_steps(found: Selection) -> tuple[Surface, Array]:
    """Measure how gray levels rise across the surface of a body; return the surface, too."""
    surface, image = found.surface, found.image
    if surface is None or image is None:
        raise ValueError("a body without voxels, or of an unknown volume, cannot be measured.")
    return surface, measure_edge_steps(image.values, surface)
