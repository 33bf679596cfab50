"""The background of a volume, and slits in its bodies: neither has edges around it."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import Labels, expand_window, nearest_pixels, window_around
from cpm_core.numerics.types import Array, Index, Single

_SAME_LEVEL = 1.5
"""Largest difference from the background of the median around a place that counts as none [its standard deviations]."""

_MIN_EDGE = 4.0
"""Least difference across a surface that is no noise [standard deviations of the background]."""

_MIN_NOISE = 0.005
"""Least standard deviation of gray levels, as a fraction of their range in the volume."""

_DEVIATION_PER_MEDIAN = 1.4826
"""Standard deviation of normal noise, in medians of its size."""

_EDGE_DISTANCE = 1.5
"""Distance from a surface at which gray levels are compared [smallest side of a voxel]."""

_MAX_EDGE_SHARE = 0.5
"""Share of a surface along edges up to which it bounds nothing."""

_SLIT_RIM_WIDTH = 2
"""Width of the rims on both sides of the outer wall of a hollow that are compared [voxels]."""

_SAME_RIM_LEVEL = 0.5
"""Largest difference between the medians of these rims without an edge [standard deviations of the outer one]."""


def lies_in_background(values: Array, place: Array, surface: Surface) -> bool:
    """Tell whether a place lies in the background of a volume, and so does most of the surface found around it.

    Gray levels at the place are those of the outermost voxels of the volume, and along most of the surface they differ
    by no more than noise, or it runs along the end of the volume.

    Parameters
    ----------
    values : ndarray, shape (P, R, C)
        Gray levels of the volume.
    place : ndarray, shape (3,)
        Place in it [voxels].
    surface : Surface
        Surface of what was found there.
    """
    level, noise = _measure_background(values)
    at = nearest_pixels(place, values.shape)
    around = values[window_around(at, 1)]
    if abs(float(np.median(around)) - level) > _SAME_LEVEL * noise:
        return False
    edges = np.abs(measure_edge_steps(values, surface)) > _MIN_EDGE * noise
    return int(np.count_nonzero(edges)) <= _MAX_EDGE_SHARE * len(surface.vertices)


def find_bodies_with_slits(values: Array, parts: Labels, hollows: Index, bodies: Labels) -> list[int]:
    """Find the body around each hollow if gray levels do not change from one to the other; else 0.

    `hollows` are numbers of some parts, shape (P, R, C), outside the bodies, of the same shape.

    Around what is brighter than the body that it lies in, the surface of a run has a second wall, where there is no
    edge. What lies between the two is a part of the body.
    """
    windows, span, found = scipy.ndimage.find_objects(parts), float(np.ptp(values)), []
    for number in hollows.tolist():
        near = expand_window(windows[number - 1], _SLIT_RIM_WIDTH, parts.shape)
        hollow = parts[near] == number
        filled = scipy.ndimage.binary_fill_holes(hollow)
        outer = scipy.ndimage.binary_dilation(filled, iterations=_SLIT_RIM_WIDTH) & ~filled & (bodies[near] > 0)
        inner = hollow & ~scipy.ndimage.binary_erosion(filled, iterations=_SLIT_RIM_WIDTH)
        level, noise = measure_level(values[near][outer], span)
        has_edge = abs(float(np.median(values[near][inner])) - level) > _SAME_RIM_LEVEL * noise
        found.append(0 if has_edge else int(np.bincount(bodies[near][outer]).argmax()))
    return found


def _measure_background(values: Array) -> tuple[float, float]:
    """Measure the gray level of the outermost voxels, and its standard deviation."""
    border = np.concatenate([values.take([0, -1], axis).ravel() for axis in range(3)])
    return measure_level(border, float(np.ptp(values)))


def measure_level(some: Array | Single, span: float) -> tuple[float, float]:
    """Measure the median of some gray levels of a volume, which spans so many, and their standard deviation."""
    level = float(np.median(some))
    return level, max(_DEVIATION_PER_MEDIAN * float(np.median(np.abs(some - level))), _MIN_NOISE * span)


def measure_edge_steps(values: Array, surface: Surface) -> Array:
    """Measure by how much gray levels rise inward across the vertices of a surface that lie within the volume."""
    away = _EDGE_DISTANCE * surface.normals * (min(surface.spacing) / np.array(surface.spacing))
    last = np.array(values.shape) - 1.0
    outside = surface.vertices + away
    within = ((outside >= 0.0) & (outside <= last)).all(axis=1)
    inner, outer = (
        scipy.ndimage.map_coordinates(values, places[within].T, float, order=1, mode="nearest")
        for places in (surface.vertices - away, outside)
    )
    return np.asarray(inner - outer)
