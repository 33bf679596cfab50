"""Enclosed regions of which the particles at rest have found one boundary but not the others.

A start inside a ring finds the hole or the outline, whichever attracts more strongly, and while repulsion is weaker
than the attraction of edges (w1 < w2) no particle crosses to the other one. A region between edges that does not reach
the image border is the inside of an object. Once one of its boundaries has been reached, the others belong to the same
object, and particles are reseeded next to them. Regions at the image border, and those that a barrier crosses, depend
on the seeds alone.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.scale_field import ScaleField
from cpm_core.model.plane.births import select_survivors
from cpm_core.numerics.grids import Labels, label_parts, run_in_bands
from cpm_core.numerics.parallel import count_cores
from cpm_core.numerics.types import NO_POINTS, Array, Extent, Index

MAX_PLANE_RESEEDINGS = 3
"""Greatest number of reseedings until parameters are changed."""

BARRIER_CLEARANCE = 1.0
"""Distance to a barrier under which it crosses a pixel [px]."""

_MIN_REGION_AREA = 16
"""Least area of a region [px²]."""

_RIM_REACH = 3.0
"""Constant part of the greatest distance from a region's rim to the ridge of the edge around it [px]."""

_RIM_REACH_PER_SIGMA = 2.0
"""Part of that distance that grows with the smoothing [sigma]."""

_REACHED_FRACTION = 0.5
"""Fraction of a boundary that must have particles next to it to count as reached."""

_MIN_MISSING_STRETCH = 8
"""Least length of a stretch without particles that is reseeded [px]: boundaries a few pixels apart share their rim, and
only one of them may be missing."""

_EXAMINED_NEIGHBORS = 8
"""Number of nearest particles that are examined for a pixel of a rim."""

_RESEEDING_SPACING = 4.0
"""Distance between reseeded particles [px]."""


def reseeding_places(scale_field: ScaleField, positions: Array) -> Array:
    """Find positions, shape (M, 2) [px], next to boundaries of enclosed regions that have been reached only elsewhere.

    `positions`, shape (N, 2), are those of the particles on an edge [px of the scale].
    """
    if not len(positions):
        return NO_POINTS
    blocked = np.zeros(scale_field.shape, bool)
    if len(scale_field.barrier_map.segments):
        blocked = scale_field.barrier_map.clearance < BARRIER_CLEARANCE
    rims, region_of = _label_rims(_label_enclosed(scale_field.edge_map < scale_field.floor, blocked))
    if not len(region_of):
        return NO_POINTS
    place = np.argwhere(rims > 0)
    number = rims[rims > 0]
    reach = _RIM_REACH + _RIM_REACH_PER_SIGMA * scale_field.smoothing
    near = _has_particle_near(scale_field, place, positions, reach)
    size = np.bincount(number, minlength=len(region_of))
    covered = np.bincount(number, weights=near, minlength=len(region_of)) / np.maximum(size, 1)
    known = np.zeros(region_of.max() + 1, bool)
    known[region_of[covered >= _REACHED_FRACTION]] = True
    missing = ~near & known[region_of][number]
    if scale_field.area.size:
        missing &= scale_field.area[tuple(place.T)]
    places: Array = place[missing & (_stretch_sizes(place, missing, scale_field.shape) >= _MIN_MISSING_STRETCH)].astype(
        float
    )
    return places[select_survivors(places, np.zeros(len(places)), 2.0 * _RESEEDING_SPACING)]


def _has_particle_near(
    scale_field: ScaleField, place: NDArray[np.int64], positions: Array, reach: float
) -> NDArray[np.bool_]:
    """Return a mask, shape (N,), of the pixels of a rim with a particle near them on the same side of an edge.

    Of two edges close to each other one rises where the other falls.
    """
    gradient = np.moveaxis(scale_field.packed, -1, 0)[2:4]
    uphill, known = gradient[(slice(None), *place.T)].T, interpolate_field(gradient, positions)
    nearest = np.arange(1, min(_EXAMINED_NEIGHBORS, len(positions)) + 1)
    distance, index = scipy.spatial.cKDTree(positions).query(
        place, k=nearest, distance_upper_bound=reach, workers=count_cores()
    )
    found = np.isfinite(distance)
    along = np.einsum("ni,nki->nk", uphill, known[np.where(found, index, 0)])
    return (found & (along > 0.0)).any(axis=1)


def _stretch_sizes(place: NDArray[np.int64], chosen: NDArray[np.bool_], shape: Extent) -> NDArray[np.int64]:
    """Return the size of the connected stretch of selected pixels that each belongs to; 0 for those not selected."""
    mask = np.zeros(shape, bool)
    mask[tuple(place[chosen].T)] = True
    labels, _ = label_parts(mask)
    size = np.bincount(labels[tuple(place[chosen].T)], minlength=int(labels.max()) + 1)
    return size[labels[tuple(place.T)]]


def _label_enclosed(free: NDArray[np.bool_], blocked: NDArray[np.bool_]) -> Labels:
    """Label the regions between edges that touch neither the image border nor a barrier."""
    labels, count = scipy.ndimage.label(free)
    outside = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1], labels[blocked]]))
    sizes = sum(np.bincount(part.ravel(), minlength=count + 1) for part in np.array_split(labels, 16))
    small = np.flatnonzero(sizes < _MIN_REGION_AREA)
    dropped = np.zeros(count + 1, bool)
    dropped[outside], dropped[small], dropped[0] = True, True, True
    labels[dropped[labels]] = 0
    return np.asarray(labels, np.int32)


def _label_rims(regions: Labels) -> tuple[Labels, Index]:
    """Label the rims of the regions: each closed curve of pixels around or inside one has its own number.

    Returns
    -------
    rims : ndarray of int32
        Number of the rim that each pixel lies on, 0 for none.
    region_of : ndarray of int64
        Region of each rim; entry 0 is unused.
    """
    beside = np.empty_like(regions)

    def widen_rows(first: int, end: int) -> None:  # without one more image of labels
        low = max(first - 1, 0)
        nearby = scipy.ndimage.maximum_filter(regions[low : end + 1], 3, mode="nearest")
        beside[first:end] = nearby[first - low : end - low]

    run_in_bands(widen_rows, len(regions))
    beside[regions > 0] = 0
    rims = regions  # whose memory takes the rims
    rims[...] = 0
    region_of = [np.zeros(1, np.int64)]
    count = 0
    windows = cast("list[tuple[slice, ...] | None]", scipy.ndimage.find_objects(beside))
    for number, window in enumerate(windows, start=1):
        if window is None:  # all pixels next to the region belong to other regions
            continue
        labels, found = label_parts(beside[window] == number)
        part = rims[window]
        part[labels > 0] = labels[labels > 0] + count
        region_of.append(np.full(found, number))
        count += found
    every = np.concatenate(region_of)
    return rims, every if count else every[:0]
