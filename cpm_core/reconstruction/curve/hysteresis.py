"""Hysteresis thresholding: contours stay that are strong enough, or connected to strong ones, and long enough.

Weak edges are removed from the graph before contours are read from it, so that an outline with a weak branch becomes
one contour again. For every criterion each edge of the graph has a rating that does not depend on a threshold;
therefore a higher threshold only removes more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.contours.contour import Contour
from cpm_core.contours.graph import Graph
from cpm_core.field.region_contrast import MeanContrast
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.grids import nearest_pixels
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.parameters import Parameters

MIN_LENGTH_IN_SPACINGS = 4.0
"""Least length of a contour, in d_min. A closed one must also enclose the area of a square of side d_min."""

_MIN_LENGTH_IN_SIGMA = 8.0
"""Least length of a contour, in sigma: smaller objects do not survive the smoothing."""

_RATED_VERTICES = 9
"""Number of vertices over which ratings are averaged, so that shorter weak parts do not cut a contour."""


def drop_weak(graph: Graph, scale_field: ScaleField, parameters: Parameters) -> None:
    """Remove weak contours from a graph, in place, with hysteresis.

    Contours under `min_strength` or `min_contrast` are removed; of contours with a loose end only the weak stretches.
    The others stay if they are connected, through junctions and other contours, to one that reaches `sure_edge`.
    """
    least = (parameters.min_strength, scale_field.strength_at), (parameters.min_contrast, scale_field.contrast_at)
    for threshold, measure in least:
        if threshold > 0.0:
            edges, rating = rate_edges(graph, measure)
            graph.remove_edges(edges[rating < threshold])
    if parameters.sure_edge > 0.0:
        drop_unconnected(graph, scale_field.strength_at(graph.points), parameters.sure_edge * scale_field.strongest)


def drop_beyond(graph: Graph, area: Mask, particles: Array, distance: float) -> None:
    """Remove what is traced outside an area, shape (H, W), farther than a distance [px] from any particle, (N, 2)."""
    place = nearest_pixels(graph.points, area.shape)
    beyond = np.flatnonzero(~area[tuple(place.T)])
    away, _ = scipy.spatial.cKDTree(particles).query(graph.points[beyond]) if len(particles) else (np.inf, None)
    gone = np.zeros(len(graph.points), bool)
    gone[beyond] = away > distance
    edges = graph.edges()
    graph.remove_edges(edges[gone[edges].any(axis=1)])


def rate_edges(graph: Graph, measure: Callable[[Array], Array]) -> tuple[Index, Array]:
    """Rate every edge of a graph, shape (E, 2), by a measure of points, shape (N, 2) -> (N,); ratings have shape (E,).

    A closed contour, or one between two junctions, is rated as a whole by its mean, so that a weak stretch does not
    open it. A contour with a loose end is rated stretch by stretch, since it fades gradually.
    """
    ways = graph.find_paths()
    values = measure(graph.points)
    edges, way = ways.path_edges()
    counts = np.diff(ways.start)
    mean = np.add.reduceat(values[ways.vertices], ways.start[:-1]) / counts if len(ways) else values[:0]
    rating = mean[way]
    loose = ~ways.closed & (np.minimum(graph.degrees[ways.first], graph.degrees[ways.last]) == 1)
    start = np.searchsorted(way, np.arange(len(ways)))
    for n in np.flatnonzero(loose & (counts > _RATED_VERTICES)).tolist():
        along = scipy.ndimage.uniform_filter1d(values[ways.path_vertices(n)], _RATED_VERTICES, mode="nearest")
        rating[start[n] : start[n] + len(along) - 1] = 0.5 * (along[:-1] + along[1:])
    return edges, rating


def drop_unconnected(graph: Graph, strength: Array, sure: float) -> None:
    """Remove everything not connected to a vertex with a strength, shape (N,), of at least `sure`."""
    ways = graph.find_paths()
    if not len(ways):
        return
    part = graph.label_components()
    strongest = np.full(part.max() + 1, -np.inf)
    np.maximum.at(strongest, part, np.maximum.reduceat(strength[ways.vertices], ways.start[:-1]))
    graph.drop_paths(strongest[part] < sure)


def least_contour_length(smoothing: float, parameters: Parameters) -> float:
    """Return the least length of a contour for any `min_length`, after a Gaussian of `smoothing` px [px]."""
    return max(MIN_LENGTH_IN_SPACINGS * parameters.d_min, _MIN_LENGTH_IN_SIGMA * smoothing)


def select_contours(
    contours: tuple[Contour, ...], scale_field: ScaleField, parameters: Parameters
) -> tuple[Contour, ...]:
    """Select the contours that are neither too short nor degenerate, with their strength and contrast."""
    least = max(least_contour_length(scale_field.smoothing, parameters), parameters.min_length)
    chosen = [c for c in contours if c.length >= least and (not c.closed or c.area >= parameters.d_min**2)]
    return measure_contours(chosen, scale_field)


def measure_contours(contours: Sequence[Contour], scale_field: ScaleField) -> tuple[Contour, ...]:
    """Measure the strength of contours, and prepare their contrast."""
    if not contours:
        return ()
    points = np.concatenate([c.points for c in contours])
    bounds = np.cumsum([0, *(len(c.points) for c in contours)])
    strength, normals = scale_field.strength_at(points), scale_field.normals_at(points)
    found = []
    for contour, a, b in zip(contours, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        sides = MeanContrast(scale_field.values, contour.points, normals[a:b], scale_field.smoothing)
        found.append(replace(contour, strength=float(strength[a:b].mean()), measure_contrast=sides))
    return tuple(found)
