"""Bridging gaps: joining loose ends where the edge is interrupted or faint.

A bridge is a path of least cost over the edge map: the stronger the edge, the lower the cost of a step. It therefore
follows a faint edge. Without any edge, a small cost for the distance from the smooth continuation of both ends keeps
the bridge on that curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.contours.contour import Bridge
from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.polyline import length, resampled
from cpm_core.numerics.segments import first_crossing
from cpm_core.numerics.types import Array

_EASE = 20.0
"""Ratio, less one, of the costs of a step without an edge and on an edge as strong as at the ends."""

_LEAVING, _BLOCKED = 0.04, 30.0
"""Additional cost of a step for each pixel of distance from the smooth continuation, and on contours and barriers."""

_BACK, _BACK_STRENGTH = 6.0, 12.0
"""Lengths of the last stretch of a contour that give its direction and its strength [px]."""

_TURN, _SIDE_TURN, _INCIDENCE = 0.26, 0.87, 0.82
"""Cosines: the least between the direction of an end and that to another end (75 degrees) or to the side of a contour
(30), and the largest between a bridge and the side that it meets (35), so that parallel lines are not joined."""

_DETOUR, _ROUND = 1.6, 3.0
"""In lengths of the gap: the greatest length of a bridge, and the least length of the path along a contour between two
of its vertices that may be joined."""

_SIDE = 1.5
"""How many times cheaper than an end the side of a contour must be to have priority."""

_AHEAD = 0.5
"""Distance ahead, as a fraction of the shortest curve, within which a barrier counts as the reason for an end."""

_SMOOTHINGS = 6
"""Number of smoothing passes over a pixel path."""


@dataclass(frozen=True, eq=False)
class _Way:
    """A possible bridge: its cost, its two vertices, and its points including theirs, shape (K, 2)."""

    cost: float
    end: int
    other: int
    path: Array


def bridge_gaps(
    graph: Graph, scale_field: ScaleField, longest: float, spacing: float, least: float
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
    longest : float
        Widest gap [px]; 0 for none.
    spacing : float
        Largest distance between the vertices of a bridge [px].
    least : float
        Length of the shortest curve that is joined [px].
    """
    ends = _ends(graph, scale_field, least) if longest > 0.0 else {}
    if not ends:
        return ()
    grid = _CostGrid(graph, scale_field)
    ways = [*_between_ends(graph, grid, ends, longest), *_to_sides(graph, grid, ends, longest)]
    built = []
    for way in sorted(ways, key=lambda way: (way.cost, way.end, way.other)):
        joins_end = way.other in ends
        if graph.degree(way.end) != 1 or (joins_end and graph.degree(way.other) != 1):
            continue
        path = resampled(way.path, spacing)
        if grid.free(path, (way.end, way.other)):
            grid.build(way.end, path[1:-1], way.other)
            built.append(Bridge(path, length(path), float(scale_field.strength(path).mean())))
    return tuple(built)


class _CostGrid:
    """Costs of the pixels for the path search: low along edges, high on contours and barriers."""

    def __init__(self, graph: Graph, scale_field: ScaleField) -> None:
        self.graph = graph
        self.scale_field = scale_field
        self._edges = graph.edges()
        a, b = graph.points[self._edges].swapaxes(0, 1)
        self._blocked = np.zeros(scale_field.shape, np.bool_)
        for t in np.linspace(0.0, 1.0, 5):
            places = np.rint(a + t * (b - a)).astype(np.int64)
            self._blocked[tuple(np.clip(places, 0, np.array(scale_field.shape) - 1).T)] = True
        if len(scale_field.barrier_map.segments):
            self._blocked |= scale_field.barrier_map.clearance <= 0.0

    def costs(self, low: Array, high: Array, strength: float) -> tuple[Array, Array]:
        """Cost of a step on every pixel from `low` to `high` without obstacles, and the positions of these pixels."""
        window = tuple(slice(int(a), int(b) + 1) for a, b in zip(low, high, strict=True))
        costs = 1.0 / (1.0 + _EASE * self.scale_field.edge_map[window] / max(strength, self.scale_field.floor))
        places = np.moveaxis(np.indices(costs.shape), 0, -1) + low
        return costs, places

    def obstacles(self, places: Array, spared: Array) -> Array:
        """Cost of obstacles on pixels, except around the positions that are to be joined."""
        blocked = self._blocked[tuple(np.moveaxis(places.astype(np.int64), -1, 0))]
        for place in spared:
            blocked = blocked & (np.linalg.norm(places - place, axis=-1) > 2.0)
        return np.asarray(_BLOCKED * blocked)

    def window(self, points: Array, margin: float) -> tuple[Array, Array]:
        """First and last pixel of the image around points."""
        last = np.array(self.scale_field.shape) - 1.0
        return (
            np.clip(np.floor(points.min(axis=0) - margin), 0.0, last),
            np.clip(np.ceil(points.max(axis=0) + margin), 0.0, last),
        )

    def crossing(self, path: Array, spared: tuple[int, ...]) -> tuple[int, tuple[int, int]] | None:
        """First segment of a path that crosses an edge of the graph, and that edge; edges at `spared` are ignored."""
        edges = self._edges[~np.isin(self._edges, spared).any(axis=1)]
        at, crossed = first_crossing(path, self.graph.points[edges].reshape(-1, 4))
        if crossed < 0:
            return None
        one, other = edges[crossed].tolist()
        return at, (one, other)

    def build(self, end: int, between: Array, other: int) -> None:
        """Add a bridge to the graph."""
        first = len(self.graph.points)
        self.graph.insert(end, between, other)
        way = np.array([end, *range(first, first + len(between)), other], dtype=np.int64)
        self._edges = np.concatenate([self._edges, np.stack([way[:-1], way[1:]], axis=1)])

    def free(self, path: Array, spared: tuple[int, ...]) -> bool:
        """Whether a path crosses neither a contour nor a barrier."""
        return (
            not self.scale_field.barrier_map.crossed(path[:-1], path[1:]).any() and self.crossing(path, spared) is None
        )


def _between_ends(graph: Graph, grid: _CostGrid, ends: dict[int, Array], longest: float) -> Iterator[_Way]:
    """Bridges from end to end."""
    number = list(ends)
    for i, j in sorted(scipy.spatial.cKDTree(graph.points[number]).query_pairs(longest)):
        a, b = number[i], number[j]
        gap = graph.distance(a, b)
        across = (graph.points[b] - graph.points[a]) / max(gap, 1e-300)
        if min(ends[a] @ across, -(ends[b] @ across)) < _TURN:
            continue
        if graph.way_from(a).get(b, np.inf) <= _ROUND * gap:
            continue
        guide = continuation(graph.points[a], ends[a], graph.points[b], ends[b])
        joined = graph.points[[a, b]]
        low, high = grid.window(guide, 0.5 * gap + 3.0)
        costs, places = grid.costs(low, high, min(_strength(graph, grid.scale_field, v) for v in (a, b)))
        off = scipy.spatial.cKDTree(guide).query(places)[0]
        search = skimage.graph.MCP_Geometric(costs + _LEAVING * off + grid.obstacles(places, joined))
        total, path = _cheapest(search, low, joined[0], joined[1:])
        path = smoothed(path, joined[0], joined[1])
        if length(path) <= _DETOUR * gap:
            yield _Way(total, a, b, path)


def _to_sides(graph: Graph, grid: _CostGrid, ends: dict[int, Array], longest: float) -> Iterator[_Way]:
    """Bridges from an end to the side of a contour ahead."""
    sides = np.flatnonzero(graph.degrees > 1)
    if not len(sides):
        return
    tree = scipy.spatial.cKDTree(graph.points[sides])
    for end, direction in ends.items():
        place = graph.points[end]
        own = graph.way_from(end)
        near = sides[tree.query_ball_point(place, longest)]
        away = graph.points[near] - place
        distance = np.linalg.norm(away, axis=1)
        ahead = away @ direction >= _SIDE_TURN * distance
        apart = np.array([own.get(v, np.inf) for v in near.tolist()]) > _ROUND * distance
        near = near[ahead & apart]
        if not len(near):
            continue
        low, high = grid.window(np.concatenate([place[None], graph.points[near]]), 3.0)
        costs, places = grid.costs(low, high, _strength(graph, grid.scale_field, end))
        away = places - place
        forward = away @ direction
        off = np.linalg.norm(away - forward[..., None] * direction, axis=-1)
        search = skimage.graph.MCP_Geometric(costs + _LEAVING * off + _BLOCKED * (forward < -1.0))
        total, path = _cheapest(search, low, place, graph.points[near])
        way = _stopped(graph, grid, end, smoothed(path, place, graph.points[near[_nearest(graph, near, path[-1])]]))
        gap = np.inf if way is None else graph.distance(end, way.other)  # it may have stopped at a vertex farther away
        if way is not None and gap <= longest and length(way.path) <= _DETOUR * gap:
            yield _Way(_SIDE * total, end, way.other, way.path)


def _stopped(graph: Graph, grid: _CostGrid, end: int, path: Array) -> _Way | None:
    """A bridge that ends where its path first meets a contour; None if it meets it at a narrow angle."""
    (before,) = graph.neighbors(end)
    meeting = grid.crossing(path, (end, before))
    if meeting is None:
        return None
    segment, edge = meeting
    other = min(edge, key=lambda v: float(np.linalg.norm(graph.points[v] - path[segment])))
    path = np.concatenate([path[: segment + 1], graph.points[other][None]])
    if graph.degree(other) == 1 or len(path) < 3:
        return None
    across, side = path[-1] - path[0], graph.points[edge[0]] - graph.points[edge[1]]
    cosine = abs(float(across @ side)) / max(float(np.linalg.norm(across) * np.linalg.norm(side)), 1e-300)
    return _Way(0.0, end, other, path) if cosine <= _INCIDENCE else None


def _nearest(graph: Graph, vertices: NDArray[np.int64], place: Array) -> int:
    return int(np.argmin(np.linalg.norm(graph.points[vertices] - place, axis=1)))


def _cheapest(search: skimage.graph.MCP_Geometric, low: Array, start: Array, goals: Array) -> tuple[float, Array]:
    """Cost and pixels of the cheapest path from a position to one of several others."""
    first = tuple(np.rint(start - low).astype(int))
    last = [tuple(goal) for goal in np.rint(goals - low).astype(int)]
    total, _ = search.find_costs([first])
    goal = min(last, key=lambda pixel: float(total[pixel]))
    return float(total[goal]), np.array(search.traceback(goal), dtype=float) + low


def smoothed(path: Array, start: Array, end: Array) -> Array:
    """A pixel path as a smooth curve between two positions."""
    inner = path[(np.linalg.norm(path - start, axis=1) > 1.0) & (np.linalg.norm(path - end, axis=1) > 1.0)]
    smooth = np.concatenate([start[None], inner, end[None]])
    for _ in range(_SMOOTHINGS):
        smooth[1:-1] = 0.25 * (smooth[:-2] + 2.0 * smooth[1:-1] + smooth[2:])
    return smooth


def continuation(a: Array, from_a: Array, b: Array, from_b: Array) -> Array:
    """Cubic curve from a to b in the directions of the two ends."""
    handle = np.linalg.norm(b - a) / 3.0
    t = np.linspace(0.0, 1.0, 4 + int(2.0 * np.linalg.norm(b - a)))[:, None]
    s = 1.0 - t
    return np.asarray(
        s**3 * a + 3.0 * s**2 * t * (a + handle * from_a) + 3.0 * s * t**2 * (b + handle * from_b) + t**3 * b
    )


def _ends(graph: Graph, scale_field: ScaleField, least: float) -> dict[int, Array]:
    """Loose ends, and their directions, of curves that are long enough and do not end at a barrier."""
    ends = [end for end in graph.ends().tolist() if _reaches(graph, end, least)]
    direction = np.array([_direction(graph, end) for end in ends]).reshape(-1, 2)
    place = graph.points[ends]
    blocked = scale_field.barrier_map.crossed(place, place + _AHEAD * least * direction)
    return {end: way for end, way, at_barrier in zip(ends, direction, blocked, strict=True) if not at_barrier}


def _reaches(graph: Graph, end: int, least: float) -> bool:
    """Whether a vertex is connected to edges of at least this total length."""
    seen, waiting, length = {end}, [end], 0.0
    while waiting and length < least:
        vertex = waiting.pop()
        for other in graph.neighbors(vertex):
            if other not in seen:
                seen.add(other)
                waiting.append(other)
                length += graph.distance(vertex, other)
    return length >= least


def _last_stretch(graph: Graph, end: int, back: float) -> list[int]:
    way = graph.way_from(end)
    inner = [v for v, length in way.items() if length <= back]
    return inner if len(inner) > 1 else list(way)[:2]


def _direction(graph: Graph, end: int) -> Array:
    """Unit vector in which a curve leaves its loose end."""
    stretch = _last_stretch(graph, end, _BACK)
    way = graph.points[end] - graph.points[stretch[-1]]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-300))


def _strength(graph: Graph, scale_field: ScaleField, end: int) -> float:
    """Edge strength near a loose end."""
    return float(scale_field.strength(graph.points[_last_stretch(graph, end, _BACK_STRENGTH)]).max())
