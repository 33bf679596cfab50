"""From points to contours: the crust against its definition, graphs against brute force, the ridge of known edges."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special
from scipy.spatial import Delaunay, Voronoi

from cpm_core import reconstruct_curve
from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import build_scale_field
from cpm_core.published.crust import find_crust_edges
from cpm_core.reconstruction.curve.end_linking import link_loose_ends
from cpm_core.reconstruction.curve.subpixel import refine_to_ridge

from ..scenes import circle_points, disk


def crust_in_two_steps(points):
    """The crust as it was published: those Delaunay edges of points and Voronoi vertices that join two points."""
    together = np.concatenate([points, Voronoi(points).vertices])
    sides = itertools.chain.from_iterable(itertools.combinations(map(int, t), 2) for t in Delaunay(together).simplices)
    return {(min(side), max(side)) for side in sides if max(side) < len(points)}


def crust_in_one_step(points):
    edges = [tuple(edge) for edge in find_crust_edges(points).tolist()]
    assert edges == sorted(set(edges))
    assert all(a < b for a, b in edges)
    return set(edges)


def polygon_of(count):
    return {(min(i, (i + 1) % count), max(i, (i + 1) % count)) for i in range(count)}


@st.composite
def blobs(draw):
    """Smooth closed curves, sampled in order with a jitter along the curve."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    count = draw(st.integers(120, 200))
    angle = 2.0 * np.pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count
    radius = np.full(count, 30.0)
    for order in range(2, 6):
        radius += rng.uniform(-1.0, 1.0) * 8.0 / order * np.cos(order * angle + rng.uniform(0.0, 2.0 * np.pi))
    return np.stack([50.0 + radius * np.sin(angle), 40.0 + radius * np.cos(angle)], axis=1)


@settings(max_examples=40, deadline=None)
@given(blobs())
def test_crust_of_a_well_sampled_curve_is_the_curve_like_that_in_two_steps(points):
    assert crust_in_one_step(points) == polygon_of(len(points))
    assert crust_in_two_steps(points) == polygon_of(len(points))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(5, 60))
def test_crust_of_any_points_holds_that_in_two_steps(seed, count):
    points = np.random.default_rng(seed).uniform(0.0, 50.0, (count, 2))
    assert crust_in_two_steps(points) <= crust_in_one_step(points)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(4, 40))
def test_crust_joins_points_by_circles_free_of_their_voronoi_vertices(seed, count):
    """Brute force over the Delaunay triangles at each edge: the opposite angles sum to at most a right angle."""
    points = np.random.default_rng(seed).uniform(0.0, 50.0, (count, 2))
    opposite = {}
    for triangle in Delaunay(points).simplices.tolist():
        for apex in triangle:
            a, b = sorted(set(triangle) - {apex})
            u, v = points[a] - points[apex], points[b] - points[apex]
            opposite.setdefault((a, b), []).append(np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v)))
    truth = {edge for edge, angles in opposite.items() if sum(angles) <= 0.5 * np.pi}
    assert crust_in_one_step(points) == truth


@settings(max_examples=30, deadline=None)
@given(blobs(), st.floats(0.0, 6.3), st.floats(0.01, 50.0), st.integers(0, 10**6))
def test_crust_does_not_depend_on_rotation_shift_scale_and_order_of_the_points(points, angle, scale, seed):
    rng = np.random.default_rng(seed)
    points = points + rng.normal(0.0, 0.3, points.shape)  # off the curve: other edges than the polygon's
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    edges = crust_in_one_step(points)
    assert crust_in_one_step(scale * points @ turn.T + rng.uniform(-100.0, 100.0, 2)) == edges
    order = rng.permutation(len(points))
    place = np.argsort(order)
    assert crust_in_one_step(points[order]) == {tuple(sorted((int(place[a]), int(place[b])))) for a, b in edges}


@pytest.mark.parametrize("count", [12, 61, 200])
def test_a_circle_is_one_closed_contour_of_its_length_and_area(count):
    points = circle_points((30.3, 41.7), 20.0, count)
    (contour,) = reconstruct_curve(np.random.default_rng(0).permutation(points))
    assert contour.closed
    assert contour.junctions == (False, False)
    assert len(contour.points) == count
    assert contour.length == pytest.approx(2.0 * count * 20.0 * np.sin(np.pi / count), rel=1e-12)
    assert contour.area == pytest.approx(0.5 * count * 400.0 * np.sin(2.0 * np.pi / count), rel=1e-10)


def test_a_t_is_three_open_contours_that_meet_in_one_junction():
    along, down = np.arange(-20.0, 21.0), np.arange(1.0, 21.0)
    points = np.concatenate([np.stack([0 * along, along], axis=1), np.stack([down, 0 * down], axis=1)])
    contours = reconstruct_curve(points)
    assert [c.closed for c in contours] == [False] * 3
    assert [len(c.points) for c in contours] == [21, 21, 21]
    shared = [c.points[[0, -1]][list(c.junctions)].tolist() for c in contours]
    assert shared == [[[0.0, 0.0]]] * 3
    ends = sorted(tuple(c.points[[0, -1]][[not j for j in c.junctions]][0]) for c in contours)
    assert ends == [(0.0, -20.0), (0.0, 20.0), (20.0, 0.0)]


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)], ids=str)
def test_points_on_one_line_make_one_open_contour(direction):
    points = np.arange(12.0)[:, None] * np.array(direction) + 5.0
    (contour,) = reconstruct_curve(np.random.default_rng(3).permutation(points))
    assert not contour.closed
    assert contour.length == pytest.approx(11.0 * np.hypot(*direction))


@st.composite
def graphs(draw):
    count = draw(st.integers(2, 14))
    pairs = st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)).filter(lambda p: p[0] != p[1])
    edges = draw(st.lists(pairs, max_size=30))
    points = np.random.default_rng(draw(st.integers(0, 1000))).uniform(0.0, 20.0, (count, 2))
    return Graph(points, np.array(edges, dtype=np.int64).reshape(-1, 2))


def edges_of(graph):
    return {(a, b) for a, b in graph.edges().tolist()}


@settings(max_examples=60, deadline=None)
@given(graphs())
def test_contours_use_every_edge_exactly_once_and_end_at_ends_and_junctions(graph):
    walked = []
    ways = graph.find_paths()
    for path, closed in ((ways.path_vertices(n).tolist(), ways.closed[n]) for n in range(len(ways))):
        steps = list(itertools.pairwise([*path, path[0]] if closed else path))
        walked += [(min(step), max(step)) for step in steps]
        if closed:
            assert len(path) >= 3
            assert all(graph.degree(v) == 2 for v in path[1:])
        else:
            assert all(graph.degree(v) == 2 for v in path[1:-1])
            assert graph.degree(path[0]) != 2
            assert graph.degree(path[-1]) != 2
    assert sorted(walked) == sorted(edges_of(graph))


def chain_with_branch(branch):
    """Twenty vertices in a row, and a branch of so many edges from the tenth."""
    row = [(0.0, float(x)) for x in range(20)]
    side = [(float(y), 10.0) for y in range(1, branch + 1)]
    edges = [(i, i + 1) for i in range(19)] + [(10 if i == 0 else 19 + i, 20 + i) for i in range(branch)]
    return Graph(np.array(row + side), np.array(edges, dtype=np.int64))


@pytest.mark.parametrize("branch", [1, 2, 3])
def test_short_spurs_are_dropped(branch):
    graph = chain_with_branch(branch)
    graph.drop_spurs(3)
    assert edges_of(graph) == {(i, i + 1) for i in range(19)}


def ladder(rung):
    """Two rows of twenty vertices, joined by a rung of so many vertices between the tenth of each."""
    rows = [(float(y), float(x)) for y in (0, rung + 1) for x in range(20)]
    between = [(float(y), 9.0) for y in range(1, rung + 1)]
    edges = [(i, i + 1) for i in range(39) if i != 19]
    way = [9, *range(40, 40 + rung), 29]
    return Graph(np.array(rows + between), np.array(edges + list(itertools.pairwise(way)), dtype=np.int64))


@pytest.mark.parametrize(("rung", "longest", "count"), [(0, 1.0, 4), (1, 2.0, 4), (1, 1.9, 5)])
def test_junctions_close_to_each_other_are_merged(rung, longest, count):
    graph = ladder(rung)
    graph.merge_junctions(longest)
    contours = graph.extract_contours()
    assert len(contours) == count
    if count == 4:
        meeting = np.concatenate([c.points[[0, -1]][list(c.junctions)] for c in contours])
        np.testing.assert_array_equal(meeting, np.full((4, 1), 1.0) * [0.5 * (rung + 1), 9.0])


@settings(max_examples=60, deadline=None)
@given(graphs(), st.integers(1, 4))
def test_dropping_spurs_only_removes_and_never_opens_a_cycle(graph, longest):
    before = edges_of(graph)
    on_round = {e for e in before if _on_round(before, e)}
    graph.drop_spurs(longest)
    assert edges_of(graph) <= before
    assert on_round <= edges_of(graph)


def _on_round(edges, edge):
    """Whether the ends of an edge are joined without it."""
    reached, goal = {edge[0]}, edge[1]
    while True:
        more = {v for e in edges - {edge} if set(e) & reached for v in e}
        if more <= reached:
            return goal in reached
        reached |= more


def smooth_step(shape, angle, offset):
    """Image of a straight edge blurred by half a pixel, and the distance of points from it."""
    center = 0.5 * (np.array(shape) - 1.0)

    def across(points):
        return (points[..., 0] - center[0]) * np.sin(angle) + (points[..., 1] - center[1]) * np.cos(angle) - offset

    nodes = np.moveaxis(np.indices(shape).astype(float), 0, -1)
    return 50.0 * (1.0 + special.erf(across(nodes) / (np.sqrt(2.0) * 0.5))), across


@pytest.mark.parametrize("angle", [0.0, 0.25, 0.8, 1.3, np.pi / 2])
@pytest.mark.parametrize("offset", [-0.4, 0.0, 0.15, 0.5])
def test_the_ridge_of_a_straight_edge_is_the_edge(angle, offset):
    """Within 0.02 px for any position of the edge between the pixels."""
    image, across = smooth_step((41, 41), angle, offset)
    along = np.linspace(-12.0, 12.0, 25)
    normal, tangent = np.array([np.sin(angle), np.cos(angle)]), np.array([np.cos(angle), -np.sin(angle)])
    start = 20.0 + along[:, None] * tangent + (offset + np.linspace(-0.8, 0.8, 25))[:, None] * normal
    place, found = refine_to_ridge(start, build_scale_field(image, 1.0, 0.0))
    assert found.all()
    assert np.abs(across(place)).max() < 0.02
    np.testing.assert_allclose((place - start) @ tangent, 0.0, atol=0.1)


@pytest.mark.parametrize("center", [(35.0, 36.0), (34.6, 35.3)], ids=str)
@pytest.mark.parametrize(("radius", "smoothing"), [(15.0, 1.0), (28.0, 0.5), (28.0, 1.0), (28.0, 2.0)])
def test_the_ridge_of_a_disk_is_its_boundary_except_for_the_shift_by_smoothing(center, radius, smoothing):
    """Any blur of variance s^2 moves the steepest position of a curved edge inward by s^2 / 2 R.

    The variance is that of the Gaussian, of a pixel (1/12) and of the central difference (1/3). Seen beyond it: a bias
    below 0.007 px and a deviation of 0.005 to 0.02 px. At R = 28 and sigma = 1 the mean is within 0.03 px of the truth.
    """
    scene = disk((70, 72), center, radius)
    place, found = refine_to_ridge(
        circle_points(center, radius + 0.4, 200), build_scale_field(scene.values, smoothing, 0.0)
    )
    outwards = np.hypot(*(place - center).T) - radius
    assert found.all()
    assert outwards.mean() == pytest.approx(-(smoothing**2 + 1.0 / 12.0 + 1.0 / 3.0) / (2.0 * radius), abs=0.012)
    assert outwards.std() < 0.03


def two_pieces(gap, spacing=2.0):
    """Two lines of points along the vertical center line of a 41 by 41 image, with a gap between them."""
    upper, lower = np.arange(18.0, 3.0, -spacing)[::-1], np.arange(18.0 + gap, 37.0, spacing)
    points = np.stack([np.concatenate([upper, lower]), np.full(len(upper) + len(lower), 20.0)], axis=1)
    count = len(upper)
    edges = [(i, i + 1) for i in range(len(points) - 1) if i != count - 1]
    return Graph(points, np.array(edges)), (count - 1, count)


def test_ends_are_joined_along_an_edge_within_reach():
    image, _ = smooth_step((41, 41), 0.0, 0.0)
    scale_field = build_scale_field(image, 1.0, 0.0)
    graph, bridge = two_pieces(4.0)
    before = edges_of(graph)
    link_loose_ends(graph, scale_field, 5.0)
    assert edges_of(graph) - before == {bridge}
    graph, _ = two_pieces(4.0)
    link_loose_ends(graph, scale_field, 3.5)
    assert edges_of(graph) == before


def test_an_end_beside_a_curve_joins_it_in_a_junction():
    """Three uniform regions: one vertical edge, and one that meets it from the right."""
    image = np.zeros((41, 41))
    image[:20, 21:], image[20:, 21:] = 100.0, 220.0
    upright = np.stack([np.arange(5.0, 36.0, 2.0), np.full(16, 20.5)], axis=1)
    right = np.stack([np.full(6, 19.5), np.arange(24.0, 36.0, 2.0)], axis=1)
    edges = [(i, i + 1) for i in range(15)] + [(16 + i, 17 + i) for i in range(5)]
    graph = Graph(np.concatenate([upright, right]), np.array(edges))
    link_loose_ends(graph, build_scale_field(image, 1.0, 0.0), 5.0)
    assert len(edges_of(graph)) == len(edges) + 1
    assert len([c for c in graph.extract_contours() if any(c.junctions)]) == 3
