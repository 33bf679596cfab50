"""The whole way from particles to contours: refine, thin, fill, crust, tidy, close, choose, bridge, walk."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.bridge import Bridge
from cpm_core.contour import Contour
from cpm_core.level import FAINTEST, Level
from cpm_core.parameters import Parameters
from cpm_core.population import deletion
from cpm_core.reconstruction.bridging import bridge_gaps, bridges_of
from cpm_core.reconstruction.choosing import LEAST_LENGTH, choose, drop_weak
from cpm_core.reconstruction.closing import close_gaps
from cpm_core.reconstruction.curve import crust
from cpm_core.reconstruction.filling import fill
from cpm_core.reconstruction.graph import Graph
from cpm_core.reconstruction.refinement import crest

Array = NDArray[np.float64]

_LEAST_REACH = 2.5
"""Distance, in d_min, up to which two points may be joined however small the insertion range is."""

_SPUR = 3
"""Edges that a loose branch at a junction must exceed to be more than an irregularity of the points."""

_BRIDGE_SPACING = 2.0
"""Largest distance of the vertices of a bridge [px]."""


def find_contours(
    positions: Array, level: Level, parameters: Parameters
) -> tuple[tuple[Contour, ...], tuple[Bridge, ...]]:
    """Contours that particles have found.

    Parameters
    ----------
    positions : ndarray, shape (N, 2)
        Particles [px of the scale].
    level : Level
        Fields of the scale.
    parameters : Parameters
        For `d_min`, `d_max`, `max_gap`, `min_strength`, `sure_edge`, `min_contrast` and `min_length`.

    Returns
    -------
    contours : tuple of Contour
        In px of the scale, longest first.
    bridges : tuple of Bridge
        Gaps that were bridged in them.
    """
    strength = level.strength(positions)
    seated = positions[strength >= level.floor]
    points, found = crest(seated, level)
    points = points[found & ~level.walls.crossed(seated, points)]
    strength = level.strength(points)
    kept = deletion(points, strength, level.shape, parameters.d_min)
    points = fill(points[kept], level, parameters.d_min)
    strength = level.strength(points)
    reach = max(parameters.d_min + parameters.d_max, _LEAST_REACH * parameters.d_min)
    edges = crust(points)
    edges = edges[_supported(points, strength, edges, level, reach)]
    graph = Graph(points, edges)
    graph.drop_triangles()
    graph.drop_spurs(_SPUR)
    close_gaps(graph, level, reach)
    graph.drop_spurs(_SPUR)
    if max(parameters.min_strength, parameters.sure_edge, parameters.min_contrast) > 0.0:
        drop_weak(graph, level, parameters)
        graph.drop_spurs(_SPUR)
    spacing = min(parameters.d_min, _BRIDGE_SPACING)
    bridges = bridge_gaps(graph, level, parameters.max_gap, spacing, LEAST_LENGTH * parameters.d_min)
    contours = choose(graph.contours(), level, parameters)
    return contours, bridges_of(bridges, contours)


def _supported(
    points: Array, strength: Array, edges: NDArray[np.int64], level: Level, reach: float
) -> NDArray[np.bool_]:
    """Which edges of the crust are short, follow an edge of the image and cross no wall."""
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    between = level.strength(0.5 * (a + b))
    faintest = FAINTEST * np.maximum(level.floor, np.minimum(strength[edges[:, 0]], strength[edges[:, 1]]))
    near = np.linalg.norm(a - b, axis=1) <= reach
    return np.asarray(near & (between >= faintest) & ~level.walls.crossed(a, b))
