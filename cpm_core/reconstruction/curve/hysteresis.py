"""Which contours stay: those that are strong enough, or connected to strong ones, and long enough.

What is weak is taken out of the graph before contours are walked, so that an outline which a weak branch ran into is
one contour again. For every criterion each edge of the graph has a rating, which does not depend on any threshold;
therefore a higher threshold only ever takes away.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.graph import Graph
from cpm_core.field.region_contrast import Sides
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

LEAST_LENGTH, _LEAST_IN_SIGMA = 4.0, 8.0
"""Length, in d_min and in sigma, under which a contour is none: nothing as small as that outlives the smoothing. A
closed one must enclose a square of side d_min as well."""

_STRETCH = 9
"""Vertices over which the rating of a stretch is averaged: shorter dips do not cut a contour."""


class Ratings(NamedTuple):
    """What the edges of a graph are rated by.

    Attributes
    ----------
    edges : ndarray of int64, shape (E, 2)
        Every edge once.
    rating : ndarray, shape (E,)
        Of each.
    """

    edges: NDArray[np.int64]
    rating: Array


def drop_weak(graph: Graph, scale_field: ScaleField, parameters: Parameters) -> None:
    """Take weak contours out of a graph, with hysteresis.

    Contours under `min_strength` or `min_contrast` go, and of those that end loose the stretches under it. What is left
    stays where it is connected, through junctions and along other contours, to some that reaches `sure_edge`.

    Parameters
    ----------
    graph : Graph
        Changed in place.
    scale_field : ScaleField
        Fields of the scale.
    parameters : Parameters
        For `min_strength`, `sure_edge` and `min_contrast`.
    """
    if parameters.min_strength > 0.0:
        drop_under(graph, ratings(graph, scale_field.strength), parameters.min_strength)
    if parameters.min_contrast > 0.0:
        drop_under(graph, ratings(graph, scale_field.contrast), parameters.min_contrast)
    if parameters.sure_edge > 0.0:
        drop_unconnected(graph, scale_field.strength(graph.points), parameters.sure_edge * scale_field.strongest)


def ratings(graph: Graph, measure: Callable[[Array], Array]) -> Ratings:
    """Rate every edge of a graph by something that can be measured at its vertices.

    A contour that is closed, or runs from junction to junction, is rated as a whole, by its mean: a weak stretch shall
    not open it. One that ends loose is rated stretch by stretch: such a contour runs out gradually, and its weak
    stretches tell nothing about the strong ones.

    Parameters
    ----------
    graph : Graph
        The graph.
    measure : callable
        Points, shape (N, 2), to values, shape (N,).

    Returns
    -------
    Ratings
        Edges in the order in which they are walked along.
    """
    ways = graph.ways()
    values = measure(graph.points)
    edges, way = ways.edges()
    counts = np.diff(ways.start)
    mean = np.add.reduceat(values[ways.vertices], ways.start[:-1]) / counts if len(ways) else values[:0]
    rating = mean[way]
    loose = ~ways.closed & (np.minimum(graph.degrees[ways.first], graph.degrees[ways.last]) == 1)
    start = np.searchsorted(way, np.arange(len(ways)))
    for n in np.flatnonzero(loose & (counts > _STRETCH)).tolist():
        along = scipy.ndimage.uniform_filter1d(values[ways.path(n)], _STRETCH, mode="nearest")
        rating[start[n] : start[n] + len(along) - 1] = 0.5 * (along[:-1] + along[1:])
    return Ratings(edges, rating)


def drop_under(graph: Graph, rated: Ratings, least: float) -> None:
    """Take away the edges of a graph that are rated under `least`."""
    graph.unlink(rated.edges[rated.rating < least])


def drop_unconnected(graph: Graph, strength: Array, sure: float) -> None:
    """Take away all that is not connected to a vertex of strength `sure` or more."""
    ways = graph.ways()
    if not len(ways):
        return
    size = len(graph.points)
    first, last = ways.first, ways.last
    joined = scipy.sparse.coo_array((np.ones(len(ways)), (first, last)), shape=(size, size))
    part = scipy.sparse.csgraph.connected_components(joined, directed=False)[1][first]
    strongest = np.full(size, -np.inf)
    np.maximum.at(strongest, part, np.maximum.reduceat(strength[ways.vertices], ways.start[:-1]))
    graph.drop_ways(strongest[part] < sure)


def shortest(scale_field: ScaleField, parameters: Parameters) -> float:
    """Length under which a contour is none, whatever the least length asked for [px]."""
    return max(LEAST_LENGTH * parameters.d_min, _LEAST_IN_SIGMA * scale_field.smoothing)


def choose(contours: tuple[Contour, ...], scale_field: ScaleField, parameters: Parameters) -> tuple[Contour, ...]:
    """Measure contours and leave out the short and the degenerate.

    Parameters
    ----------
    contours : tuple of Contour
        Contours of a graph.
    scale_field : ScaleField
        Fields of the scale.
    parameters : Parameters
        For `d_min` and `min_length`.

    Returns
    -------
    tuple of Contour
        Those that stay, with their strength.
    """
    least = max(shortest(scale_field, parameters), parameters.min_length)
    chosen = [c for c in contours if c.length >= least and (not c.closed or c.area >= parameters.d_min**2)]
    if not chosen:
        return ()
    points = np.concatenate([c.points for c in chosen])
    bounds = np.cumsum([0, *(len(c.points) for c in chosen)])
    strength, normals = scale_field.strength(points), scale_field.normals(points)
    measured = []
    for contour, a, b in zip(chosen, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        sides = Sides(scale_field.values, contour.points, normals[a:b], scale_field.smoothing)
        measured.append(replace(contour, strength=float(strength[a:b].mean()), sides=sides))
    return tuple(measured)
