"""How sure an object is: the probability that it is what is meant, estimated from what speaks for it.

The rule is a logistic one with few numbers. `tests/benchmarks/prior/sure.py` learns them from objects by which nothing
else is learned or measured, and writes them with their origin to `confidence.json`.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.types import Array

RIGHT = 0.8
"""Overlap (intersection over union) with what is meant from which an object is right."""

_SUREST = 0.98
"""Largest overlap that counts as such, and the largest probability."""


class Signs(NamedTuple):
    """What speaks for an object.

    Attributes
    ----------
    overlap, clarity, steadiness, agreement : float
        What the prior says of it; see `prior.Likely`.
    places : int
        Number of places that it has been chosen by, 0 where it was found without any.
    certain : bool
        Whether a contour that is certain encloses it.
    """

    overlap: float = 0.5
    clarity: float = 0.5
    steadiness: float = 0.5
    agreement: float = 0.5
    places: int = 1
    certain: bool = False


def features(signs: Signs) -> Array:
    """What the rule weighs, shape (7,)."""
    shares = scipy.special.logit(np.clip(signs[:4], 1.0 - _SUREST, _SUREST))
    return np.array([*shares, np.log(max(signs.places, 1)), signs.places == 0, signs.certain])


def probability(signs: Signs) -> float:
    """Probability that an object is right, from what speaks for it."""
    *weights, offset = _numbers()
    return min(float(scipy.special.expit(np.array(weights) @ features(signs) + offset)), _SUREST)


@cache
def _numbers() -> tuple[float, ...]:
    stored = json.loads(files("cpm_core.objects").joinpath("confidence.json").read_text("utf-8"))
    return tuple(stored["numbers"])
