"""Ranking: a score for candidates by their features.

The weights were fitted to the candidates around clicks of a simulated person in 26 photographs, ultrasound images and
micrographs in which people had outlined 103 objects: the expected overlap with the outline was maximized, the candidate
being drawn with the probability ``exp(score) / sum(exp(score))``. `tests/benchmarks/ranking/fit_ranking.py` fits them
again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cpm_core.numerics.types import Array

_LIMIT = 3.0
"""Features farther from their mean count as so many standard deviations."""


@dataclass(frozen=True, eq=False)
class Ranking:
    """A score linear in features.

    Attributes
    ----------
    weights : dict of str to (float, float, float)
        Of each feature, in their order: mean, standard deviation, and the weight of one standard deviation.
    """

    weights: dict[str, tuple[float, float, float]]

    def scores(self, features: Array) -> Array:
        """Scores of candidates with features of shape (N, K), shape (N,)."""
        mean, deviation, weight = np.array(list(self.weights.values())).T
        return np.asarray(np.clip((features - mean) / deviation, -_LIMIT, _LIMIT) @ weight)


FIRST = Ranking({
    "edge": (0.813, 0.151, 0.698),
    "weak": (0.261, 0.277, -0.518),
    "depth": (0.567, 0.279, 0.713),
    "border": (0.122, 0.170, -0.113),
    "step": (0.139, 0.932, 0.649),
    "by cut": (0.209, 0.406, 0.219),
})  # fmt: skip
"""For the object around a first click."""

CHANGES = Ranking({
    "edge": (0.863, 0.136, 0.465),
    "weak": (0.172, 0.233, -0.336),
    "contrast": (-0.109, 0.920, 0.168),
    "texture": (0.615, 0.284, -0.511),
    "border": (0.096, 0.159, 0.262),
    "more edge": (-0.050, 0.114, 0.560),
    "more weak": (0.081, 0.189, -0.461),
    "more contrast": (-0.360, 0.814, 0.248),
    "more border": (0.004, 0.113, 0.384),
    "more roundness": (0.135, 0.802, -0.628),
    "more depth": (-0.049, 0.220, 0.938),
    "depth of click": (0.488, 0.366, 1.796),
    "new edge": (0.816, 0.168, 0.682),
    "old edge": (0.865, 0.159, 0.553),
    "new share": (0.618, 0.224, -0.680),
    "new contrast": (-0.409, 0.954, -0.055),
    "old contrast": (0.040, 0.761, -0.361),
    "likeness": (-1.008, 1.848, 0.391),
    "thickness": (1.984, 1.180, -0.233),
    "variation": (-1.027, 0.867, -0.386),
    "share": (-1.694, 2.113, -0.353),
    "size": (6.142, 2.411, -0.288),
    "adding": (0.611, 0.487, 0.000),
    "instability": (0.300, 0.793, 0.015),
    "by cut": (0.078, 0.269, 0.675),
    "by disk": (0.094, 0.291, -0.659),
    "by margin": (0.131, 0.338, -0.539),
    "by local cut": (0.174, 0.379, 0.535),
    "by local level": (0.139, 0.346, 0.836),
})  # fmt: skip
"""For the change that a further click means."""
