"""How sure an object is: the probability that it is what is meant, estimated from what speaks for it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

RIGHT = 0.8
"""Overlap (intersection over union) with what is meant from which an object is right."""


class Signs(NamedTuple):
    """What speaks for an object.

    Attributes
    ----------
    overlap, clarity, steadiness, agreement : float
        What the prior says of it; see `prior.Likely`.
    support : float
        How well the image supports its boundary, 0 to 1; see `outline.support_of`.
    places : int
        Number of places that it has been chosen by.
    pixels : int
        Its area.
    certain : bool
        Whether a contour that is certain encloses it.
    """

    overlap: float = 0.5
    clarity: float = 0.5
    steadiness: float = 0.5
    agreement: float = 0.5
    support: float = 0.0
    places: int = 1
    pixels: int = 0
    certain: bool = False


def probability(signs: Signs) -> float:
    """Probability that an object is right, from what speaks for it."""
    if signs.certain:
        return 0.97
    return float(np.clip(signs.overlap * signs.clarity * np.sqrt(signs.steadiness), 0.01, 0.99))
