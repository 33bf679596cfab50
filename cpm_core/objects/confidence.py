"""Confidence: the probability that an object is the intended one, estimated from a few features.

The estimate is a logistic regression, with weights of their own for objects that a prompt selects, for those that are
found everywhere, for bodies of volumes and for what lies in them; a score of the same kind tells which of several
bodies a click means. `sure.py`, `found.py`, `sure_bodies.py`, `sure_inner_parts.py` and `meant_bodies.py` in
`tests/benchmarks/prior` learn the weights from objects that are used for nothing else, neither training nor
measurements, and write them with their origin to `confidence.json`, `confidence_everywhere.json` and
`confidence_bodies.json`.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.types import Array

CORRECT_IOU = 0.8
"""Overlap (intersection over union) with the intended object from which an object counts as correct."""

_MAX_CONFIDENCE = 0.98
"""Largest probability, and largest overlap that a feature counts."""

LARGE_AREA = 1100.0
"""Area above which a larger one makes no difference [px²]."""

LARGE_VOLUME = 1000.0
"""Volume above which a larger one makes no difference [voxels]."""

_LARGE_CONTRAST = 60.0
"""Contrast above which a larger one makes no difference [standard deviations of smoothed gray levels]."""

_MAX_SHARPNESS = 1.5
"""Sharpness above which a larger one makes no difference."""

_LARGE_UNEVENNESS = 5.0
"""Unevenness above which a larger one makes no difference."""

ROUND = 0.65
"""Sphericity above which a larger one makes no difference, as noise roughens surfaces."""

FAINT = 0.005
"""Strength and variation below which a smaller one makes little difference."""

_PERCENT_TOLERANCE = 1e-9
"""Largest error of floating point when a confidence is multiplied by 100."""

_MAX_POINT_COUNT = 4
"""Number of points above which more make no difference: the weights were learned from so many clicks, no strokes."""

_FEW_SIBLINGS = 0.5
"""Weight of siblings from which more of them make little difference."""

_MAX_INSIDE = 3.0
"""Strength of the inside above which a larger one makes no difference."""


class ConfidenceFeatures(NamedTuple):
    """Features of an object that its confidence is estimated from.

    Attributes
    ----------
    predicted_iou, mean_certainty, iou_to_previous, iou_to_other_crop : float
        Features of the prediction of the network; see `prior.Prediction`.
    point_count : int
        Number of points that it was selected by, of which what was drawn counts as one; 0 if there were none.
    unambiguous : bool
        Whether an unambiguous contour encloses it.
    """

    predicted_iou: float = 0.5
    mean_certainty: float = 0.5
    iou_to_previous: float = 0.5
    iou_to_other_crop: float = 0.5
    point_count: int = 1
    unambiguous: bool = False


class RegionFeatures(NamedTuple):
    """Features of a region found everywhere that the probability of its being an object is estimated from.

    Attributes
    ----------
    predicted_iou, mean_certainty, iou_to_previous : float
        Features of the prediction of the network with it as the previous mask, or of the one that found it, which then
        has none before and overlaps with itself; see `prior.Prediction`.
    area : float
        Its area [px²].
    solidity : float
        Its area with its holes, in areas of its convex hull.
    border_share : float
        Share of its boundary that is the border of the image.
    strength : float
        Mean edge strength along the boundary, in differences between white and black [1 / px].
    weakest, inside : float
        Edge strength where the boundary is weakest, and where the inside is strongest, in medians along the boundary.
    variation : float
        Standard deviation of the gray levels inside, in differences between white and black.
    bounded : bool
        Whether contours bound it; otherwise it is what the network takes a point for.
    unambiguous : bool
        Whether an unambiguous contour encloses it.
    has_neck : bool
        Whether it has bodies on both sides of a neck.
    """

    predicted_iou: float
    mean_certainty: float
    iou_to_previous: float
    area: float
    solidity: float
    border_share: float
    strength: float
    weakest: float
    inside: float
    variation: float
    bounded: bool
    unambiguous: bool
    has_neck: bool


class BodyFeatures(NamedTuple):
    """Features of a body in a volume that the probability of its being an object is estimated from.

    Attributes
    ----------
    steadiness : float
        By how much gray levels rise across its surface, in standard deviations of this rise along it.
    solidity : float
        Its volume, in volumes of its convex hull.
    volume : float
        Number of its voxels.
    cut_share : float
        Share of its surface that is the end of the volume.
    """

    steadiness: float
    solidity: float
    volume: float
    cut_share: float


class InnerFeatures(NamedTuple):
    """Features of what lies in a body of a volume that the probability of its being an object is estimated from.

    Attributes
    ----------
    contrast : float
        Difference of its gray level from those around it, in standard deviations of these once smoothed.
    sharpness : float
        By how much gray levels rise across its surface, in this difference.
    unevenness : float
        Standard deviation of its gray levels, in that of those around it.
    volume : float
        Number of its voxels.
    sphericity : float
        The area of a ball of its volume, in areas of its surface.
    """

    contrast: float
    sharpness: float
    unevenness: float
    volume: float
    sphericity: float


class ChoiceFeatures(NamedTuple):
    """Features of a body around a click that tell whether it is meant, rather than others there.

    Attributes
    ----------
    sphericity : float
        The area of a ball of its volume, in areas of its surface.
    volume : float
        The volume within its surface [voxels].
    gap_share : float
        Share of its surface across which gray levels hardly rise.
    """

    sphericity: float
    volume: float
    gap_share: float


def whole_percent(confidence: float) -> float:
    """Return a confidence in whole percent, rounded down: no doubtful object is shown with that of a likely one."""
    return float(np.floor(100.0 * confidence + _PERCENT_TOLERANCE))


def encode_features(features: ConfidenceFeatures) -> Array:
    """Encode the features as inputs of the logistic regression, shape (8,).

    The last one is for what a single point or drawing selects, of which the prediction says less.
    """
    shares = scipy.special.logit(np.clip(features[:4], 1.0 - _MAX_CONFIDENCE, _MAX_CONFIDENCE))
    count = features.point_count
    alone = shares.mean() if count == 1 else 0.0
    return np.array([*shares, np.log(np.clip(count, 1, _MAX_POINT_COUNT)), count == 0, features.unambiguous, alone])


def estimate_confidence(features: ConfidenceFeatures) -> float:
    """Estimate the probability that an object is correct."""
    return _estimate_probability("confidence.json", encode_features(features))


def encode_region(features: RegionFeatures) -> Array:
    """Encode the features of a region as inputs of the logistic regression, shape (14,)."""
    shares = scipy.special.logit(np.clip(features[:3], 1.0 - _MAX_CONFIDENCE, _MAX_CONFIDENCE))
    return np.array(
        [
            *shares,
            np.log(min(features.area, LARGE_AREA)),
            features.solidity,
            features.border_share,
            np.log(features.strength + FAINT),
            features.weakest,
            min(features.inside, _MAX_INSIDE),
            np.log(features.variation + FAINT),
            features.bounded,
            features.unambiguous,
            features.has_neck,
            features.bounded * features.predicted_iou,
        ]
    )


def estimate_region_confidence(features: RegionFeatures) -> float:
    """Estimate the probability that a region found everywhere is an object."""
    return _estimate_probability("confidence_everywhere.json", encode_region(features))


def encode_body(features: BodyFeatures) -> Array:
    """Encode the features of a body as inputs of the logistic regression, shape (4,)."""
    size = np.log(min(features.volume, LARGE_VOLUME))
    return np.array([np.log(features.steadiness + FAINT), features.solidity, size, features.cut_share])


def estimate_body_confidence(features: BodyFeatures) -> float:
    """Estimate the probability that a body of a volume is an object."""
    return _estimate_probability("confidence_bodies.json", encode_body(features))


def encode_inner(features: InnerFeatures) -> Array:
    """Encode the features of what lies in a body as inputs of the logistic regression, shape (5,)."""
    contrast, sharpness, unevenness, volume, sphericity = features
    return np.array(
        [
            np.log(min(contrast, _LARGE_CONTRAST) + FAINT),
            min(max(sharpness, 0.0), _MAX_SHARPNESS),
            np.log(min(unevenness, _LARGE_UNEVENNESS) + FAINT),
            np.log(min(volume, LARGE_VOLUME)),
            sphericity,
        ]
    )


def estimate_inner_confidence(features: InnerFeatures) -> float:
    """Estimate the probability that what lies in a body of a volume is an object."""
    return _estimate_probability("confidence_bodies.json", encode_inner(features), "inner")


def encode_choice(features: ChoiceFeatures) -> Array:
    """Encode the features of a body around a click as inputs of the score, shape (3,)."""
    return np.array([np.log(min(features.sphericity, ROUND) + FAINT), np.log(features.volume), features.gap_share])


def score_choice(features: ChoiceFeatures) -> float:
    """Score how likely it is that a click means a body, to compare those around it [log odds but for a constant]."""
    return float(np.array(load_weights("confidence_bodies.json", "choice")) @ encode_choice(features))


def encode_siblings(confidence: float, agreement: float, amount: float, weakness: float) -> Array:
    """Encode what the siblings of a region say as inputs of the logistic regression, shape (4,)."""
    said = np.array([agreement, amount, weakness]) / (amount + _FEW_SIBLINGS)
    return np.array([scipy.special.logit(confidence), *said])


def estimate_among_siblings(confidence: float, agreement: float, amount: float, weakness: float) -> float:
    """Estimate the probability that a region found everywhere is an object beside others that are likely.

    Parameters
    ----------
    confidence : float
        The probability without them.
    agreement, amount : float
        Sum of their weights, negative for those at whose edges the gray levels change the other way; without a sign.
    weakness : float
        By how much its boundary is weaker than theirs on average, as a logarithm times the sum of their weights.
    """
    encoded = encode_siblings(confidence, agreement, amount, weakness)
    return _estimate_probability("confidence_everywhere.json", encoded, "siblings")


def _estimate_probability(name: str, encoded: Array, rule: str = "numbers") -> float:
    """Estimate a probability from encoded features by a rule of a file of this folder."""
    *weights, offset = load_weights(name, rule)
    return min(float(scipy.special.expit(np.array(weights) @ encoded + offset)), _MAX_CONFIDENCE)


@cache
def load_weights(name: str, rule: str) -> tuple[float, ...]:
    """Load the weights of a rule, last its offset if it estimates a probability, from a file of this folder."""
    stored = json.loads(files("cpm_core.objects").joinpath(name).read_text("utf-8"))
    return tuple(stored[rule])
