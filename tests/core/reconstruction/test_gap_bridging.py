"""Bridging gaps: which ends are joined, along which path, and which are not."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cpm_core import Engine, Parameters, Regions, circle
from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import build_scale_field
from cpm_core.reconstruction.curve.gap_bridging import bridge_gaps

from ..scenes import outline_distance

SHAPE = (90, 120)
CENTER, AXES = (65.0, 72.0), (42.0, 55.0)


def gapped_ellipse(shape=(130, 160)):
    """An ellipse whose contrast fades on both sides of its rightmost position, so that no other edge is there."""
    row, col = np.indices(shape)
    away = np.hypot((row - CENTER[0]) / AXES[0], (col - CENTER[1]) / AXES[1]) - 1.0
    distance = np.mean(AXES) * np.abs(away)
    fade = np.clip((np.hypot(row - CENTER[0], col - CENTER[1] - AXES[1]) - 2.5) / 45.0, 0.0, 1.0)
    contrast = 80.0 * fade**2 * (3.0 - 2.0 * fade)
    return 128.0 - contrast * np.clip(2.0 * np.mean(AXES) * away, -1.0, 1.0) * np.exp(-distance / 60.0)


def ellipse_distance(points):
    angle = np.linspace(0.0, 2.0 * np.pi, 2000)
    outline = np.array(CENTER) + np.stack([AXES[0] * np.sin(angle), AXES[1] * np.cos(angle)], axis=1)
    return outline_distance(points, [outline])


@pytest.fixture(scope="module")
def ellipse():
    engine = Engine(gapped_ellipse(), Parameters())
    state = engine.start(circle((65.0, 65.0), 20.0))
    while not state.stop_reason:
        state = engine.step(state, Parameters())
    return engine, state


@pytest.mark.parametrize("max_gap", [25.0, 60.0])
def test_the_ellipse_is_closed_along_the_curve_by_a_wider_bridge_that_is_reported(ellipse, max_gap):
    engine, state = ellipse
    (piece,) = engine.result(state, Parameters()).contours
    result = engine.result(state, Parameters(max_gap=max_gap))
    (contour,), (bridge,) = result.contours, result.bridges
    gap = np.linalg.norm(piece.points[0] - piece.points[-1])
    assert contour.closed
    assert gap <= bridge.length < 1.1 * gap
    assert ellipse_distance(bridge.points).max() < 1.5
    assert bridge.length == pytest.approx(np.linalg.norm(np.diff(bridge.points, axis=0), axis=1).sum())
    assert 0.0 < bridge.strength < 0.1 * contour.strength
    places = {tuple(p) for p in contour.points.tolist()}
    assert {tuple(p) for p in bridge.points.tolist()} <= places
    assert {tuple(p) for p in piece.points.tolist()} <= places
    assert contour.length == pytest.approx(piece.length + bridge.length)


def scale_field_module(boundary, contrast, regions=None):
    """Fields of an image that is bright above `boundary`, a row for every column, by `contrast` in every column."""
    row, col = np.indices(SHAPE, dtype=float)
    away = np.clip(row - boundary(col) + 0.5, 0.0, 1.0)
    return build_scale_field(128.0 + contrast(col) * (0.5 - away), 1.0, 0.0, regions)


def flat(regions=None):
    """Fields with a single edge, far below the lines that are joined."""
    return scale_field_module(lambda col: 80.0 + 0.0 * col, lambda col: 100.0 + 0.0 * col, regions)


def curves(*lines):
    """Graph of polygonal lines, each an array of vertices."""
    first, edges = 0, []
    for line in lines:
        edges += [(first + i, first + i + 1) for i in range(len(line) - 1)]
        first += len(line)
    return Graph(np.concatenate(lines), np.array(edges))


def straight(a, b, spacing=1.5):
    a, b = np.array(a, dtype=float), np.array(b, dtype=float)
    count = int(np.linalg.norm(b - a) / spacing)
    return a + (b - a) * np.linspace(0.0, 1.0, count + 1)[:, None]


def bridged(graph, scale_field, longest=25.0):
    return bridge_gaps(graph, scale_field, longest, 2.0, 8.0)


def test_a_faint_edge_in_the_gap_is_followed():
    """An edge of 4 percent contrast, under the floor, that swings out by 7 px where the ends face each other."""

    def boundary(col):
        return 40.0 + 7.0 * np.exp(-(((col - 60.0) / 9.0) ** 2)) * (np.abs(col - 60.0) < 25.0)

    def step(faint):
        return scale_field_module(boundary, lambda col: np.where(np.abs(col - 60.0) < 19.0, faint, 100.0))

    found = {}
    for faint in (4.0, 0.0):
        left, right = (np.stack([boundary(c), c], axis=1) for c in (np.arange(10.0, 41.0), np.arange(80.0, 111.0)))
        (bridge,) = bridged(curves(left, right), step(faint), 45.0)
        found[faint] = bridge
    assert found[4.0].points[:, 0].max() > 45.5
    assert np.abs(found[4.0].points[:, 0] - boundary(found[4.0].points[:, 1])).max() < 1.2
    assert found[0.0].points[:, 0].max() < 42.0
    assert found[0.0].length == pytest.approx(40.0, abs=1.0)


def test_without_an_edge_a_bridge_continues_straight():
    graph = curves(straight((40.0, 10.0), (30.0, 40.0)), straight((23.0, 61.0), (13.0, 91.0)))
    (bridge,) = bridged(graph, flat())
    away = bridge.points - (40.0, 10.0)
    assert np.abs(away @ np.array([30.0, 10.0]) / np.hypot(30.0, 10.0)).max() < 0.7
    assert len(graph.extract_contours()) == 1


def test_a_t_is_joined_in_a_junction():
    graph = curves(straight((40.0, 10.0), (40.0, 90.0)), straight((25.0, 50.0), (5.0, 52.0)))
    (bridge,) = bridged(graph, flat())
    assert bridge.length == pytest.approx(15.0, abs=1.0)
    contours = graph.extract_contours()
    assert [sum(c.junctions) for c in contours] == [1, 1, 1]
    assert bridge.points[-1].tolist() in [p.tolist() for p in contours[0].points[[0, -1]]]


def test_no_bridge_crosses_a_contour():
    """Another contour between the ends is not met either, since it is nearly parallel."""
    graph = curves(
        straight((40.0, 10.0), (40.0, 50.0)),
        straight((40.0, 64.0), (40.0, 104.0)),
        straight((20.0, 57.0), (60.0, 57.2)),
    )
    found = bridged(graph, flat())
    assert len(found) == 2
    assert all(abs(b.points[-1, 1] - 57.1) < 0.2 for b in found)
    assert all(not c.closed for c in graph.extract_contours())


def test_no_bridge_crosses_a_barrier_or_leaves_the_region():
    lines = straight((40.0, 10.0), (40.0, 50.0)), straight((40.0, 64.0), (40.0, 104.0))
    assert len(bridged(curves(*lines), flat())) == 1
    assert bridged(curves(*lines), flat(Regions(barriers=(((10.0, 57.0), (70.0, 57.5)),)))) == ()
    around = ((2, 2), (2, 117), (88, 117), (88, 60), (5, 57), (88, 54), (88, 2))
    assert bridged(curves(*lines), flat(Regions(interest=(around,)))) == ()


@settings(max_examples=10, deadline=None)
@example(seed=7090, longest=40.0)
@given(st.integers(0, 10**6), st.floats(1.0, 40.0))
def test_bridges_only_add_and_cross_nothing_and_are_no_wider_than_asked(seed, longest):
    rng = np.random.default_rng(seed)
    lines = []
    for _ in range(6):
        a, turn = rng.uniform((10, 10), (80, 110)), rng.uniform(0.0, 2.0 * np.pi)
        line = straight(a, a + rng.uniform(9.0, 30.0) * np.array([np.sin(turn), np.cos(turn)]))
        lines.append(np.clip(line, 1.0, (88.0, 118.0)))
    graph = curves(*lines)
    before = graph.edges()
    loose = {tuple(p) for p in graph.points[graph.loose_ends()].tolist()}
    found = bridge_gaps(graph, flat(), longest, 2.0, 8.0)
    after = {tuple(e) for e in graph.edges().tolist()}
    assert {tuple(e) for e in before.tolist()} <= after
    assert len(after) == len(before) + sum(len(b.points) - 1 for b in found)
    for bridge in found:
        a, b = bridge.points[0], bridge.points[-1]
        assert np.linalg.norm(a - b) <= longest + 1e-9
        assert tuple(a.tolist()) in loose
        assert bridge.length <= 2.0 * np.linalg.norm(a - b) + 1.0
        for (p, q), (r, s) in itertools.product(itertools.pairwise(bridge.points), graph.points[before]):
            if not (np.isin([p, q], [a, b]).all(axis=1).any() and np.isin([r, s], [a, b]).all(axis=1).any()):
                assert not crossing(p, q, r, s)


def crossing(a, b, p, q):
    """Whether segments ab and pq cross, by solving for the intersection."""
    matrix = np.stack([b - a, p - q], axis=1)
    if abs(np.linalg.det(matrix)) < 1e-9:
        return False
    t, s = np.linalg.solve(matrix, p - a)
    return bool(1e-9 < t < 1.0 - 1e-9 and 1e-9 < s < 1.0 - 1e-9)
