"""The boundary of a medial axis: the ridge of the edge map as evenly spaced points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.reconstruction import find_contours

_SPACING = 1.0
"""Spacing of the points that contours pass through [px]: less than half the width of the thinnest line."""

_STRIDE = 0.5
"""Distance of neighboring points along the boundary [px]."""

_NEAR, _TANGENT, _OUTWARD = 3.0, 6, 0.3
"""A contour that ends within this distance [px] of the image border is continued beyond it: in the direction of this
many last points if its component toward the border is at least this large, else perpendicular to the border."""

_SHORTEST = 4.0
"""Least length of a boundary, in d_min."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """Points along the edges of an image.

    Attributes
    ----------
    points : ndarray, shape (N, 2)
        Distinct points, half a pixel apart [px].
    neighbors : ndarray of int64, shape (M, 2)
        Pairs of points that follow each other along an edge.
    strength : ndarray, shape (N,)
        Edge strength at the points [gray levels / px].
    """

    points: Array
    neighbors: NDArray[np.int64]
    strength: Array


def find_boundary(scale_field: ScaleField, parameters: Parameters) -> Boundary:
    """Find the edges of an image without seeds, with subpixel accuracy.

    Every pixel above the edge floor is a candidate position of a particle. The rest is the reconstruction of a run:
    ridge, tracing, gaps, contours. A contour that ends at the image border is continued straight beyond it by the size
    of the image, so that an object cut off by the border has no edge there.
    """
    pixels = np.argwhere(scale_field.edge_map >= scale_field.floor).astype(float)
    shortest = max(parameters.min_length, _SHORTEST * parameters.d_min)
    dense = replace(parameters, d_min=_SPACING, d_max=_SPACING, min_length=shortest)
    contours, _ = find_contours(pixels, scale_field, dense)
    if not contours:
        return Boundary(np.zeros((0, 2)), np.zeros((0, 2), np.int64), np.zeros(0))
    paths = [_continued(_evenly(contour), scale_field.shape) for contour in contours]
    start = np.cumsum([0, *map(len, paths)])
    distinct, index = np.unique(np.concatenate(paths), axis=0, return_inverse=True)  # junctions occur more than once
    index = index.ravel()
    pairs = [np.stack([index[a : b - 1], index[a + 1 : b]], axis=1) for a, b in pairwise(start)]
    return Boundary(distinct, np.concatenate(pairs), scale_field.strength(distinct))


def _evenly(contour: Contour) -> Array:
    """Points along a contour, including its vertices; of a closed one the first is repeated at the end."""
    path = contour.path
    parts = [path[:1]]
    for a, b in pairwise(path):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / _STRIDE)))
        steps = np.arange(1, count + 1)[:, None] / count
        parts.append(np.where(steps == 1.0, b, a + (b - a) * steps))
    return np.concatenate(parts)


def _continued(path: Array, shape: tuple[int, ...]) -> Array:
    """Path with straight continuations at the image border."""
    if (path[0] == path[-1]).all():
        return path
    before, behind = _continuation(path[::-1], shape), _continuation(path, shape)
    return np.concatenate([before[::-1], path, behind])


def _continuation(path: Array, shape: tuple[int, ...]) -> Array:
    """Points from the end of a path out of the image; none if it ends inside."""
    size = np.array(shape, dtype=float)
    end = path[-1]
    beyond = np.concatenate([end, size - 1.0 - end])
    side = int(np.argmin(beyond))
    if beyond[side] > _NEAR:
        return path[:0]
    outwards = np.zeros(2)
    outwards[side % 2] = -1.0 if side < 2 else 1.0
    along = end - path[-min(len(path), _TANGENT)]
    along = along / max(float(np.linalg.norm(along)), 1e-300)
    direction = along if along @ outwards >= _OUTWARD else outwards
    return np.asarray(end + direction * np.arange(_STRIDE, size.max(), _STRIDE)[:, None])
