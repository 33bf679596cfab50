"""Closing open contours: joining both ends of a contour to each other, so that it encloses something.

Unlike the bridging of gaps, which joins ends that continue each other, this is done on request, to contours as they
are: an outline that is interrupted, or cut off by the border of the image.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.result import Result
from cpm_core.numerics.polyline import area, length, resampled
from cpm_core.numerics.types import Array
from cpm_core.reconstruction.curve.gap_bridging import direction_at_end, way_across

_WIDEST = 0.7
"""Widest gap between the ends of a contour that is closed, as a fraction of its length: that of half a circle, cut off
by the border of the image, is 0.64."""

_SMALLEST = 4.0
"""Area under which a closed contour would enclose nothing to speak of [px²]."""

_SPACING = 2.0
"""Largest distance between the vertices of what is added [px]."""


def can_be_closed(contour: Contour) -> bool:
    """Whether a contour is open and its ends are near enough to each other, as those of half a circle."""
    if contour.closed or len(contour.points) < 3 or area(contour.points) < _SMALLEST:
        return False
    return float(np.linalg.norm(contour.points[0] - contour.points[-1])) <= _WIDEST * contour.length


def close_contours(result: Result, edges: Array | None = None) -> Result:
    """Close the open contours of a result whose ends are near enough to each other (`can_be_closed`).

    Parameters
    ----------
    result : Result
        Outcome of a run.
    edges : ndarray, shape (H, W), optional
        Edge map of the image [gray levels / px]: what is added runs along its edges. Without it, it is straight.

    Returns
    -------
    Result
        With a bridge for each contour that has been closed.
    """
    contours, bridges = [], list(result.bridges)
    for contour in result.contours:
        if not can_be_closed(contour):
            contours.append(contour)
            continue
        path, strength, ends = contour.points[[-1, 0]], 0.0, contour.points[[-1, 0]]
        if edges is not None:
            edges = np.asarray(edges, dtype=float)
            directions = np.stack([direction_at_end(contour.points[::-1]), direction_at_end(contour.points)])
            clear = max(contour.strength, 1e-12)
            way = way_across(edges, clear, ends, directions) if math.dist(*ends) >= _SPACING else None
            path = ends if way is None else way[1]
        path = resampled(path, _SPACING)
        if edges is not None:
            strength = float(scipy.ndimage.map_coordinates(edges, path.T, order=1, mode="nearest").mean())
        bridges.append(Bridge(path, length(path), strength))
        mean = contour.strength
        if edges is not None:
            mean = (mean * contour.length + strength * length(path)) / (contour.length + length(path))
        points = np.concatenate([contour.points, path[1:-1]])
        contours.append(replace(contour, points=points, closed=True, strength=mean, junctions=(False, False)))
    return replace(result, contours=tuple(contours), bridges=tuple(bridges))
