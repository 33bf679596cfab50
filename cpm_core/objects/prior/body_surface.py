"""The surface of a predicted body: along edges where there are any, else where its probability is 0.5.

It is triangulated on the steps of the crop. Then each vertex moves along its normal to the steepest place of the gray
levels, as particles would, if the edge there stands out from the noise. Profiles of gray levels along the normals are
averaged with those of neighbors on the surface, which smooths along the surface and not across it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from cpm_core.field.interpolation import value_at
from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import find_connected_parts, grid_points, nearest_pixels, zero_surface
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import limit_blas
from cpm_core.numerics.types import Array, Extent, Index, Mask, Sides, Single
from cpm_core.objects.prior.body_prediction import MAX_LOGIT, BodyPrediction
from cpm_core.objects.prior.crops import Crop3D

_EDGE_SEARCH_REACH = 2.0
"""How far from the surface an edge is looked for [steps, at least voxels]."""

_PROFILE_SPACING = 0.5
"""Distance between samples of a profile [steps, at least voxels]."""

_AVERAGING_ROUNDS = 3
"""How often profiles are averaged with those of neighbors."""

_CLEAR_EDGE_RATIO = 3.0
"""Rise across an edge from which it counts in full, in deviations of the profiles from their mean."""

_SLOPE_SIGMA = 1.5
"""Sigma of the derivative of a Gaussian that finds the steepest place of a profile [samples]."""

_POINT_PROTECTION = 2.0
"""Distance from a clicked point within which the surface stays where it is [steps, at least voxels]."""

_MIN_POINT_LOGIT = 0.5
"""Least absolute logit at the corners of the steps around a point."""

_MIN_HOLLOW_SIZE = 8
"""Least number of steps in a hollow: those around a negative point."""


def extract_body_surface(
    body: BodyPrediction,
    values: Array,
    size: Array,
    inside: Array,
    outside: Array,
    spacing: Sides,
    unit: str | None,
    interest: Mask | None = None,
) -> Surface:
    """Extract the closed surface of the parts of a body that hold points.

    Parameters
    ----------
    body : BodyPrediction
        The body.
    values : ndarray, shape (P, R, C)
        Gray levels of the volume.
    size : ndarray, shape (3,)
        Sides of a voxel; the smallest is 1.
    inside, outside : ndarray, shape (N, 3)
        Positive and negative points [voxels].
    spacing, unit
        Spacing and unit of the surface.
    interest : ndarray of bool, shape (P, R, C), optional
        Voxels outside which no edge is looked for.
    """
    vertices, faces = zero_surface(_select_connected_logits(body, inside * size, outside * size, values.shape, size))
    last = np.array(values.shape) - 1.0
    vertices = body.crop.to_positions(vertices - 1.0) / size
    held = ((vertices <= 0.0) | (vertices >= last)).any(axis=1)
    scale = max(body.crop.step_size, 1.0)
    for place in np.concatenate([inside, outside]):
        held |= np.linalg.norm((vertices - place) * size, axis=1) < _POINT_PROTECTION * scale
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    joined = scipy.sparse.csr_array((np.ones(len(ends)), ends.T), shape=(len(vertices),) * 2)
    joined = joined + joined.T + scipy.sparse.eye_array(len(vertices))
    joined.data[:] = 1.0
    mean = scipy.sparse.diags_array(1.0 / joined.sum(axis=1)) @ joined
    for width in (scale, *[max(0.5 * scale, 1.0)] * 2):
        found = Surface(vertices, faces, tuple(size.tolist()))
        moved = np.where(held, 0.0, _find_edge_offsets(found, mean, values, size, width))
        there = vertices + moved[:, None] * found.normals / size
        if interest is not None:
            allowed = interest[tuple(nearest_pixels(there, interest.shape).T)]
            there = np.where(allowed[:, None], there, vertices)
        vertices = there
    vertices = np.clip(vertices, -0.5, last + 0.5)  # flat where the volume ends
    return Surface(vertices, faces, spacing, unit)


def _select_connected_logits(body: BodyPrediction, inside: Array, outside: Array, shape: Extent, size: Array) -> Single:
    """Select the logits of the parts of a body that hold points, continued beyond the volume; one step wider.

    Tiny hollows are filled.
    """
    logits = np.pad(body.logits, 1, constant_values=-MAX_LOGIT)
    for axis, line in enumerate(body.crop.axis_positions):
        within = np.flatnonzero((line > -0.5 * size[axis]) & (line < (shape[axis] - 0.5) * size[axis])) + 1
        first, end = (within[0], within[-1]) if len(within) else (1, len(line))
        if first > 1 or end < len(line):
            at = np.arange(len(line) + 2)
            at = np.clip(at, first if first > 1 else 0, end if end < len(line) else len(line) + 1)
            logits = logits.take(at, axis)
    for axis in range(3):
        np.moveaxis(logits, axis, 0)[[0, -1]] = -MAX_LOGIT
    corners = [_find_cell_corners(body.crop, places) for places in (inside, outside)]
    logits[tuple(corners[1].T)] = np.minimum(logits[tuple(corners[1].T)], -_MIN_POINT_LOGIT)
    logits[tuple(corners[0].T)] = np.maximum(logits[tuple(corners[0].T)], _MIN_POINT_LOGIT)
    parts = find_connected_parts(logits > 0.0, corners=True)
    held = np.zeros(parts.count + 1, np.bool_)
    held[parts.part_at(corners[0]) + 1] = True
    held[0] = True
    logits[~held[parts.labels]] *= -1.0
    hollows, _ = scipy.ndimage.label(logits <= 0.0)
    small = np.bincount(hollows.ravel()) < _MIN_HOLLOW_SIZE
    small[0] = False
    logits[small[hollows]] *= -1.0
    return logits


def _find_cell_corners(cube: Crop3D, places: Array) -> Index:
    """Find the eight steps around each point, in a grid that is one wider."""
    first = np.floor(cube.to_crop_steps(places)).astype(np.int64) + 1
    around = grid_points(3 * [[0, 1]])
    return np.clip(first[:, None] + around, 0, len(cube.axis_positions[0]) + 1).reshape(-1, 3)


@limit_blas()
def _find_edge_offsets(surface: Surface, mean: Any, values: Array, size: Array, scale: float) -> Array:
    """Find the offsets along the normals from the vertices to the steepest places of the gray levels.

    `mean` is the matrix that averages over neighbors on the surface.
    """
    count = len(surface.vertices)
    away = np.arange(-_EDGE_SEARCH_REACH, _EDGE_SEARCH_REACH + _PROFILE_SPACING / 2, _PROFILE_SPACING) * scale
    raw = np.empty((count, len(away)))
    _sample_profiles(values, surface.vertices, surface.normals / size, away, raw)
    smooth: Array = raw
    for _ in range(_AVERAGING_ROUNDS):
        smooth = np.asarray(mean @ smooth)
    slope = smooth @ scipy.ndimage.gaussian_filter1d(np.eye(len(away)), _SLOPE_SIGMA, order=1, mode="nearest")
    rise = smooth[:, -2:].mean(axis=1) - smooth[:, :2].mean(axis=1)
    steep = np.maximum(slope * np.sign(rise)[:, None], 0.0) * np.exp(-0.5 * np.square(away / away[-1]))
    peak = np.clip(steep.argmax(axis=1), 1, len(away) - 2)
    before, at, after = (steep[np.arange(count), peak + k] for k in (-1, 0, 1))
    bend = before - 2.0 * at + after
    part = np.divide(0.5 * (before - after), bend, out=np.zeros(count), where=bend < 0.0)
    noise = mean @ np.square(raw - smooth).mean(axis=1)
    clear = np.clip(np.abs(rise) / (_CLEAR_EDGE_RATIO * np.sqrt(noise) + 1e-12), 0.0, 1.0)
    return np.asarray(mean @ (clear * (away[peak] + np.clip(part, -0.5, 0.5) * _PROFILE_SPACING * scale)))


@compiled
def _sample_profiles(values: Any, vertices: Array, ways: Array, away: Array, found: Array) -> None:
    """Sample values at distances `away` from vertices along their directions."""
    for q in range(len(vertices)):
        for k in range(len(away)):
            plane, row = vertices[q, 0] + away[k] * ways[q, 0], vertices[q, 1] + away[k] * ways[q, 1]
            found[q, k] = value_at(values, plane, row, vertices[q, 2] + away[k] * ways[q, 2])
