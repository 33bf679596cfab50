"""Surfaces around voxels, and surfaces that follow voxels where these were painted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy

from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import bounding_window, expand_window, first_pixel, zero_surface
from cpm_core.numerics.types import Array, Index, Integers, Mask

_SMOOTHING = 0.8
"""Standard deviation that smooths the steps between voxels for a surface [voxels]."""

_EMPTY_MARGIN = 3
"""Empty voxels added on all sides before a surface is built [voxels]."""

_MIN_LEVEL_OFFSET = 0.15
"""Least difference of a smoothed voxel from the level of the surface, so that it stays on its side."""

_PLANES_PER_PIECE = 16
"""Planes of a surface that are built at once: meanwhile the interpreter does nothing else."""

_PATCH_REACHES = (2.0, 2.5, 3.0, 3.5, 4.0)
"""Distances from painted voxels within which a surface is replaced, tried one after the other [voxels]."""


def surround_voxels(mask: Mask, origin: Integers) -> Surface:
    """Build the surface around exactly the true voxels of a mask that begins at a voxel."""
    inside = np.pad(mask, _EMPTY_MARGIN)
    level = scipy.ndimage.gaussian_filter(inside.astype(np.float32), _SMOOTHING) - np.float32(0.5)
    level = np.where(inside, np.maximum(level, _MIN_LEVEL_OFFSET), np.minimum(level, -_MIN_LEVEL_OFFSET))
    # a few planes at a time, so that the window gets its turn; vertices on the planes between occur twice
    ends = pairwise([*range(0, len(level) - 1, _PLANES_PER_PIECE), len(level) - 1])
    inner = [(0, side) for side in level.shape[1:]]
    parts = [zero_surface(level, ((first, last + 1), *inner)) for first, last in ends]
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = np.concatenate([part for part, _ in parts])
    faces = np.concatenate([part + count for (_, part), count in zip(parts, counts, strict=False)])
    order = np.lexsort(vertices.T)  # much faster than np.unique(axis=0)
    ordered = vertices[order]
    is_new = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    numbers = np.empty(len(order), np.int64)
    numbers[order] = np.cumsum(is_new) - 1
    return Surface(ordered[is_new] + np.array(origin) - _EMPTY_MARGIN, numbers[faces])


def follow_painted_voxels(surface: Surface, before: Mask, after: Mask, origin: Integers) -> Surface:
    """Replace a closed surface near voxels that were painted, and leave the rest of it as it is.

    Parameters
    ----------
    surface : Surface
        Closed surface [voxels].
    before, after : ndarray of bool, shape (P, R, C)
        The voxels inside before and after they were painted, in a box that begins at `origin`.
    origin : tuple of int
        First voxel of the box.

    Returns
    -------
    Surface
        Closed surface; around exactly the painted voxels where the two cannot be joined.
    """
    changed = before != after
    if not changed.any():
        return surface
    reach = int(max(_PATCH_REACHES)) + _EMPTY_MARGIN
    window = expand_window(bounding_window(changed), reach, changed.shape)
    first = np.array(origin) + first_pixel(window)
    away = scipy.ndimage.distance_transform_edt(~np.pad(changed[window], reach))
    patch = surround_voxels(after[window], tuple(first.tolist()))
    distances = [_look_up(away, body.vertices - first + reach) for body in (surface, patch)]
    for limit in _PATCH_REACHES:
        gone = np.asarray((distances[0][surface.faces] <= limit).any(axis=1))
        new = patch.faces[(distances[1][patch.faces] <= limit).all(axis=1)]
        joined = _replace_faces(surface, gone, patch.vertices, new)
        if joined is not None:
            return joined
    return replace(surround_voxels(after, origin), spacing=surface.spacing, unit=surface.unit)


def _look_up(values: Array, places: Array) -> Array:
    """Look up values at places, shape (N, 3) [voxels]; infinite outside."""
    return np.asarray(scipy.ndimage.map_coordinates(values, places.T, order=1, cval=np.inf))


def _replace_faces(surface: Surface, gone: Mask, vertices: Array, new: Index) -> Surface | None:
    """Replace triangles of a closed surface by others, with strips between the rims; None where these do not match."""
    while len(pinched := _find_pinches(surface.faces[gone])):
        gone |= np.isin(surface.faces, pinched).any(axis=1)
    while len(pinched := _find_pinches(new)):
        new = new[~np.isin(new, pinched).any(axis=1)]
    rims, opposite = _trace_rims(surface.faces[gone]), _trace_rims(new)
    if len(rims) != len(opposite):
        return None
    count = len(surface.vertices)
    places = np.concatenate([surface.vertices, vertices])
    opposite = [[at + count for at in rim] for rim in opposite]
    patch = [new + count]
    if rims:
        trees = [scipy.spatial.cKDTree(places[rim]) for rim in opposite]
        apart = np.array([[np.mean(tree.query(places[rim])[0]) for tree in trees] for rim in rims])
        for i, j in zip(*scipy.optimize.linear_sum_assignment(apart), strict=True):
            patch.append(np.array([*_build_strip(places, rims[i], opposite[j])]))
    filled = np.concatenate(patch)
    same_rims = {*map(tuple, _find_free_edges(filled).tolist())} == {
        *map(tuple, _find_free_edges(surface.faces[gone]).tolist())
    }
    if not same_rims or Surface(places, filled).nonmanifold_edges or (gone.all() and not len(filled)):
        return None
    used, numbers = np.unique(np.concatenate([surface.faces[~gone], filled]), return_inverse=True)
    return replace(surface, vertices=places[used], faces=numbers.reshape(-1, 3))


def _find_free_edges(faces: Index) -> Index:
    """Find the edges without another triangle, each as its ends in the order of its triangle, shape (E, 2)."""
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    count = int(faces.max(initial=0)) + 1
    forth, back = ends @ [count, 1], ends @ [1, count]
    return ends[~np.isin(forth, back)]


def _find_pinches(faces: Index) -> Index:
    """Find the vertices that lie on two rims."""
    begins, counts = np.unique(_find_free_edges(faces)[:, 0], return_counts=True)
    return begins[counts > 1]


def _trace_rims(faces: Index) -> list[list[int]]:
    """Trace the rims of an open surface, each as its vertices in the direction of the triangles at it."""
    following = dict(_find_free_edges(faces).tolist())
    rims = []
    while following:
        start, at = following.popitem()
        rim = [start]
        while at != start:
            rim.append(at)
            at = following.pop(at)
        rims.append(rim)
    return rims


def _build_strip(vertices: Array, one: list[int], other: list[int]) -> Iterator[tuple[int, int, int]]:
    """Build triangles between two rims that run the same way, always along the shorter diagonal."""
    tree = scipy.spatial.cKDTree(vertices[other])
    gaps, nearest = map(np.asarray, tree.query(vertices[one]))
    begin = int(gaps.argmin())
    one = [*one[begin:], *one[: begin + 1]]
    begin = int(nearest[begin])
    other = [*other[begin:], *other[: begin + 1]]
    i = j = 0
    while i + 1 < len(one) or j + 1 < len(other):
        forth = np.linalg.norm(vertices[one[i + 1]] - vertices[other[j]]) if i + 1 < len(one) else np.inf
        across = np.linalg.norm(vertices[other[j + 1]] - vertices[one[i]]) if j + 1 < len(other) else np.inf
        if forth <= across:
            yield one[i], one[i + 1], other[j]
            i += 1
        else:
            yield other[j + 1], other[j], one[i]
            j += 1
