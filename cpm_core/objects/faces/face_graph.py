"""Graph of faces: which of them share a border, how long it is, and what lies along it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.faces.basins import Labels
from cpm_core.objects.faces.crossings import Crossings
from cpm_core.objects.faces.minimum_cut import Arcs, arcs

_SIDE, _CORNER = np.pi / 8.0, np.pi / 8.0 / np.sqrt(2.0)
"""Length that a pair of pixels with a common side, or corner, stands for: of the Cauchy-Crofton formula with eight
neighbors, which measures straight lines of any direction to within 5 % [px]."""

_STEPS = np.array([(0, 1), (1, 0), (1, 1), (1, -1)])
"""Steps from a pixel to half of its neighbors, the two with a common side first."""


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
    mean : ndarray, shape (F,)
        Mean of its gray levels.
    rim : ndarray, shape (F,)
        Length of its border on that of the image or of the regions of interest [px].
    center : ndarray, shape (F, 2)
        Mean position of its pixels (row, col) [px].
    """

    first: Index
    second: Index
    length: Array
    strength: Array
    along: Array
    barred: Array
    area: Array
    mean: Array
    rim: Array
    center: Array

    @property
    def count(self) -> int:
        """Number of faces."""
        return len(self.area)

    @cached_property
    def arcs(self) -> Arcs:
        """The pairs as a graph to search and to cut."""
        return arcs(self.first, self.second, self.count)


def face_graph(labels: Labels, values: Array, strength: Array, lines: Crossings, barriers: Crossings) -> FaceGraph:
    """Measure faces and their borders.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        Face of every pixel, -1 outside the regions of interest.
    values, strength : ndarray, shape (H, W)
        Image, and its edge map.
    lines, barriers : Crossings
        Where contours, and barriers, pass between pixels.
    """
    count = int(labels.max()) + 1
    row, col, step = _links(labels)
    down, right = row + _STEPS[step, 0], col + _STEPS[step, 1]
    low, high = np.sort([labels[row, col], labels[down, right]], axis=0)
    pairs, number = np.unique((low + 1) * count + high, return_inverse=True)
    low, high = pairs // count - 1, pairs % count
    at_side = step < 2
    crossed = [np.stack([found.right, found.down], axis=-1) >= 0.0 for found in (lines, barriers)]

    def along(values: Array | Mask) -> Array:
        return np.asarray(np.bincount(number.ravel()[at_side], values[at_side], len(pairs)), float)

    sides = along(np.ones(len(step)))
    strengths = along(np.maximum(strength[row, col], strength[down, right]))
    on_line, on_barrier = (along(found[row, col, np.minimum(step, 1)]) for found in crossed)
    length = _SIDE * sides + _CORNER * np.bincount(number.ravel()[~at_side], minlength=len(pairs))
    border = np.zeros(labels.shape)
    border[[0, -1]] += 1.0
    border[:, [0, -1]] += 1.0
    inner, outer = (low >= 0) & (sides > 0), (low < 0) & (sides > 0)
    own, sides = labels.ravel() + 1, sides[inner]
    area, gray, rim, *center = (
        np.asarray(np.bincount(own, weight.ravel(), count + 1)[1:], float)
        for weight in (np.ones(labels.shape), values, border, *np.indices(labels.shape))
    )
    pixels = np.maximum(area, 1.0)
    return FaceGraph(
        first=low[inner],
        second=high[inner],
        length=length[inner],
        strength=strengths[inner] / sides,
        along=on_line[inner] / sides,
        barred=on_barrier[inner] / sides,
        area=area,
        mean=gray / pixels,
        rim=rim + np.bincount(high[outer], length[outer], count),
        center=np.stack(center, axis=1) / pixels[:, None],
    )


def _links(labels: Labels) -> tuple[Index, Index, Index]:
    """Row and column of pixels, and the numbers of the steps from each to one of another face."""
    rows, cols = labels.shape
    beyond = np.pad(labels, ((0, 1), (1, 1)), constant_values=-2)
    ends = np.stack([beyond[d : d + rows, r + 1 : r + 1 + cols] for d, r in _STEPS], axis=-1)
    row, col, step = np.nonzero((ends != labels[..., None]) & (ends > -2))
    return row, col, step
