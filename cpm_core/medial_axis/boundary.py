"""The boundary of a medial axis: the ridge of the edge map as evenly spaced points."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy

from cpm_core.contours.contour import Contour, Contours, stack_vertices
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import step_lengths
from cpm_core.numerics.types import NO_POINTS, Array, Extent, Index, Mask, record
from cpm_core.parameters import Parameters
from cpm_core.reconstruction import find_contours

_BOUNDARY_SPACING = 1.0
"""Spacing of the points that contours pass through [px]: less than half the width of the thinnest line."""

_BOUNDARY_STRIDE = 0.5
"""Distance of neighboring points along the boundary [px]."""

_BORDER_DISTANCE = 3.0
"""Distance from the image border up to which a contour that ends is continued beyond the border [px]."""

_TANGENT_POINTS = 6
"""Number of last points that give the direction of the continuation."""

_MIN_OUTWARD = 0.3
"""Least component toward the border of that direction; under it the continuation is perpendicular to the border."""

_LOOSE_NEIGHBORHOOD = 0.67
"""Distance in which a loose contour needs another one for closing something off, in lengths of the loose one."""

_ON_BORDER_DISTANCE = 0.75
"""Distance from the sides of the image up to which an outline follows its border [px]."""

_MIN_BOUNDARY_LENGTH = 8.0
"""Least length of a boundary [px]."""


@record
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
    normals : ndarray, shape (N, 2)
        Image gradient at the points, or where their line leaves the image [gray levels / px].
    loose : float
        Share of the length that belongs to contours with an end inside the image, which close nothing off.
    """

    points: Array
    neighbors: Index
    strength: Array
    normals: Array
    loose: float = 0.0


def find_boundary(scale_field: ScaleField, parameters: Parameters) -> Boundary:
    """Find the edges of an image without seeds, with subpixel accuracy.

    Every pixel above the edge floor is a candidate position of a particle. The rest is the reconstruction of a run:
    ridge, tracing, gaps, contours. A contour that ends at the image border is continued straight beyond it by the size
    of the image, so that an object cut off by the border has no edge there.
    """
    pixels = np.argwhere(scale_field.edge_map >= scale_field.floor).astype(float)
    shortest = max(parameters.min_length, _MIN_BOUNDARY_LENGTH)
    dense = replace(parameters, d_min=_BOUNDARY_SPACING, d_max=_BOUNDARY_SPACING, min_length=shortest)
    found, shape, contours = find_contours(pixels, scale_field, dense)[0], scale_field.shape, []
    tree = scipy.spatial.cKDTree(stack_vertices(found))
    owner = polyline.repeat_indices([len(contour.points) for contour in found])
    for number, contour in enumerate(found):
        # a loose piece with more room on all sides than its length closes nothing off, such as a change of shade in
        # an object, but would divide the axis of this object
        loose = len(found) > 1 and not any(contour.junctions) and _loose_ends(contour, shape).all()
        near = (
            tree.query_ball_point(polyline.path_midpoints(contour.path, 1)[0], _LOOSE_NEIGHBORHOOD * contour.length)
            if loose
            else []
        )
        if not loose or (owner[near] != number).any():
            contours.append(contour)
    return _boundary_along_paths(
        contours, [_extend_beyond_border(_sample_evenly(contour), shape) for contour in contours], scale_field
    )


def boundary_from_outlines(outlines: Contours, scale_field: ScaleField) -> Boundary:
    """Build the boundary from closed contours: outer boundaries of objects and of their holes.

    Where an outline follows the image border there is no edge: the object continues beyond it.
    """
    paths = [piece for outline in outlines for piece in _split_off_border(_sample_evenly(outline), scale_field.shape)]
    return _boundary_along_paths(
        outlines, [_extend_beyond_border(path, scale_field.shape) for path in paths], scale_field
    )


def _boundary_along_paths(contours: Contours, paths: list[tuple[Array, slice]], scale_field: ScaleField) -> Boundary:
    """Build the boundary along paths, each with the part of it that lies in the image."""
    if not paths:
        return Boundary(NO_POINTS, np.zeros((0, 2), np.int64), np.zeros(0), NO_POINTS)
    start = np.cumsum([0, *(len(path) for path, _ in paths)])
    normals = [
        np.pad(scale_field.normals_at(path[known]), [(known.start, len(path) - known.stop), (0, 0)], mode="edge")
        for path, known in paths
    ]
    distinct, first, index = np.unique(
        np.concatenate([path for path, _ in paths]), axis=0, return_index=True, return_inverse=True
    )  # junctions occur more than once
    index = index.ravel()
    pairs = [np.stack([index[a : b - 1], index[a + 1 : b]], axis=1) for a, b in pairwise(start)]
    loose = sum(contour.length for contour in contours if _loose_ends(contour, scale_field.shape).any())
    return Boundary(
        distinct,
        np.concatenate(pairs),
        scale_field.strength_at(distinct),
        np.concatenate(normals)[first],
        loose / max(sum(contour.length for contour in contours), 1e-300),
    )


def _loose_ends(contour: Contour, shape: Extent) -> Mask:
    """Return whether both ends of a contour lie in the image and are no junctions, shape (2,)."""
    size = np.array(shape, float) - 1.0
    inside = np.minimum(contour.points, size - contour.points)[[0, -1]].min(axis=1) > _BORDER_DISTANCE
    return inside & ~np.array(contour.junctions) & (not contour.closed)


def _split_off_border(path: Array, shape: Extent) -> list[Array]:
    """Split off the pieces of a closed path that follow the image border; the whole path if all of it does."""
    size = np.array(shape, float)
    away = np.minimum(path + 0.5, size - 0.5 - path).min(axis=1) > _ON_BORDER_DISTANCE
    if away.all():
        return [path]
    turn = np.argmin(away)
    path, away = np.roll(path[:-1], -turn, axis=0), np.roll(away[:-1], -turn)
    pieces = np.split(path, np.flatnonzero(np.diff(away)) + 1)
    return [piece for piece in pieces[1::2] if len(piece) > 1]


def _sample_evenly(contour: Contour) -> Array:
    """Sample points along a contour, including its vertices; of a closed one the first is repeated at the end."""
    path = contour.path
    counts = np.maximum(np.ceil(step_lengths(path) / _BOUNDARY_STRIDE), 1).astype(int)
    at = np.concatenate([[0.0], *(k + np.arange(1, count + 1) / count for k, count in enumerate(counts.tolist()))])
    return np.stack([np.interp(at, np.arange(len(path)), axis) for axis in path.T], axis=1)


def _extend_beyond_border(path: Array, shape: Extent) -> tuple[Array, slice]:
    """Extend a path straight beyond the image border; also return the slice that is the path itself."""
    if (path[0] == path[-1]).all():
        return path, slice(0, len(path))
    before, behind = _straight_extension(path[::-1], shape), _straight_extension(path, shape)
    return np.concatenate([before[::-1], path, behind]), slice(len(before), len(before) + len(path))


def _straight_extension(path: Array, shape: Extent) -> Array:
    """Return points from the end of a path out of the image; none if it ends inside."""
    size = np.array(shape, float)
    end = path[-1]
    beyond = np.concatenate([end, size - 1.0 - end])
    side = np.argmin(beyond)
    if beyond[side] > _BORDER_DISTANCE:
        return path[:0]
    outwards = np.zeros(2)
    outwards[side % 2] = -1.0 if side < 2 else 1.0
    along = end - path[-min(len(path), _TANGENT_POINTS)]
    along = along / max(float(np.linalg.norm(along)), 1e-300)
    direction = along if along @ outwards >= _MIN_OUTWARD else outwards
    return end + direction * np.arange(_BOUNDARY_STRIDE, size.max(), _BOUNDARY_STRIDE)[:, None]
