"""Ranking: a score for candidates by their features.

The weights were fitted to the candidates around clicks of a simulated person in 26 photographs, ultrasound images and
micrographs in which people had outlined 103 objects: the expected overlap with the outline was maximized, the candidate
being drawn with the probability ``exp(score) / sum(exp(score))``. `tests/benchmarks/fit_ranking.py` fits them again.
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
    "cut": (0.209, 0.406, 0.219),
})  # fmt: skip
"""For the object around a first click."""

CHANGES = Ranking({
    "edge": (0.867, 0.132, 0.478),
    "weak": (0.165, 0.225, -0.350),
    "contrast": (-0.089, 0.910, 0.198),
    "texture": (0.614, 0.284, -0.475),
    "border": (0.091, 0.156, 0.194),
    "more edge": (-0.049, 0.110, 0.577),
    "more weak": (0.079, 0.184, -0.477),
    "more contrast": (-0.351, 0.812, 0.235),
    "more border": (0.005, 0.109, 0.325),
    "more roundness": (0.113, 0.770, -0.551),
    "more depth": (-0.054, 0.217, 0.879),
    "depth of click": (0.490, 0.366, 1.659),
    "new edge": (0.820, 0.164, 0.667),
    "old edge": (0.871, 0.154, 0.566),
    "new share": (0.614, 0.222, -0.675),
    "new contrast": (-0.402, 0.953, -0.080),
    "old contrast": (0.036, 0.755, -0.425),
    "likeness": (-0.980, 1.868, 0.401),
    "thickness": (1.948, 1.162, -0.251),
    "variation": (-1.013, 0.871, -0.418),
    "share": (-1.727, 2.106, -0.388),
    "size": (6.072, 2.381, -0.326),
    "adding": (0.611, 0.488, -0.000),
    "by cut": (0.076, 0.265, 0.706),
    "by disk": (0.093, 0.290, -0.615),
    "by margin": (0.135, 0.342, -0.549),
    "by local cut": (0.171, 0.376, 0.483),
    "by local level": (0.142, 0.349, 0.774),
})  # fmt: skip
"""For the change that a further click means."""
