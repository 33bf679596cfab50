"""Faces: the small regions that contours and the ridges of the edge map cut the image into.

A face is a basin of the watershed of the edge map in which contours and barriers stand as walls, so that its border
lies on a contour where there is one beside it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour, sampled
from cpm_core.image.regions import Regions
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Mask

Labels = NDArray[np.int32]

_SAMPLING = 0.5
"""Distance of the points along a barrier that mark its pixels [px]."""


def walls(contours: Sequence[Contour], shape: tuple[int, ...]) -> Mask:
    """Pixels that contours pass through, shape `shape`."""
    return _marked(sampled(contours), shape)


def barrier_walls(regions: Regions | None, shape: tuple[int, ...]) -> Mask:
    """Pixels that barriers pass through, shape `shape`."""
    lines = regions.barriers if regions is not None else ()
    places = [polyline.sampled(np.array(line), _SAMPLING) for line in lines]
    return _marked(np.concatenate([np.empty((0, 2)), *places]), shape)


def basins(strength: Array, wall: Mask, least_depth: float) -> Labels:
    """Watershed basins of an edge map, none of which reaches across a wall.

    Parameters
    ----------
    strength : ndarray, shape (H, W)
        Edge map.
    wall : ndarray of bool, shape (H, W)
        Pixels of contours and barriers; they are the last to be given to a basin.
    least_depth : float
        Basins that are less deep than this are parts of a neighbor, in the unit of `strength`.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Basin of every pixel, from 0.
    """
    levels = np.where(wall, np.inf, np.floor(strength / least_depth) if least_depth > 0.0 else strength)
    lowest = skimage.morphology.local_minima(levels, connectivity=1)  # type: ignore[no-untyped-call]
    pits, count = scipy.ndimage.label(lowest & ~wall)
    if count == 0:
        return np.zeros(strength.shape, np.int32)
    levels[wall] = levels[~wall].max() + 1.0
    flooded = skimage.segmentation.watershed(levels, pits, connectivity=1)  # type: ignore[no-untyped-call]
    return np.asarray(flooded - 1, dtype=np.int32)


def _marked(places: Array, shape: tuple[int, ...]) -> Mask:
    marked = np.zeros(shape, np.bool_)
    pixel = np.rint(places).astype(np.int64)
    pixel = pixel[((pixel >= 0) & (pixel < shape)).all(axis=1)]
    marked[pixel[:, 0], pixel[:, 1]] = True
    return marked
