"""From particles to contours: refine, thin, trace, simplify, link, threshold, bridge, and read contours."""

from __future__ import annotations

from cpm_core.contours.contour import Bridge, Contour, bridges_on
from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.regions import BarrierMap
from cpm_core.model.plane.births import select_survivors
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.curve.end_linking import close_gaps
from cpm_core.reconstruction.curve.gap_bridging import bridge_gaps
from cpm_core.reconstruction.curve.hysteresis import LEAST_LENGTH, choose, drop_unreached, drop_weak, shortest
from cpm_core.reconstruction.curve.ridge_tracing import trace
from cpm_core.reconstruction.curve.subpixel import ridge_points

_LEAST_JOINING_REACH = 2.5
"""Distance, in d_min, up to which two points may be joined for any insertion range."""

_LONGEST_SPECK = 2.0
"""Greatest length, in d_min, of isolated pieces that are removed as artifacts."""

_LONGEST_SPUR = 3.0
"""Greatest length, in d_min, of loose branches that are removed as artifacts."""

_JUNCTION_MERGE_DISTANCE = 1.0
"""Distance up to which junctions are merged, at least sigma [px]; the mouths of slits are wider."""

_BRIDGE_SPACING = 2.0
"""Largest distance between the vertices of a bridge [px]."""


def find_contours(
    positions: Array, scale_field: ScaleField, parameters: Parameters, at_rest: bool = False
) -> tuple[tuple[Contour, ...], tuple[Bridge, ...]]:
    """Find the contours through particles.

    Parameters
    ----------
    positions : ndarray, shape (N, 2)
        Particles [px of the scale].
    scale_field : ScaleField
        Fields of the scale.
    parameters : Parameters
        For `d_min`, `d_max`, `max_gap`, `min_strength`, `sure_edge`, `min_contrast` and `min_length`.
    at_rest : bool
        Whether all particles are at rest, so that longer stretches of an edge without particles are part of a contour.

    Returns
    -------
    contours : tuple of Contour
        In px of the scale, longest first.
    bridges : tuple of Bridge
        Bridged gaps in the contours.
    """
    on_edge = positions[scale_field.strength_at(positions) >= scale_field.floor]
    points, found = ridge_points(on_edge, scale_field)
    points = points[found & ~scale_field.barrier_map.crossed(on_edge, points)]
    kept = select_survivors(points, scale_field.strength_at(points), parameters.d_min)
    reach = max(parameters.d_min + parameters.d_max, _LEAST_JOINING_REACH * parameters.d_min)
    graph = Graph(*trace(points[kept], scale_field, parameters.d_min, at_rest))
    if scale_field.reached is not None:
        drop_unreached(graph, scale_field.reached)
    graph.drop_specks(_LONGEST_SPECK * parameters.d_min)
    close_gaps(graph, scale_field, reach)
    graph.drop_spurs(_LONGEST_SPUR * parameters.d_min)
    graph.merge_junctions(max(_JUNCTION_MERGE_DISTANCE, scale_field.smoothing))
    _cut(graph, scale_field.barrier_map)
    if max(parameters.min_strength, parameters.sure_edge, parameters.min_contrast) > 0.0:
        drop_weak(graph, scale_field, parameters)
        graph.drop_spurs(_LONGEST_SPUR * parameters.d_min)
    if parameters.max_gap == 0.0:  # else a short branch may be one side of a gap
        graph.drop_spurs(max(shortest(scale_field.smoothing, parameters), parameters.min_length))
    graph.drop_ties(shortest(scale_field.smoothing, parameters))
    spacing = min(parameters.d_min, _BRIDGE_SPACING)
    bridges = bridge_gaps(graph, scale_field, parameters.max_gap, spacing, LEAST_LENGTH * parameters.d_min)
    contours = choose(
        graph.contours(max(shortest(scale_field.smoothing, parameters), parameters.min_length)), scale_field, parameters
    )
    return contours, bridges_on(bridges, contours)


def _cut(graph: Graph, barrier_map: BarrierMap) -> None:
    """Remove the edges that cross a barrier: simplified curves may cut the corner that an edge goes around."""
    if not len(barrier_map.segments):
        return
    edges = graph.edges()
    graph.unlink(edges[barrier_map.crossed(graph.points[edges[:, 0]], graph.points[edges[:, 1]])])
