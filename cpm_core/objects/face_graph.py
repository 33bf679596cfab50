"""Graph of faces: which of them share a border, how long it is, and what lies along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.faces import Labels

_SIDE, _CORNER = np.pi / 8.0, np.pi / 8.0 / np.sqrt(2.0)
"""Length that a pair of pixels with a common side, or corner, stands for: of the Cauchy-Crofton formula with eight
neighbors, which measures straight lines of any direction to within 5 % [px]."""


@dataclass(frozen=True, eq=False)
class FaceGraph:
    """Faces and pairs of neighbors, as arrays over F faces and E pairs.

    Attributes
    ----------
    first, second : ndarray of int64, shape (E,)
        The faces of each pair, ``first < second``.
    length : ndarray, shape (E,)
        Length of their common border [px].
    strength : ndarray, shape (E,)
        Mean edge strength along it [gray levels / px].
    along : ndarray, shape (E,)
        Share of it that lies on a contour, 0 to 1.
    barred : ndarray, shape (E,)
        Share of it that lies on a barrier, 0 to 1.
    area : ndarray, shape (F,)
        Pixels of each face.
    mean, deviation : ndarray, shape (F,)
        Mean and standard deviation of its gray levels.
    rim : ndarray, shape (F,)
        Length of its border on that of the image or of the regions of interest [px].
    """

    first: Index
    second: Index
    length: Array
    strength: Array
    along: Array
    barred: Array
    area: Array
    mean: Array
    deviation: Array
    rim: Array

    @property
    def count(self) -> int:
        """Number of faces."""
        return len(self.area)


def face_graph(labels: Labels, values: Array, strength: Array, wall: Mask, barrier: Mask) -> FaceGraph:
    """Measure faces and their borders.

    `labels` has the face of every pixel, below 0 outside the regions of interest; `values`, `strength`, `wall` and
    `barrier` are the image, its edge map, and the pixels of contours and barriers, all of shape (H, W).
    """
    count = int(labels.max()) + 1
    keys, sides = [], []
    for p, q in (np.s_[:-1, :], np.s_[1:, :]), (np.s_[:, :-1], np.s_[:, 1:]):
        differ = labels[p] != labels[q]
        keys.append(_key(labels[p][differ], labels[q][differ], count))
        sides.append(
            np.stack(
                [
                    np.maximum(strength[p][differ], strength[q][differ]),
                    (wall[p] | wall[q])[differ],
                    (barrier[p] | barrier[q])[differ],
                ]
            )
        )
    pair, place = np.unique(np.concatenate(keys), return_inverse=True)
    values_of = np.concatenate(sides, axis=1)
    sums = [np.bincount(place, row, len(pair)) for row in values_of]
    number = np.bincount(place, minlength=len(pair))
    corners = np.concatenate(
        [
            _key(labels[:-1, :-1].ravel(), labels[1:, 1:].ravel(), count),
            _key(labels[:-1, 1:].ravel(), labels[1:, :-1].ravel(), count),
        ]
    )
    nearest = np.minimum(np.searchsorted(pair, corners), max(len(pair) - 1, 0))
    diagonal = np.bincount(nearest[pair[nearest] == corners], minlength=len(pair)) if len(pair) else number
    length = _SIDE * number + _CORNER * diagonal
    first, second = pair // (count + 1) - 1, pair % (count + 1) - 1
    inner = first >= 0
    face = labels.ravel()
    within = face >= 0
    area = np.bincount(face[within], minlength=count).astype(float)
    gray = values.ravel()[within]
    mean = np.bincount(face[within], gray, count) / area
    square = np.bincount(face[within], (gray - mean[face[within]]) ** 2, count) / area
    rim = np.bincount(second[~inner], length[~inner], count) + _on_border(labels, count)
    strengths, along, barred = (total[inner] / number[inner] for total in sums)
    return FaceGraph(
        first[inner], second[inner], length[inner], strengths, along, barred, area, mean, np.sqrt(square), rim
    )


def _key(a: Labels, b: Labels, count: int) -> Index:
    """Number of a pair of faces that does not depend on their order; face -1 counts."""
    low, high = np.minimum(a, b).astype(np.int64), np.maximum(a, b).astype(np.int64)
    return np.asarray((low + 1) * (count + 1) + high + 1)


def _on_border(labels: Labels, count: int) -> Array:
    sides = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    return np.bincount(sides[sides >= 0], minlength=count).astype(float)
