"""Enclosed regions: what particles at rest have found one boundary of, and not yet the others.

A start wholly inside a ring finds the hole or the rim, whichever pulls harder, and repulsion that is weaker than the
attraction of edges (w1 < w2) never lets anybody cross to the other one. A region between edges that does not reach the
border of the image is the inside of something; once any of its boundaries has been reached, the others belong to the
same thing, and particles are launched beside them. What lies outside, up to the border, is left to the drawing, and so
is what a wall runs through.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.dynamics.deletion.plane import deletion
from cpm_core.field.interpolation import interpolate
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Array

Labels = NDArray[np.int64]

RESEEDINGS = 3
"""Times that particles may be launched beside boundaries that no particle has reached, until parameters are changed."""

_BESIDE_WALL = 1.0
"""Distance under which a pixel is one that a wall runs through [px]."""

_LEAST_AREA = 16
"""Pixels that a region must have."""

_REACH, _REACH_SMOOTHING = 3.0, 2.0
"""Distance from a region's rim to the crest of the edge around it at most: so much, and so many sigma [px]."""

_COVERED = 0.5
"""Share of a boundary that must have particles beside it for it to count as reached."""

_LEAST_STRETCH = 8
"""Pixels in a row of a boundary without particles for some to be launched there: boundaries a few pixels apart
share their rim, and one of them may be missing alone."""

_NEIGHBORS = 8
"""Particles nearest to a pixel of a rim that are looked at."""

_STRIDE = 6.0
"""Distance between particles that are launched [px]."""


def reseeding_places(scale_field: ScaleField, positions: Array) -> Array:
    """Places beside boundaries, or stretches of them, of enclosed regions that have been reached elsewhere only.

    Parameters
    ----------
    scale_field : ScaleField
        Fields of the scale.
    positions : ndarray, shape (N, 2)
        The particles that sit on an edge [px].

    Returns
    -------
    ndarray, shape (M, 2)
        Where to launch particles; empty when nothing is missing.
    """
    nowhere = np.zeros((0, 2))
    if not len(positions):
        return nowhere
    walled = np.zeros(scale_field.shape, bool)
    if len(scale_field.barrier_map.segments):
        walled = scale_field.barrier_map.clearance < _BESIDE_WALL
    regions = _enclosed(scale_field.edge_map < scale_field.floor, walled)
    rims, region_of = _rims(regions)
    if not len(region_of):
        return nowhere
    place = np.argwhere(rims > 0)
    number = rims[rims > 0]
    reach = _REACH + _REACH_SMOOTHING * scale_field.smoothing
    near = _has_near(scale_field, place, positions, reach)
    size = np.bincount(number, minlength=len(region_of))
    covered = np.bincount(number, weights=near, minlength=len(region_of)) / np.maximum(size, 1)
    known = np.zeros(region_of.max() + 1, bool)
    known[region_of[covered >= _COVERED]] = True
    missing = ~near & known[region_of][number]
    places: Array = place[missing & (_stretch(place, missing, scale_field.shape) >= _LEAST_STRETCH)].astype(float)
    return places[deletion(places, np.zeros(len(places)), scale_field.shape, 2.0 * _STRIDE)]


def _has_near(scale_field: ScaleField, place: NDArray[np.int64], positions: Array, reach: float) -> NDArray[np.bool_]:
    """Which pixels of a rim have a particle near them on the same side of an edge.

    Of two edges that run close to each other one rises where the other falls.
    """
    uphill = scale_field.gradient[(slice(None), *place.T)].T
    known = interpolate(scale_field.gradient, positions)
    nearest = np.arange(1, min(_NEIGHBORS, len(positions)) + 1)
    distance, index = scipy.spatial.cKDTree(positions).query(place, k=nearest, distance_upper_bound=reach)
    found = np.isfinite(distance)
    along = np.einsum("ni,nki->nk", uphill, known[np.where(found, index, 0)])
    return np.asarray((found & (along > 0.0)).any(axis=1))


def _stretch(place: NDArray[np.int64], chosen: NDArray[np.bool_], shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Pixels in the connected stretch of chosen ones that each pixel belongs to; 0 for those that are not chosen."""
    mask = np.zeros(shape, bool)
    mask[tuple(place[chosen].T)] = True
    labels, _ = scipy.ndimage.label(mask, structure=np.ones((3, 3), bool))
    size = np.bincount(labels.ravel())
    size[0] = 0
    return np.asarray(size[labels[tuple(place.T)]])


def _enclosed(free: NDArray[np.bool_], walled: NDArray[np.bool_]) -> Labels:
    """Number the regions between edges that touch neither the border of the image nor a wall."""
    labels, count = scipy.ndimage.label(free)
    outside = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1], labels[walled]]))
    small = np.flatnonzero(np.bincount(labels.ravel(), minlength=count + 1) < _LEAST_AREA)
    dropped = np.zeros(count + 1, bool)
    dropped[outside], dropped[small], dropped[0] = True, True, True
    return np.where(dropped[labels], 0, labels).astype(np.int64)


def _rims(regions: Labels) -> tuple[Labels, Labels]:
    """Number the rims of the regions, each closed curve of pixels around or inside one by itself.

    Returns
    -------
    rims : ndarray of int64
        Number of the rim that each pixel lies on, 0 for none.
    region_of : ndarray of int64
        Region of each rim; entry 0 stands for none.
    """
    eight = np.ones((3, 3), bool)
    beside = np.where(regions > 0, 0, scipy.ndimage.maximum_filter(regions, size=3, mode="nearest"))
    rims = np.zeros_like(regions)
    region_of = [np.zeros(1, np.int64)]
    count = 0
    windows = cast("list[tuple[slice, ...] | None]", scipy.ndimage.find_objects(beside))
    for number, window in enumerate(windows, start=1):
        if window is None:  # the region has no pixel beside it that is not another region's
            continue
        labels, found = scipy.ndimage.label(beside[window] == number, structure=eight)
        part = rims[window]
        part[labels > 0] = labels[labels > 0] + count
        region_of.append(np.full(found, number))
        count += found
    every = np.concatenate(region_of)
    return rims, every if count else every[:0]
