"""Trees: a score for the object that a drawn start means, the sum of what many small decision trees say of it.

The trees were grown by gradient boosting, so that the overlap to be expected with what people have outlined is largest,
if a candidate is drawn with the probability ``exp(score) / sum(exp(score))``. They stand in `trees.json`, which
`tests/benchmarks/ranking/fit_ranking.py` writes: on candidates in 6 micrographs of the Data Science Bowl 2018 (CC0), 8
ultrasound images of BUSI and 8 photographs of Weizmann's horses (no terms stated), on scenes drawn with ten silhouettes
of MPEG-7 and textures of scikit-image, and on drawn shapes and cells. None of these images is part of the program.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index

TREES_FILE = Path(__file__).with_name("trees.json")


@dataclass(frozen=True, eq=False)
class Trees:
    """Decision trees for the same features.

    Attributes
    ----------
    features : tuple of str
        The features, in their order.
    roots : ndarray of int64, shape (T,)
        First node of each tree.
    feature : ndarray of int64, shape (N,)
        Number of the feature that a node asks for; -1 for a leaf.
    value : ndarray, shape (N,)
        Value up to which a node continues to the left; what a leaf says.
    left, right : ndarray of int64, shape (N,)
        The following nodes.
    """

    features: tuple[str, ...]
    roots: Index
    feature: Index
    value: Array
    left: Index
    right: Index

    def scores(self, features: Array) -> Array:
        """Scores of candidates with features of shape (N, K), shape (N,)."""
        return _scores(
            np.ascontiguousarray(features, float), self.roots, self.feature, self.value, self.left, self.right
        )


@cache
def trees(name: str) -> Trees:
    """The trees of this name in the file."""
    return trees_of(json.loads(TREES_FILE.read_text(encoding="utf-8"))[name])


def trees_of(stored: dict[str, list[object]]) -> Trees:
    """Trees as the file holds them: the nodes of all, one list for each attribute."""
    numbers = {key: np.array(stored[key], np.int64) for key in ("roots", "feature", "left", "right")}
    return Trees(tuple(str(name) for name in stored["features"]), value=np.array(stored["value"], float), **numbers)


@compiled
def _scores(features: Array, roots: Index, feature: Index, value: Array, left: Index, right: Index) -> Array:
    found = np.zeros(len(features))
    for i in range(len(features)):
        for root in roots:
            k = root
            while feature[k] >= 0:
                k = left[k] if features[i, feature[k]] <= value[k] else right[k]
            found[i] += value[k]
    return found
