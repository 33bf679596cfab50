"""Confidence: the probability that an object is the intended one, estimated from a few features.

The estimate is a logistic regression. `tests/benchmarks/prior/sure.py` learns its weights from objects that are used
for nothing else, neither training nor measurements, and writes them with their origin to `confidence.json`.
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


def encode_features(signs: ConfidenceFeatures) -> Array:
    """Encode the features as inputs of the logistic regression, shape (7,)."""
    shares = scipy.special.logit(np.clip(signs[:4], 1.0 - _MAX_CONFIDENCE, _MAX_CONFIDENCE))
    return np.array([*shares, np.log(max(signs.point_count, 1)), signs.point_count == 0, signs.unambiguous])


def estimate_confidence(signs: ConfidenceFeatures) -> float:
    """Estimate the probability that an object is correct, by the logistic rule of this module."""
    *weights, offset = _load_weights()
    return min(float(scipy.special.expit(np.array(weights) @ encode_features(signs) + offset)), _MAX_CONFIDENCE)


@cache
def _load_weights() -> tuple[float, ...]:
    """Load the weights of the rule, and last its offset."""
    stored = json.loads(files("cpm_core.objects").joinpath("confidence.json").read_text("utf-8"))
    return tuple(stored["numbers"])
