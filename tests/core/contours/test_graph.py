"""Graphs of points and edges, simplified by paths, against sets of edges simplified one by one."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.graph import Graph


class Linked:
    """A graph as a set of neighbors for each vertex: brute force."""

    def __init__(self, points, edges):
        self.points = np.array(points)
        self.near = {v: set() for v in range(len(points))}
        for a, b in edges:
            self.near[a].add(b)
            self.near[b].add(a)

    def edges(self):
        return {(a, b) for a, near in self.near.items() for b in near if a < b}

    def drop(self, path):
        for a, b in itertools.pairwise(path):
            self.near[a].discard(b)
            self.near[b].discard(a)

    def length(self, path):
        return sum(np.linalg.norm(self.points[a] - self.points[b]) for a, b in itertools.pairwise(path))

    def path(self, start, towards):
        """Vertices up to the next end or junction, or back to the first."""
        path = [start, towards]
        while path[-1] != start and len(self.near[path[-1]]) == 2:
            (ahead,) = self.near[path[-1]] - {path[-2]}
            path.append(ahead)
        return path

    def ways(self):
        """Paths, the first vertex again at the end of cycles: those from ends and junctions, then the others."""
        found, seen = [], set()
        for rounds in (False, True):
            for v in sorted(self.near):
                for w in sorted(self.near[v]):
                    if (len(self.near[v]) == 2) == rounds and frozenset((v, w)) not in seen:
                        found.append(self.path(v, w))
                        seen |= {frozenset(side) for side in itertools.pairwise(found[-1])}
        return found

    def ends(self):
        return [v for v in sorted(self.near) if len(self.near[v]) == 1]

    def branch(self, end):
        return self.path(end, *self.near[end])

    def drop_spurs(self, longest):
        for end in sorted(self.ends(), key=lambda end: self.length(self.branch(end))):
            if len(self.near[end]) == 1:
                path = self.branch(end)
                if len(self.near[path[-1]]) > 2 and self.length(path) <= longest:
                    self.drop(path)

    def drop_specks(self, longest):
        for path in self.ways():
            if all(len(self.near[v]) == 1 for v in (path[0], path[-1])) and self.length(path) <= longest:
                self.drop(path)

    def ties(self):
        return [p for p in self.ways() if p[0] != p[-1] and min(len(self.near[p[0]]), len(self.near[p[-1]])) > 2]

    def drop_junction_links(self, longest):
        for path in sorted(self.ties(), key=self.length):
            if min(len(self.near[path[0]]), len(self.near[path[-1]])) > 2 and self.length(path) < longest:
                self.drop(path)

    def merge_junctions(self, longest):
        for path in self.ties():
            kept, gone = path[0], path[-1]
            there = all(b in self.near[a] for a, b in itertools.pairwise(path))
            if there and min(len(self.near[kept]), len(self.near[gone])) > 2 and self.length(path) <= longest:
                self.drop(path)
                self.points[kept] = 0.5 * (self.points[kept] + self.points[gone])
                for other in self.near[gone]:
                    self.near[other].discard(gone)
                    if other != kept:
                        self.near[other].add(kept)
                        self.near[kept].add(other)
                self.near[gone] = set()


@st.composite
def drawings(draw):
    """Points and edges: junctions with paths between them, loose ends and cycles."""
    count = draw(st.integers(2, 9))
    pairs = st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)).filter(lambda p: p[0] != p[1])
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    points, edges = list(rng.uniform(0.0, 12.0, (count, 2))), []
    for a, b in draw(st.lists(pairs, max_size=14)):
        between = range(len(points), len(points) + draw(st.integers(0, 3)))
        points += [rng.uniform(0.0, 12.0, 2) for _ in between]  # no two ways of the same length
        edges += itertools.pairwise([a, *between, b])
    names = rng.permutation(len(points))  # in which order vertices are numbered shall not matter
    placed = np.empty((len(points), 2))
    placed[names] = points
    return placed, names[np.array(edges, np.int64).reshape(-1, 2)]


def both(made):
    points, edges = made
    return Graph(points, edges), Linked(points, edges.tolist())


def edges_of(graph):
    edges = [tuple(edge) for edge in graph.edges().tolist()]
    assert edges == sorted(set(edges))
    assert graph.degrees.tolist() == [sum(v in edge for edge in edges) for v in range(len(graph.points))]
    return set(edges)


@settings(max_examples=40, deadline=None)
@given(drawings())
def test_paths_are_in_the_order_of_their_first_vertices(made):
    graph, linked = both(made)
    ways = graph.find_paths()
    walked = [(path[:-1] if path[0] == path[-1] else path, path[0] == path[-1]) for path in linked.ways()]
    assert [(ways.path_vertices(n).tolist(), bool(ways.closed[n])) for n in range(len(ways))] == walked
    np.testing.assert_allclose(ways.lengths, [linked.length(path) for path in linked.ways()], rtol=1e-12)
    assert ways.first.tolist() == [path[0] for path, _ in walked]
    assert ways.last.tolist() == [path[-1] for path, _ in walked]
    sides, way = ways.path_edges()
    assert sides.tolist() == [list(side) for path in linked.ways() for side in itertools.pairwise(path)]
    assert way.tolist() == [n for n, path in enumerate(linked.ways()) for _ in path[1:]]


@settings(max_examples=40, deadline=None)
@given(drawings())
def test_branches_and_neighbors_are_those_of_the_edges(made):
    graph, linked = both(made)
    assert edges_of(graph) == linked.edges()
    assert [graph.neighbors(v) for v in range(len(graph.points))] == [sorted(linked.near[v]) for v in linked.near]
    assert graph.loose_ends().tolist() == linked.ends()
    for end in linked.ends():
        path = linked.branch(end)
        assert graph.branch_from(end).tolist() == path
        lengths = [linked.length(path[: n + 1]) for n in range(len(path))]
        np.testing.assert_allclose(
            graph.path_lengths_between(np.full(len(path), end), np.array(path)), lengths, atol=1e-9
        )


@pytest.mark.parametrize("operation", ["drop_spurs", "drop_specks", "drop_junction_links", "merge_junctions"])
@settings(max_examples=40, deadline=None)
@given(made=drawings(), longest=st.floats(0.0, 25.0))
def test_simplifying_by_paths_equals_simplifying_by_edges(operation, made, longest):
    graph, linked = both(made)
    graph.find_paths()  # what is known of the ways must be forgotten when they change
    getattr(graph, operation)(longest)
    getattr(linked, operation)(longest)
    assert edges_of(graph) == linked.edges()
    np.testing.assert_allclose(graph.points, linked.points, atol=1e-12)
    assert sum(graph.find_paths().lengths) == pytest.approx(sum(linked.length(edge) for edge in linked.edges()))


@settings(max_examples=40, deadline=None)
@given(drawings(), st.lists(st.tuples(st.booleans(), st.integers(0, 99), st.integers(0, 99)), max_size=30))
def test_edges_are_added_and_removed_as_in_a_set(made, changes):
    graph, linked = both(made)
    kept = linked.edges()
    for come, a, b in changes:
        edge = tuple(sorted((a % len(graph.points), b % len(graph.points))))
        if edge[0] == edge[1]:
            continue
        if come:
            graph.add_edge(*edge)
            kept.add(edge)
        else:
            graph.remove_edges(edge)
            kept.discard(edge)
    assert edges_of(graph) == kept


@settings(max_examples=40, deadline=None)
@given(drawings(), st.integers(0, 4), st.integers(0, 99), st.integers(1, 98))
def test_new_vertices_are_inserted_in_a_row(made, count, a, further):
    graph, linked = both(made)
    size = len(graph.points)
    a, b = a % size, (a % size + 1 + further % (size - 1)) % size
    between = np.arange(2.0 * count).reshape(-1, 2)
    graph.add_path(a, between, b)
    row = [a, *range(size, size + count), b]
    assert edges_of(graph) == linked.edges() | {(min(side), max(side)) for side in itertools.pairwise(row)}
    np.testing.assert_array_equal(graph.points[size:], between)


def test_an_empty_graph_has_no_paths():
    for points in (np.zeros((0, 2)), np.zeros((3, 2))):
        graph = Graph(points, np.zeros((0, 2), np.int64))
        for operation in (graph.drop_spurs, graph.drop_specks, graph.drop_junction_links, graph.merge_junctions):
            operation(5.0)
        assert not len(graph.find_passes(5.0))
        assert len(graph.find_paths()) == 0
        assert len(graph.edges()) == 0
        assert graph.extract_contours() == ()


@settings(max_examples=40, deadline=None)
@given(drawings(), st.floats(0.0, 25.0))
def test_contours_of_a_least_length_are_those_of_all_that_reach_it(made, shortest):
    graph, _ = both(made)
    found, every = graph.extract_contours(shortest), graph.extract_contours()
    assert [c.points.tolist() for c in found] == [c.points.tolist() for c in every if c.length >= shortest]


@pytest.mark.parametrize(("gap", "passes"), [(1.9, 1), (2.1, 0)])
def test_curves_that_come_within_the_distance_pass_each_other_but_no_tip_passes_itself(gap, passes):
    """Both branches of a hyperbola, and two sides of a tip, which are one curve."""
    along = np.linspace(-3.0, 3.0, 61)
    branch = np.stack([0.5 * gap * np.cosh(along), 0.5 * gap * np.sinh(along)], axis=1)
    tip = np.stack([0.9 * np.sin(np.linspace(-1.5, 1.5, 21)), 30.0 + np.cos(np.linspace(-1.5, 1.5, 21))], axis=1)
    edges = [pair for a, b in ((0, 61), (61, 122), (122, 143)) for pair in itertools.pairwise(range(a, b))]
    found = Graph(np.concatenate([branch, -branch, tip]), np.array(edges)).find_passes(2.0)
    assert len(found) == passes
    np.testing.assert_allclose(np.linalg.norm(found[:, 0] - found[:, 1], axis=1), gap)


CIRCLE = [(n, (n + 1) % 12) for n in range(12)]


def lengths(edges):
    """Lengths of the closed contours and of the open ones of a circle of 12 vertices, others outside and one within."""
    angle = np.pi / 6.0 * np.arange(24)
    radius = np.repeat([10.0, 13.0], 12)
    points = np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=1)
    found = Graph(np.concatenate([points, [(0.0, 0.0)]]), np.array(edges)).extract_contours()
    return [[one.length for one in found if one.closed is closed] for closed in (True, False)]


AROUND = 12 * 2.0 * 10.0 * np.sin(np.pi / 12.0)


@pytest.mark.parametrize("branches", [[], [3], [3, 9], [0, 1, 2], [0, 4, 5, 11]])
def test_a_cycle_that_only_dead_ends_leave_is_closed_and_they_are_not(branches):
    closed, opened = lengths([*CIRCLE, *((n, n + 12) for n in branches)])
    assert closed == pytest.approx([AROUND])
    assert opened == pytest.approx([3.0] * len(branches))


def test_a_branch_that_forks_is_a_dead_end_and_one_that_comes_back_or_leads_to_another_cycle_is_not():
    fork, back, chord = [(3, 15), (15, 16), (15, 14)], [(3, 15), (15, 16), (16, 4)], [(0, 24), (24, 6)]
    assert [len(found) for found in lengths([*CIRCLE, (8, 20), *fork])] == [1, 4]
    assert [len(found) for found in lengths([*CIRCLE, (8, 20), *back])] == [0, 5]
    assert [len(found) for found in lengths([*CIRCLE, *chord])] == [0, 3]
    assert [len(found) for found in lengths([*CIRCLE, (8, 20), (3, 15), (15, 16), (16, 17), (17, 15)])] == [2, 2]
