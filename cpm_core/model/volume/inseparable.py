"""Boundaries in a volume that cannot be moved apart from those that particles have found.

Fronts creep along one connected part of the edge map, a boundary. Two rules lead from one to another, both without a
distance. Enclosed: a region between edges that does not reach the border of the volume is the inside of an object, or a
hollow in it. Once particles cover one of its boundaries, the others belong to the same object, as in the plane
(`enclosed_regions`). Linked: a ring belongs to a ring that it is linked with, and so do all boundaries with closed
loops inside that are linked. An object that could be pulled out, such as a rod in a ring or a ball in a cup, depends on
the seeds alone.
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.field.volume_field import VolumeField
from cpm_core.field.volume_surface import Ridges
from cpm_core.numerics.grids import find_connected_parts
from cpm_core.numerics.types import Array, Mask
from cpm_core.numerics.voxel_graph import find_loops, linking_number

_MIN_BOUNDARY_VOXELS = 32
"""Ridge voxels of the least boundary that is reseeded: those of a ball with a radius of 1.6 voxels."""

_MIN_BOUNDARY_STRENGTH = 0.35
"""Least median edge strength of a boundary, as a fraction of that of the boundaries found."""

_FOUND_FRACTION = 0.5
"""Fraction of a boundary that must be covered to count as found."""

_RIDGE_REACH = 3.0
"""Constant part of the greatest distance of a region from the ridge of the edge around it [units]."""

_RIDGE_REACH_PER_SIGMA = 2.0
"""Part of that distance that grows with the smoothing [sigma]."""


def find_inseparable(field: VolumeField, ridges: Ridges, reached: Mask, covered: Mask) -> Mask:
    """Return a mask of the boundaries, by number, that cannot be moved apart from those found.

    `reached` marks, by their number `Ridges.component`, the boundaries with a particle on them, `covered`, shape (M,),
    the ridge voxels with one of their sheet near them.
    """
    none = np.zeros_like(reached)
    if not reached.any():
        return none
    covered = covered & reached[ridges.component]
    size = np.maximum(np.bincount(ridges.component), 1)
    found = np.bincount(ridges.component, covered) >= _FOUND_FRACTION * size
    fitting = ~reached & (size >= _MIN_BOUNDARY_VOXELS)
    usual = float(np.median(ridges.strength[covered]))
    large = np.flatnonzero(fitting)
    strength = scipy.ndimage.median(ridges.strength, ridges.component, large) if len(large) else np.zeros(0)
    fitting[large] = np.asarray(strength) >= _MIN_BOUNDARY_STRENGTH * usual
    if not fitting.any():
        return none
    return _find_enclosed(field, ridges, covered, fitting) | _find_linked(field, ridges, found, fitting)


def _find_enclosed(field: VolumeField, ridges: Ridges, covered: Mask, fitting: Mask) -> Mask:
    """Return the fitting boundaries that bound an enclosed region with another boundary that has been found."""
    regions = find_connected_parts(field.edge_map < np.float32(field.floor), corners=False)
    open_ = regions.at_border
    if field.walls is not None:
        crossed = regions.part_at(np.argwhere(field.walls.find_wall_voxels(field.shape, field.pitch)))
        open_[crossed[crossed >= 0]] = True
    chosen = fitting.copy()
    chosen[ridges.component[covered]] = True
    some = np.flatnonzero(chosen[ridges.component])
    more = np.zeros_like(fitting)
    rims, near = [], []
    for side in (-1.0, 1.0):
        region = np.full(len(some), -1, np.int64)  # the first one in this direction, within reach
        for step in range(1, int(_RIDGE_REACH + _RIDGE_REACH_PER_SIGMA * field.smoothing) + 1):
            beside = ridges.place[some] + step * (side * ridges.normal[some])
            voxel = np.rint(beside / field.pitch).astype(np.int64)
            here = regions.part_at(np.ascontiguousarray(np.clip(voxel, 0, np.array(field.shape) - 1)))
            region = np.where(region < 0, here, region)
        inner = (region >= 0) & ~open_[region]
        rims.append(np.stack([ridges.component[some][inner], region[inner]], axis=1))
        near.append(covered[some][inner])
    rim, number = np.unique(np.concatenate(rims), axis=0, return_inverse=True)
    if not len(rim):
        return more
    number = number.ravel()
    share = np.bincount(number, np.concatenate(near)) / np.bincount(number)
    known = np.zeros(regions.count, bool)
    known[rim[share >= _FOUND_FRACTION, 1]] = True
    more[rim[known[rim[:, 1]], 0]] = True
    return more & fitting


def _find_linked(field: VolumeField, ridges: Ridges, found: Mask, fitting: Mask) -> Mask:
    """Return the fitting boundaries linked with found ones: closed loops inside the two wind around each other."""
    more = np.zeros_like(fitting)
    voxels = np.rint(ridges.place / field.pitch).astype(np.int64)
    known = voxels[found[ridges.component]]
    loops_found: list[Array] | None = None
    for number in np.flatnonzero(fitting):
        boundary = voxels[ridges.component == number]
        if not ((known >= boundary.min(0)) & (known <= boundary.max(0))).all(axis=1).any():
            continue
        loops = find_loops(boundary)
        if loops and loops_found is None:
            loops_found = [
                loop for one in np.flatnonzero(found) for loop in find_loops(voxels[ridges.component == one])
            ]
        more[number] = any(linking_number(loop, other) for loop in loops for other in loops_found or ())
    return more
