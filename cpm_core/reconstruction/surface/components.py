"""Components of a surface that enough particles bear out, and regions away from particles that lie inside."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.surface import Surface
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask, Single

_APART = 4
"""The distance to this neighbor is about that between points, in regular patterns and at random."""


_FEWEST, _SHARE, _SUPPORTED = 12, 0.003, 0.25
"""A component stays if it has so many particles, and so many as a share of those of the component with most of them,
and if this share of its vertices has a particle near."""


def support(vertices: Array, points: Array, distance: float) -> Mask:
    """Which vertices have a point within a distance."""
    return np.asarray(scipy.spatial.KDTree(points).query(vertices)[0] <= distance)


def well_supported(
    vertices: Array,
    faces: Index,
    points: Array,
    supported: Mask,
    spacing: tuple[float, ...],
    unit: str | None,
) -> Surface:
    """Surface of the components that are not left out; `supported` marks which vertices have a particle near.

    A particle belongs to the component of the vertex next to it.
    """
    whole = Surface(vertices, faces, spacing, unit)
    if not len(faces):
        return whole
    component = whole.component_of_vertex
    nearest = scipy.spatial.KDTree(vertices * spacing).query(points * spacing)[1]
    particles = np.bincount(component[nearest], minlength=component.max() + 1)
    share = np.bincount(component, supported) / np.bincount(component)
    kept = (particles >= max(_FEWEST, _SHARE * particles.max())) & (share >= _SUPPORTED)
    stays = kept[component]
    number = np.cumsum(stays) - 1
    unsupported = 1.0 - float(supported[stays].mean()) if stays.any() else np.nan
    left_out = int(len(kept) - kept.sum())
    return Surface(vertices[stays], number[faces[stays[faces[:, 0]]]], spacing, unit, unsupported, left_out)


def typical_distance(places: Array) -> float:
    """Typical distance between neighboring places, shape (N, 3), in their unit."""
    distances = scipy.spatial.KDTree(places).query(places, [min(_APART, len(places) - 1) + 1])[0]
    return float(np.median(distances))


FAR = 4.0
"""Height inside, and less than zero outside, of voxels away from all particles."""


def fill_regions(height: Single) -> None:
    """Replace NaN in a height by `FAR` or its negative, region by region, by the sign of most of the voxels around.

    The outermost voxels become infinite: they belong to no region, nor do others that are infinite.
    """
    set_border(height, np.inf)
    waiting = np.empty((1024, 3), np.int32)
    for plane in range(1, len(height) - 1):
        for row, col in np.argwhere(np.isnan(height[plane])).tolist():
            if np.isnan(height[plane, row, col]):
                votes, waiting = _flood(height, plane, row, col, np.float32(-np.inf), waiting)
                _, waiting = _flood(height, plane, row, col, np.float32(FAR if votes > 0 else -FAR), waiting)


def set_border(height: Single, value: float) -> None:
    """Set the outermost voxels."""
    for axis in range(3):
        np.moveaxis(height, axis, 0)[[0, -1]] = value


@compiled
def _flood(
    height: Single, plane: int, row: int, col: int, filled: np.float32, waiting: NDArray[np.int32]
) -> tuple[int, NDArray[np.int32]]:
    """Fill the voxels with the value of a given one, run by run; return how many more around lie above zero than below.

    The value is NaN, or what NaN has been replaced by. `waiting` is room for runs to come; it grows.
    """
    votes, count = 0, 1
    old = height[plane, row, col]
    waiting[0, 0], waiting[0, 1], waiting[0, 2] = plane, row, col
    while count:
        count -= 1
        p, r, first = waiting[count]
        if not _is(height[p, r, first], old):
            continue
        end = first
        while _is(height[p, r, end], old):
            height[p, r, end] = filled
            end += 1
        first -= 1
        while _is(height[p, r, first], old):
            height[p, r, first] = filled
            first -= 1
        votes += _side(height[p, r, first]) + _side(height[p, r, end])
        if count + 2 * (end - first) > len(waiting):
            waiting = np.concatenate((waiting, np.empty((len(waiting) + 2 * (end - first), 3), np.int32)))
        for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            before = False
            for c in range(first + 1, end):
                there = height[p + down, r + right, c]
                open_ = _is(there, old)
                if open_ and not before:
                    waiting[count, 0], waiting[count, 1], waiting[count, 2] = p + down, r + right, c
                    count += 1
                votes += _side(there)
                before = open_
    return votes, waiting


@compiled
def _is(value: np.float32, wanted: np.float32) -> bool:
    return value == wanted or (np.isnan(value) and np.isnan(wanted))


@compiled
def _side(value: np.float32) -> int:
    return (1 if value > 0.0 else -1) if np.isfinite(value) else 0
