"""Area that a start covers: the inside of a closed row of particles, or a narrow band along an open one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import (
    Window,
    bounding_window,
    expand_window,
    grid_points,
    label_parts,
    nearest_pixels,
    whole_window,
)
from cpm_core.numerics.types import Array, Extent, Mask, Sides

_LINK_FACTOR = 0.75
"""Multiple of the usual distance of neighbors up to which a row of particles is closed."""

_MIN_LINK = 2.0
"""Least such distance [px]."""

_HOLLOW_FACTOR = 3.0
"""Multiple of that distance from all particles beyond which a place is enclosed rather than covered."""

_EVEN_SIDE = 1.5
"""Greatest side of the cells that decide on a start from everywhere, in mean distances of particles."""

_EVEN_SHARE = 0.95
"""Least share of those cells with particles of a start from everywhere."""

_REGION_SAMPLES = 32
"""Number of places along each axis from which the size of the regions of interest is estimated."""

MIN_DRAWN_PLACES = 8
"""Number of places from which they are a drawn shape; fewer are clicks, and are drawn around nothing."""

_MIN_HULL_SHARE = 0.8
"""Share of a part between a row of particles and the border of the image that lies in the hull of an enclosed one."""

_MAX_OPENING = 0.15
"""Greatest distance of the ends of a line that is closed, as a share of its length."""

_MIN_ROUNDNESS = 0.1
"""Least area that such a line encloses, in areas of a circle of its length; a scribble encloses less."""

_CLICK_RADIUS = 4.0
"""Radius of the area that a click covers [px]: on an edge, it lies in part on both sides."""


def clicked_area(points: Array, shape: Extent) -> Mask:
    """Return the pixels of an image of this shape around each of a few clicks, shape (N, 2) [px]."""
    return np.asarray(scipy.ndimage.distance_transform_edt(~_mark_particles(points, shape)[0]) <= _CLICK_RADIUS)


def drawn_area(points: Array, shape: Extent) -> Mask:
    """Return the pixels of an image of this shape that a start covers.

    `points`, shape (N, 2), are its particles [px of the image]. Rows of particles are closed up to about the distance
    of neighbors, and the areas that they enclose, also together with the border of the image, are filled.
    """
    on, usual = _mark_particles(points, shape)
    if len(points) < 2:
        return on
    link = max(_MIN_LINK, _LINK_FACTOR * usual)
    box = _window_around(on, link)
    near = scipy.ndimage.distance_transform_edt(~on[box]) <= link
    filled = scipy.ndimage.binary_fill_holes(near) | _enclosed_with_border(near, on[box])
    on[box] |= scipy.ndimage.distance_transform_edt(filled) > link
    return on


def is_line(area: Mask) -> bool:
    """Return whether what a start covers, shape (H, W), is nowhere three pixels wide: an open line, or clicks."""
    return not scipy.ndimage.binary_erosion(area[_window_around(area, 1.0)], np.ones((3, 3), bool)).any()


def is_closed_line(points: Array) -> bool:
    """Return whether points, shape (N, 2) [px], are a line around an area whose ends nearly meet."""
    if len(points) < MIN_DRAWN_PLACES:
        return False
    length = polyline.path_length(np.concatenate([points, points[:1]]))
    area = 4.0 * math.pi * polyline.enclosed_area(points)
    return math.dist(points[0], points[-1]) <= _MAX_OPENING * length and area >= _MIN_ROUNDNESS * length**2


def close_line(points: Array, shape: Extent) -> Array:
    """Close a line in an image of this shape whose ends nearly meet by places between them.

    Others, and those that enclose an area as they are, shape (N, 2) [px], stay so.
    """
    if not is_closed_line(points) or not is_line(drawn_area(points, shape)):
        return points
    return polyline.sample_path(np.concatenate([points, points[:1]]), _MIN_LINK)


def _window_around(mask: Mask, margin: float) -> Window:
    """Return the window around a mask, which is not empty, with a margin; the whole image where it is at the border."""
    window = expand_window(bounding_window(mask), math.ceil(margin) + 1, mask.shape)
    inner = all(side.start > 0 and side.stop < n for side, n in zip(window, mask.shape, strict=True))
    return window if inner else whole_window(mask.shape)


def _enclosed_with_border(near: Mask, on: Mask) -> Mask:
    """Return the areas that rows of particles enclose with the image border, within the hull of a row.

    Rows that enclose nothing alone may be arcs of one line that leaves the image several times: their common hull
    counts.
    """
    parts, count = scipy.ndimage.label(~near)
    rows, _ = label_parts(near)
    enclosed, arcs = np.zeros(count + 1, bool), np.zeros_like(on)
    for row in np.setdiff1d(np.concatenate([rows[[0, -1]].ravel(), rows[:, [0, -1]].ravel()]), 0).tolist():
        alone = _are_in_hull(on & (rows == row), parts, count)
        enclosed |= alone
        if not alone.any():
            arcs |= on & (rows == row)
    if arcs.any():
        enclosed |= _are_in_hull(arcs, parts, count)
    return enclosed[parts]


def _are_in_hull(on: Mask, parts: NDArray[np.integer[Any]], count: int) -> Mask:
    """Return the parts, by number from 1 to `count`, that lie for the most part in the convex hull of some pixels."""
    hull: Callable[[Mask], Mask] = skimage.morphology.convex_hull_image
    share = np.asarray(scipy.ndimage.mean(hull(on), parts, np.arange(count + 1)))
    return (share >= _MIN_HULL_SHARE) & (np.arange(count + 1) > 0)


def is_everywhere(points: Array, shape: Extent, regions: AnyRegions | None = None, sides: Sides = (1.0, 1.0)) -> bool:
    """Return whether particles lie evenly all over an image, as a grid does.

    Parameters
    ----------
    points : ndarray, shape (N, D)
        The particles [px].
    shape : tuple of int
        Shape of the image.
    regions : Regions or VolumeRegions, optional
        Regions of interest, outside which no particle counts, nor needs there be one.
    sides : tuple of float
        Sides of a pixel, in which the distances of particles are even.
    """
    if regions is not None:
        points = points[regions.contains(points)]
    if len(points) < MIN_DRAWN_PLACES:
        return False
    extent, share = np.array(shape) * np.array(sides), 1.0
    if regions is not None:
        samples = _cell_centers(shape, (_REGION_SAMPLES,) * len(shape))
        share = max(int(np.count_nonzero(regions.contains(samples))), 1) / len(samples)
    side = _EVEN_SIDE * (share * np.prod(extent) / len(points)) ** (1.0 / len(shape))
    cells = tuple(np.ceil(extent / side).astype(int).tolist())
    place = np.clip((points + 0.5) / np.array(shape) * cells, 0, np.array(cells) - 1).astype(int)
    wanted = np.ones(math.prod(cells), bool)
    if regions is not None:
        wanted = regions.contains(_cell_centers(shape, cells))
    taken = np.zeros(len(wanted), bool)
    taken[np.ravel_multi_index(tuple(place.T), cells)] = True
    return bool(np.count_nonzero(taken & wanted) > _EVEN_SHARE * max(int(np.count_nonzero(wanted)), 1))


def _cell_centers(shape: Extent, cells: Sequence[int]) -> Array:
    """Return the centers of the cells that divide an image along its axes, shape (N, D) [px]."""
    lines = [(np.arange(count) + 0.5) * n / count - 0.5 for n, count in zip(shape, cells, strict=True)]
    return grid_points(lines)


def hollow_part(points: Array, area: Mask) -> Mask:
    """Return the part of a start's area that its particles, shape (N, 2) [px], only enclose; none of a filled one."""
    on, usual = _mark_particles(points, area.shape)
    hollow, box = np.zeros_like(area), bounding_window(area | on)
    hollow[box] = area[box] & (scipy.ndimage.distance_transform_edt(~on[box]) > max(_MIN_LINK, _HOLLOW_FACTOR * usual))
    return hollow


def _mark_particles(points: Array, shape: Extent) -> tuple[Mask, float]:
    """Return the pixels with particles, and the usual distance of neighbors [px], infinite where there are none."""
    on = np.zeros(shape, bool)
    on[tuple(nearest_pixels(points, shape).T)] = True
    if len(points) < 2:
        return on, np.inf
    return on, float(np.median(scipy.spatial.cKDTree(points).query(points, k=[2])[0]))


def typical_radius(area: Mask) -> float:
    """Return the median radius of the largest disks in the connected parts of an area, shape (H, W) [px]."""
    if not area.any():
        return 0.0
    area = area[_window_around(area, 0.0)]
    labels, count = label_parts(area)
    depth = scipy.ndimage.distance_transform_edt(area)
    return float(np.median(scipy.ndimage.maximum(depth, labels, np.arange(1, count + 1))))
