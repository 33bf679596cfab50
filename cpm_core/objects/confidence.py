"""Confidence: the probability that an object is the intended one, estimated from a few features.

The estimate is a logistic regression, with weights of their own for objects that a prompt selects and for those that
are found everywhere. `tests/benchmarks/prior/sure.py` and `tests/benchmarks/prior/found.py` learn them from objects
that are used for nothing else, neither training nor measurements, and write them with their origin to
`confidence.json` and `confidence_everywhere.json`.
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

FAINT = 0.005
"""Strength and variation below which a smaller one makes little difference."""

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
        Number of points that it was selected by; 0 if it was found without any.
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
        Features of the prediction of the network with the region as the previous mask; see `prior.Prediction`.
    rivalry : float
        By how much the overlap that the network predicts is larger for other regions with the same pixels, on average.
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
    unambiguous : bool
        Whether an unambiguous contour encloses it.
    has_neck : bool
        Whether it has bodies on both sides of a neck.
    """

    predicted_iou: float
    mean_certainty: float
    iou_to_previous: float
    rivalry: float
    area: float
    solidity: float
    border_share: float
    strength: float
    weakest: float
    inside: float
    variation: float
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


class ChoiceFeatures(NamedTuple):
    """Features of a body around a click that tell whether it is meant, rather than others there.

    Attributes
    ----------
    solidity : float
        The volume within its surface, in volumes of its convex hull.
    volume : float
        The volume within its surface [voxels].
    gap_share : float
        Share of its surface across which gray levels hardly rise.
    """

    solidity: float
    volume: float
    gap_share: float


def encode_features(signs: ConfidenceFeatures) -> Array:
    """Encode the features as inputs of the logistic regression, shape (7,)."""
    shares = scipy.special.logit(np.clip(signs[:4], 1.0 - _MAX_CONFIDENCE, _MAX_CONFIDENCE))
    return np.array([*shares, np.log(max(signs.point_count, 1)), signs.point_count == 0, signs.unambiguous])


def estimate_confidence(signs: ConfidenceFeatures) -> float:
    """Estimate the probability that an object is correct, by the logistic rule of this module."""
    *weights, offset = _load_weights("confidence.json")
    return min(float(scipy.special.expit(np.array(weights) @ encode_features(signs) + offset)), _MAX_CONFIDENCE)


def encode_region(signs: RegionFeatures) -> Array:
    """Encode the features of a region as inputs of the logistic regression, shape (13,)."""
    shares = scipy.special.logit(np.clip(signs[:3], 1.0 - _MAX_CONFIDENCE, _MAX_CONFIDENCE))
    rest = signs.solidity, signs.border_share, np.log(signs.strength + FAINT), signs.weakest
    size = np.log(min(signs.area, LARGE_AREA))
    inner = min(signs.inside, _MAX_INSIDE)
    return np.array(
        [
            *shares,
            signs.rivalry,
            size,
            *rest,
            inner,
            np.log(signs.variation + FAINT),
            signs.unambiguous,
            signs.has_neck,
        ]
    ).astype(float)


def estimate_region_confidence(signs: RegionFeatures) -> float:
    """Estimate the probability that a region found everywhere is an object."""
    *weights, offset = _load_weights("confidence_everywhere.json")
    return min(float(scipy.special.expit(np.array(weights) @ encode_region(signs) + offset)), _MAX_CONFIDENCE)


def encode_body(signs: BodyFeatures) -> Array:
    """Encode the features of a body as inputs of the logistic regression, shape (4,)."""
    size = np.log(min(signs.volume, LARGE_VOLUME))
    return np.array([np.log(signs.steadiness + FAINT), signs.solidity, size, signs.cut_share])


def estimate_body_confidence(signs: BodyFeatures) -> float:
    """Estimate the probability that a body of a volume is an object."""
    *weights, offset = _load_weights("confidence_bodies.json")
    return min(float(scipy.special.expit(np.array(weights) @ encode_body(signs) + offset)), _MAX_CONFIDENCE)


def encode_choice(signs: ChoiceFeatures) -> Array:
    """Encode what tells the body that a click means from others around it, shape (3,)."""
    return np.array([signs.solidity, np.log(signs.volume), signs.gap_share])


def rank_body(signs: ChoiceFeatures) -> float:
    """Return how much likelier than others around a click a body is to be meant [difference of logarithms]."""
    return float(np.array(_load_weights("confidence_bodies.json", "choice")) @ encode_choice(signs))


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
    *weights, offset = _load_weights("confidence_everywhere.json", "siblings")
    odds = np.array(weights) @ encode_siblings(confidence, agreement, amount, weakness) + offset
    return min(float(scipy.special.expit(odds)), _MAX_CONFIDENCE)


@cache
def _load_weights(name: str, rule: str = "numbers") -> tuple[float, ...]:
    """Load the weights of a rule, and last its offset, from a file of this folder."""
    stored = json.loads(files("cpm_core.objects").joinpath(name).read_text("utf-8"))
    return tuple(stored[rule])
