"""Which contours stay: those that are strong enough, or connected to strong ones, and long enough.

What is weak is taken out of the graph before contours are walked, so that an outline which a weak branch ran into is
one contour again. For every criterion each edge of the graph has a rating, which does not depend on any threshold;
therefore a higher threshold only ever takes away.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contour import Contour
from cpm_core.level import Level
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.graph import Graph

Array = NDArray[np.float64]
Ratings = Mapping[tuple[int, int], float]

LEAST_LENGTH, _LEAST_IN_SIGMA = 4.0, 8.0
"""Length, in d_min and in sigma, under which a contour is none: nothing as small as that outlives the smoothing. A
closed one must enclose a square of side d_min as well."""

_STRETCH = 9
"""Vertices over which the rating of a stretch is averaged: shorter dips do not cut a contour."""


def drop_weak(graph: Graph, level: Level, parameters: Parameters) -> None:
    """Take weak contours out of a graph, with hysteresis.

    Contours under `min_strength` or `min_contrast` go, and of those that end loose the stretches under it. What is left
    stays where it is connected, through junctions and along other contours, to some that reaches `sure_edge`.

    Parameters
    ----------
    graph : Graph
        Changed in place.
    level : Level
        Fields of the scale.
    parameters : Parameters
        For `min_strength`, `sure_edge` and `min_contrast`.
    """
    strength = ratings(graph, level.strength)
    drop_under(graph, strength, parameters.min_strength)
    if parameters.min_contrast > 0.0:
        drop_under(graph, ratings(graph, level.contrast), parameters.min_contrast)
    drop_unconnected(graph, level.strength(graph.points), parameters.sure_edge * level.strongest)


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
    dict
        Edge (a, b), a < b, to rating.
    """
    values = measure(graph.points)
    rated: dict[tuple[int, int], float] = {}
    for path, closed in graph.walks():
        along = values[path]
        loose = not closed and min(graph.degree(path[0]), graph.degree(path[-1])) == 1
        if loose and len(path) > _STRETCH:
            along = scipy.ndimage.uniform_filter1d(along, _STRETCH, mode="nearest")
            each = 0.5 * (along[:-1] + along[1:])
        else:
            each = np.full(len(path), along.mean())
        sides = pairwise([*path, path[0]] if closed else path)
        rated.update({(min(side), max(side)): float(r) for side, r in zip(sides, each, strict=False)})
    return rated


def drop_under(graph: Graph, rated: Ratings, least: float) -> None:
    """Take away the edges of a graph that are rated under `least`."""
    for (a, b), rating in rated.items():
        if rating < least:
            graph.unlink(a, b)


def drop_unconnected(graph: Graph, strength: Array, sure: float) -> None:
    """Take away all that is not connected to a vertex of strength `sure` or more."""
    reached: set[int] = set()
    waiting = np.flatnonzero(strength >= sure).tolist()
    while waiting:
        vertex = waiting.pop()
        if vertex not in reached:
            reached.add(vertex)
            waiting.extend(graph.links[vertex])
    for a, b in graph.edges().tolist():
        if a not in reached:
            graph.unlink(a, b)


def shortest(level: Level, parameters: Parameters) -> float:
    """Length under which a contour is none, whatever the least length asked for [px]."""
    return max(LEAST_LENGTH * parameters.d_min, _LEAST_IN_SIGMA * level.smoothing)


def choose(contours: tuple[Contour, ...], level: Level, parameters: Parameters) -> tuple[Contour, ...]:
    """Measure contours and leave out the short and the degenerate.

    Parameters
    ----------
    contours : tuple of Contour
        Contours of a graph.
    level : Level
        Fields of the scale.
    parameters : Parameters
        For `d_min` and `min_length`.

    Returns
    -------
    tuple of Contour
        Those that stay, with their strength.
    """
    least = max(shortest(level, parameters), parameters.min_length)
    return tuple(
        replace(c, strength=float(level.strength(c.points).mean()), contrast=float(level.contrast(c.points).mean()))
        for c in contours
        if c.length >= least and (not c.closed or c.area >= parameters.d_min**2)
    )
