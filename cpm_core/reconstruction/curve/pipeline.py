"""From particles to contours: refine, thin, trace, simplify, link, threshold, bridge, and read contours."""

from __future__ import annotations

from cpm_core.contours.contour import Bridge, Contour, select_bridges_on
from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.regions import BarrierMap
from cpm_core.model.plane.births import select_survivors
from cpm_core.numerics.polyline import path_length
from cpm_core.numerics.types import Array, Arrays
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.curve.end_linking import link_loose_ends
from cpm_core.reconstruction.curve.gap_bridging import bridge_gaps
from cpm_core.reconstruction.curve.hysteresis import (
    MIN_LENGTH_IN_SPACINGS,
    drop_beyond,
    drop_weak,
    least_contour_length,
    select_contours,
)
from cpm_core.reconstruction.curve.ridge_tracing import trace_ridges
from cpm_core.reconstruction.curve.subpixel import refine_to_ridge

_MIN_JOINING_REACH = 2.5
"""Distance, in d_min or sigma, up to which two points may be joined for any insertion range: as far from the side of a
stronger edge, an edge that meets it ends."""

_LONGEST_SPECK = 2.0
"""Greatest length, in d_min, of isolated pieces that are removed as artifacts."""

_LONGEST_SPUR = 3.0
"""Greatest length, in d_min, of loose branches that are removed as artifacts."""

_JUNCTION_MERGE_DISTANCE = 1.0
"""Distance up to which junctions are merged, at least sigma [px]; the mouths of slits are wider."""

_LEAST_APPARENT_WIDTH = 2.0
"""Least distance at which the two sides of a slit or a limb appear after smoothing, in sigma: contours that pass each
other nearer cross there, as at an X."""

_WIDEST_SLIT_MOUTH = 2.5
"""Greatest length, in sigma, of links across the mouths of slits that smoothing closes; sides farther apart have
none."""

_BRIDGE_SPACING = 2.0
"""Largest distance between the vertices of a bridge [px]."""


def find_contours(
    positions: Array, scale_field: ScaleField, parameters: Parameters, at_rest: bool = False
) -> tuple[tuple[Contour, ...], tuple[Bridge, ...], Arrays]:
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
    links : tuple of ndarray, each of shape (K, 2)
        Pieces between two contours that are too short to be contours, but separate faces.
    """
    on_edge = positions[scale_field.strength_at(positions) >= scale_field.floor]
    points, found = refine_to_ridge(on_edge, scale_field)
    points = points[found & ~scale_field.barrier_map.is_crossed_by(on_edge, points)]
    kept = select_survivors(points, scale_field.strength_at(points), parameters.d_min)
    reach = max(parameters.d_min + parameters.d_max, _MIN_JOINING_REACH * max(parameters.d_min, scale_field.smoothing))
    graph = Graph(*trace_ridges(points[kept], scale_field, parameters.d_min, at_rest))
    if scale_field.area.size:
        drop_beyond(graph, scale_field.area, points[kept], 0.5 * reach)
    graph.drop_specks(_LONGEST_SPECK * parameters.d_min)
    link_loose_ends(graph, scale_field, reach)
    graph.drop_spurs(_LONGEST_SPUR * parameters.d_min)
    graph.merge_junctions(max(_JUNCTION_MERGE_DISTANCE, scale_field.smoothing))
    _remove_barrier_crossings(graph, scale_field.barrier_map)
    if max(parameters.min_strength, parameters.sure_edge, parameters.min_contrast) > 0.0:
        drop_weak(graph, scale_field, parameters)
        graph.drop_spurs(_LONGEST_SPUR * parameters.d_min)
    if parameters.max_gap == 0.0:  # else a short branch may be one side of a gap
        graph.drop_spurs(max(least_contour_length(scale_field.smoothing, parameters), parameters.min_length))
    least = least_contour_length(scale_field.smoothing, parameters)
    links = [
        link
        for link in graph.drop_junction_links(least)
        if path_length(link) >= _WIDEST_SLIT_MOUTH * scale_field.smoothing
    ]
    links += list(graph.find_passes(_LEAST_APPARENT_WIDTH * scale_field.smoothing))
    spacing = min(parameters.d_min, _BRIDGE_SPACING)
    bridges = bridge_gaps(graph, scale_field, parameters.max_gap, spacing, MIN_LENGTH_IN_SPACINGS * parameters.d_min)
    contours = select_contours(graph.extract_contours(max(least, parameters.min_length)), scale_field, parameters)
    return contours, select_bridges_on(bridges, contours), tuple(links)


def _remove_barrier_crossings(graph: Graph, barrier_map: BarrierMap) -> None:
    """Remove the edges that cross a barrier: simplified curves may cut the corner that an edge goes around."""
    if not len(barrier_map.segments):
        return
    edges = graph.edges()
    graph.remove_edges(edges[barrier_map.is_crossed_by(graph.points[edges[:, 0]], graph.points[edges[:, 1]])])
