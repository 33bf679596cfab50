"""Closing open contours: joining both ends of a contour to each other, so that it encloses something.

Unlike the bridging of gaps, which joins ends that continue each other, this is done on request, to contours as they
are: an outline that is interrupted, or cut off by the border of the image.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy
import skimage

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.result import Result
from cpm_core.numerics.polyline import area, length, resampled
from cpm_core.numerics.types import Array
from cpm_core.reconstruction.curve.gap_bridging import continuation, smoothed

_WIDEST = 0.7
"""Widest gap between the ends of a contour that is closed, as a fraction of its length: that of half a circle, cut off
by the border of the image, is 0.64."""

_SMALLEST = 4.0
"""Area under which a closed contour would enclose nothing to speak of [px²]."""

_SPACING = 2.0
"""Largest distance between the vertices of what is added [px]."""

_BACK = 6.0
"""Length of the last stretch of a contour that gives its direction [px]."""

_EASE, _LEAVING = 20.0, 0.04
"""Ratio, less one, of the costs of a step without an edge and on an edge as strong as the contour; additional cost of
a step for each pixel of distance from the smooth continuation of both ends."""

_DETOUR = 1.6
"""Longest way along the edges, in lengths of the gap; a longer one is replaced by the straight line."""


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
        path = _straight(contour) if edges is None else _along(contour, np.asarray(edges, dtype=float))
        path = resampled(path, _SPACING)
        strength = 0.0 if edges is None else _strength(edges, path)
        bridges.append(Bridge(path, length(path), strength))
        mean = contour.strength
        if edges is not None:
            mean = (mean * contour.length + strength * length(path)) / (contour.length + length(path))
        points = np.concatenate([contour.points, path[1:-1]])
        contours.append(replace(contour, points=points, closed=True, strength=mean, junctions=(False, False)))
    return replace(result, contours=tuple(contours), bridges=tuple(bridges))


def _straight(contour: Contour) -> Array:
    return contour.points[[-1, 0]]


def _along(contour: Contour, edges: Array) -> Array:
    """The way of least cost along the edges from the last vertex to the first; straight where that is a detour."""
    first, last = contour.points[0], contour.points[-1]
    gap = float(np.linalg.norm(first - last))
    if gap < _SPACING:
        return _straight(contour)
    guide = continuation(last, _direction(contour.points), first, _direction(contour.points[::-1]))
    border = np.array(edges.shape) - 1
    low = np.clip(np.floor(guide.min(axis=0) - 0.5 * gap - 3.0), 0, border).astype(int)
    high = np.clip(np.ceil(guide.max(axis=0) + 0.5 * gap + 3.0), 0, border).astype(int)
    window = edges[low[0] : high[0] + 1, low[1] : high[1] + 1]
    places = np.moveaxis(np.indices(window.shape), 0, -1) + low
    off = scipy.spatial.cKDTree(guide).query(places)[0]
    costs = 1.0 / (1.0 + _EASE * window / max(contour.strength, 1e-12)) + _LEAVING * off
    start, end = (np.clip(np.rint(place), low, high).astype(int) - low for place in (last, first))
    search = skimage.graph.MCP_Geometric(costs)
    search.find_costs([start], [end])
    path = smoothed(np.array(search.traceback(end), dtype=float) + low, last, first)
    return path if length(path) <= _DETOUR * gap else _straight(contour)


def _direction(points: Array) -> Array:
    """Unit vector in which a curve leaves its last vertex."""
    back = np.linalg.norm(points[::-1] - points[-1], axis=1)
    far = int(np.argmax(back >= _BACK)) or len(points) - 1
    way = points[-1] - points[::-1][far]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-12))


def _strength(edges: Array, path: Array) -> float:
    """Mean of the edge map along a path [gray levels / px]."""
    return float(scipy.ndimage.map_coordinates(np.asarray(edges, dtype=float), path.T, order=1, mode="nearest").mean())
