"""Bridging gaps: joining loose ends where the edge is interrupted or faint.

A bridge is a path of least cost over the edge map: the stronger the edge, the lower the cost of a step. It therefore
follows a faint edge. Without any edge, a small cost for the distance from the smooth continuation of both ends keeps
the bridge on that curve.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy
import skimage

from cpm_core.contours.contour import Bridge
from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.grids import nearest_pixels
from cpm_core.numerics.polyline import lengths_along, pair_neighbors, path_length, resample_path
from cpm_core.numerics.segments import first_crossing
from cpm_core.numerics.types import Array, Index, Integers, Mask, record

EXTRA_COST_OFF_EDGE = 20.0
"""Cost of a step without an edge, relative to that on a clear edge, less one."""

_LEAVING_COST = 0.04
"""Additional cost of a step for each pixel of distance from the smooth continuation."""

BLOCKED_COST = 30.0
"""Additional cost of a step on a contour or barrier."""

UNBLOCKED_RADIUS = 2.0
"""Distance from the ends of a path within which nothing is avoided [px]."""

_DIRECTION_LENGTH = 6.0
"""Length of the last stretch of a contour that gives its direction [px]."""

_STRENGTH_LENGTH = 12.0
"""Length of the last stretch of a contour that gives its strength [px]."""

_END_TURN_COSINE = 0.26
"""Least cosine between the direction of an end and that to another end (75 degrees)."""

_SIDE_TURN_COSINE = 0.87
"""Least cosine between the direction of an end and that to the side of a contour (30 degrees)."""

_INCIDENCE_COSINE = 0.82
"""Largest cosine between a bridge and the side that it meets (35 degrees), so that parallel lines are not joined."""

_MAX_BRIDGE_DETOUR = 1.6
"""Greatest length of a bridge, in lengths of the gap."""

_MIN_PATH_AROUND = 3.0
"""Least length of the path along a contour between two of its vertices that may be joined, in lengths of the gap."""

_SIDE_COST_FACTOR = 1.5
"""Factor by which the side of a contour must be cheaper than an end to have priority."""

_BARRIER_LOOKAHEAD = 0.5
"""Distance ahead, as a fraction of the shortest curve, within which a barrier counts as the reason for an end."""

_SMOOTHING_PASSES = 6
"""Number of smoothing passes over a pixel path."""


@record
class _BridgeCandidate:
    """Candidate for a bridge: its cost, its two vertices, and its points including theirs, shape (K, 2)."""

    cost: float
    end: int
    other: int
    path: Array


def bridge_gaps(
    graph: Graph, scale_field: ScaleField, max_gap: float, spacing: float, min_curve_length: float
) -> tuple[Bridge, ...]:
    """Join loose ends to each other and to the sides of contours; returns the bridges, cheapest first.

    No bridge crosses a contour or a barrier, or turns back. A curve that ends at a barrier or at the border of a region
    of interest has no gap there.

    Parameters
    ----------
    graph : Graph
        Changed in place: the vertices of bridges are added.
    scale_field : ScaleField
        Fields of the scale.
    max_gap : float
        Widest gap [px]; 0 for none.
    spacing : float
        Largest distance between the vertices of a bridge [px].
    min_curve_length : float
        Length of the shortest curve that is joined [px].
    """
    ends = _find_loose_ends(graph, scale_field, min_curve_length) if max_gap > 0.0 else {}
    if not ends:
        return ()
    site = _BridgeSite(graph, scale_field)
    ways = [*_bridges_between_ends(graph, site, ends, max_gap), *_bridges_to_sides(graph, site, ends, max_gap)]
    built = []
    for way in sorted(ways, key=lambda way: (way.cost, way.end, way.other)):
        joins_end = way.other in ends
        if graph.degree(way.end) != 1 or (joins_end and graph.degree(way.other) != 1):
            continue
        path = resample_path(way.path, spacing)
        if site.is_free(path, (way.end, way.other)):
            site.add_bridge(way.end, path[1:-1], way.other)
            built.append(Bridge(path, path_length(path), float(scale_field.strength_at(path).mean())))
    return tuple(built)


class _BridgeSite:
    """Surroundings in which bridges are built: the graph, its edges, and the pixels of contours and barriers."""

    def __init__(self, graph: Graph, scale_field: ScaleField) -> None:
        self.graph = graph
        self.scale_field = scale_field
        self._edges = graph.edges()
        a, b = graph.points[self._edges].swapaxes(0, 1)
        self.blocked = np.zeros(scale_field.shape, np.bool_)
        for t in np.linspace(0.0, 1.0, 5):
            places = np.rint(a + t * (b - a)).astype(np.int64)
            self.blocked[tuple(np.clip(places, 0, np.array(scale_field.shape) - 1).T)] = True
        if len(scale_field.barrier_map.segments):
            self.blocked |= scale_field.barrier_map.clearance <= 0.0

    def strength_at_end(self, end: int) -> float:
        """Measure the edge strength near a loose end, at least the floor."""
        stretch = stretch_from_start(self.graph.points[self.graph.branch_from(end)], _STRENGTH_LENGTH)
        return max(float(self.scale_field.strength_at(stretch).max()), self.scale_field.floor)

    def find_crossing(self, path: Array, spared: Integers) -> tuple[int, tuple[int, int]] | None:
        """Find the first segment of a path, shape (K, 2), that crosses an edge off `spared` vertices, and that edge."""
        edges = self._edges[~np.isin(self._edges, spared).any(axis=1)]
        at, crossed = first_crossing(path, self.graph.points[edges].reshape(-1, 4))
        if crossed < 0:
            return None
        one, other = edges[crossed].tolist()
        return at, (one, other)

    def add_bridge(self, end: int, between: Array, other: int) -> None:
        """Add a bridge to the graph through new vertices at positions of shape (K, 2)."""
        first = len(self.graph.points)
        self.graph.add_path(end, between, other)
        way = np.array([end, *range(first, first + len(between)), other], dtype=np.int64)
        self._edges = np.concatenate([self._edges, pair_neighbors(way)])

    def is_free(self, path: Array, spared: Integers) -> bool:
        """Return whether a path, shape (K, 2), crosses neither a contour nor a barrier."""
        return (
            not self.scale_field.barrier_map.is_crossed_by(path[:-1], path[1:]).any()
            and self.find_crossing(path, spared) is None
        )


def _bridges_between_ends(
    graph: Graph, site: _BridgeSite, ends: dict[int, Array], longest: float
) -> Iterator[_BridgeCandidate]:
    """Yield bridges from end to end."""
    number = np.array(list(ends))
    pairs = number[sorted(scipy.spatial.cKDTree(graph.points[number]).query_pairs(longest))].reshape(-1, 2)
    around = graph.path_lengths_between(*pairs.T)
    for (a, b), apart in zip(pairs.tolist(), around.tolist(), strict=True):
        gap = graph.distance_between(a, b)
        if apart <= _MIN_PATH_AROUND * gap:
            continue
        across = (graph.points[b] - graph.points[a]) / max(gap, 1e-300)
        if min(ends[a] @ across, -(ends[b] @ across)) < _END_TURN_COSINE:
            continue
        strength = min(site.strength_at_end(a), site.strength_at_end(b))
        way = find_bridge_path(
            site.scale_field.edge_map, strength, graph.points[[a, b]], np.stack([ends[a], ends[b]]), site.blocked
        )
        if way is not None:
            yield _BridgeCandidate(way[0], a, b, way[1])


def _bridges_to_sides(
    graph: Graph, site: _BridgeSite, ends: dict[int, Array], longest: float
) -> Iterator[_BridgeCandidate]:
    """Yield bridges from an end to the side of a contour ahead."""
    sides = np.flatnonzero(graph.degrees > 1)
    if not len(sides):
        return
    tree = scipy.spatial.cKDTree(graph.points[sides])
    for end, direction in ends.items():
        place = graph.points[end]
        near = sides[tree.query_ball_point(place, longest)]
        away = graph.points[near] - place
        distance = np.linalg.norm(away, axis=1)
        ahead = away @ direction >= _SIDE_TURN_COSINE * distance
        apart = graph.path_lengths_between(np.full(len(near), end), near) > _MIN_PATH_AROUND * distance
        near = near[ahead & apart]
        if not len(near):
            continue
        around = np.concatenate([place[None], graph.points[near]])
        costs, places = _step_costs(site.scale_field.edge_map, site.strength_at_end(end), around, 3.0)
        away = places - place
        forward = away @ direction
        off = np.linalg.norm(away - forward[..., None] * direction, axis=-1)
        costs += _LEAVING_COST * off + BLOCKED_COST * (forward < -1.0)
        total, path = _find_cheapest_path(costs, places[0, 0], place, graph.points[near])
        goal = np.argmin(np.linalg.norm(graph.points[near] - path[-1], axis=1))
        way = _stop_at_contour(graph, site, end, smooth_pixel_path(path, place, graph.points[near[goal]]))
        gap = (
            np.inf if way is None else graph.distance_between(end, way.other)
        )  # it may have stopped at a farther vertex
        if way is not None and gap <= longest and path_length(way.path) <= _MAX_BRIDGE_DETOUR * gap:
            yield _BridgeCandidate(_SIDE_COST_FACTOR * total, end, way.other, way.path)


def _stop_at_contour(graph: Graph, site: _BridgeSite, end: int, path: Array) -> _BridgeCandidate | None:
    """Stop a bridge where its path first meets a contour; None if it meets it at a narrow angle."""
    (before,) = graph.neighbors(end)
    meeting = site.find_crossing(path, (end, before))
    if meeting is None:
        return None
    segment, edge = meeting
    other = min(edge, key=lambda v: float(np.linalg.norm(graph.points[v] - path[segment])))
    path = np.concatenate([path[: segment + 1], graph.points[other][None]])
    if graph.degree(other) == 1 or len(path) < 3:
        return None
    across, side = path[-1] - path[0], graph.points[edge[0]] - graph.points[edge[1]]
    cosine = abs(float(across @ side)) / max(float(np.linalg.norm(across) * np.linalg.norm(side)), 1e-300)
    return _BridgeCandidate(0.0, end, other, path) if cosine <= _INCIDENCE_COSINE else None


def find_bridge_path(
    edges: Array, strength: float, ends: Array, directions: Array, blocked: Mask | None = None
) -> tuple[float, Array] | None:
    """Find the cheapest path between two ends over an edge map; None if it is a detour.

    Parameters
    ----------
    edges : ndarray, shape (H, W)
        Edge map [gray levels / px].
    strength : float
        Strength of a clear edge in it.
    ends, directions : ndarray, shape (2, 2)
        Places that are joined [px], and unit vectors in which curves leave there.
    blocked : ndarray of bool, shape (H, W), optional
        Pixels that the path should avoid, except around its ends.

    Returns
    -------
    cost : float
        Sum of the costs of its steps.
    path : ndarray, shape (K, 2)
        Its points [px].
    """
    (a, b), gap = ends, float(np.linalg.norm(ends[1] - ends[0]))
    guide = continuation_curve(a, directions[0], b, directions[1])
    costs, places = _step_costs(edges, strength, guide, 0.5 * gap + 3.0)
    costs += _LEAVING_COST * scipy.spatial.cKDTree(guide).query(places)[0]
    if blocked is not None:
        around = np.linalg.norm(places[..., None, :] - ends, axis=-1).min(axis=-1) <= UNBLOCKED_RADIUS
        costs += BLOCKED_COST * (blocked[tuple(np.moveaxis(places, -1, 0))] & ~around)
    total, path = _find_cheapest_path(costs, places[0, 0], a, b[None])
    path = smooth_pixel_path(path, a, b)
    return (total, path) if path_length(path) <= _MAX_BRIDGE_DETOUR * gap else None


def _step_costs(edges: Array, strength: float, points: Array, margin: float) -> tuple[Array, Index]:
    """Compute the cost of a step on every pixel around points, and these pixels, shape (H, W, 2)."""
    last = np.array(edges.shape) - 1
    low = np.clip(np.floor(points.min(axis=0) - margin), 0, last).astype(np.int64)
    high = np.clip(np.ceil(points.max(axis=0) + margin), 0, last).astype(np.int64)
    window = edges[low[0] : high[0] + 1, low[1] : high[1] + 1]
    return 1.0 / (1.0 + EXTRA_COST_OFF_EDGE * window / strength), np.moveaxis(np.indices(window.shape), 0, -1) + low


def _find_cheapest_path(costs: Array, low: Index, start: Array, goals: Array) -> tuple[float, Array]:
    """Find the cheapest path from a position to one of several others and its cost; `low` is the first pixel."""
    pixels = nearest_pixels(np.concatenate([start[None], goals]) - low, costs.shape)
    first, *last = map(tuple, pixels.tolist())
    search = skimage.graph.MCP_Geometric(costs)
    total, _ = search.find_costs([first])
    goal = min(last, key=lambda pixel: float(total[pixel]))
    return float(total[goal]), np.array(search.traceback(goal), dtype=float) + low


def smooth_pixel_path(path: Array, start: Array, end: Array) -> Array:
    """Smooth a pixel path, shape (K, 2), into a curve between two positions, shape (2,)."""
    inner = path[(np.linalg.norm(path - start, axis=1) > 1.0) & (np.linalg.norm(path - end, axis=1) > 1.0)]
    smooth = np.concatenate([start[None], inner, end[None]])
    for _ in range(_SMOOTHING_PASSES):
        smooth[1:-1] = 0.25 * (smooth[:-2] + 2.0 * smooth[1:-1] + smooth[2:])
    return smooth


def continuation_curve(a: Array, from_a: Array, b: Array, from_b: Array) -> Array:
    """Draw the cubic Bezier curve from a to b in the directions of the two ends, shapes (2,); shape (K, 2)."""
    handle = np.linalg.norm(b - a) / 3.0
    t = np.linspace(0.0, 1.0, 4 + int(2.0 * np.linalg.norm(b - a)))[:, None]
    s = 1.0 - t
    return s**3 * a + 3.0 * s**2 * t * (a + handle * from_a) + 3.0 * s * t**2 * (b + handle * from_b) + t**3 * b


def _find_loose_ends(graph: Graph, scale_field: ScaleField, least: float) -> dict[int, Array]:
    """Find the loose ends, and their directions, of curves that are long enough and do not end at a barrier."""
    ways = graph.find_paths()
    part = graph.label_components()
    long = np.bincount(part, ways.lengths)[part] >= least
    ends = np.intersect1d(graph.loose_ends(), np.concatenate([ways.first[long], ways.last[long]]))
    direction = np.array([direction_at_end(graph.points[graph.branch_from(end)]) for end in ends.tolist()]).reshape(
        -1, 2
    )
    place = graph.points[ends]
    blocked = scale_field.barrier_map.is_crossed_by(place, place + _BARRIER_LOOKAHEAD * least * direction)
    return dict(zip(ends[~blocked].tolist(), direction[~blocked], strict=True))


def stretch_from_start(points: Array, back: float) -> Array:
    """Return the vertices of a curve, shape (K, 2), from the first up to a length along it, at least two [px]."""
    return points[: max(int(np.searchsorted(lengths_along(points), back, side="right")), 2)]


def direction_at_end(points: Array) -> Array:
    """Return the unit vector, shape (2,), in which a curve, shape (K, 2), leaves its first vertex."""
    stretch = stretch_from_start(points, _DIRECTION_LENGTH)
    way = stretch[0] - stretch[-1]
    return way / max(float(np.linalg.norm(way)), 1e-300)
