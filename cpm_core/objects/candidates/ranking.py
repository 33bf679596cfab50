"""Ranking: a score for candidates by their features."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cpm_core.numerics.types import Array

_LIMIT = 3.0
"""Standardized features beyond this count as it."""


@dataclass(frozen=True, eq=False)
class Ranking:
    """A score of K features: the sum of ``a x + b x^2``, x being a feature in standard deviations from its mean.

    Attributes
    ----------
    mean, deviation, linear, square : ndarray, shape (K,)
        Mean and standard deviation of each feature, and its weights a and b.
    """

    mean: Array
    deviation: Array
    linear: Array
    square: Array

    def scores(self, features: Array) -> Array:
        """Scores of candidates with features of shape (N, K), shape (N,)."""
        x = np.clip((features - self.mean) / self.deviation, -_LIMIT, _LIMIT)
        return np.asarray(x @ self.linear + x**2 @ self.square)


_N = np.zeros(11), np.ones(11), np.zeros(11), np.zeros(11)
FIRST = Ranking(*_N)
_N = np.zeros(28), np.ones(28), np.zeros(28), np.zeros(28)
CHANGES = Ranking(*_N)
