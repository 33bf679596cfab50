"""Hysteresis thresholding against brute force, and thresholds that only remove."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Engine, Parameters, uniform_grid
from cpm_core.contours.graph import Graph
from cpm_core.reconstruction.curve.hysteresis import drop_unconnected, drop_under, ratings


@st.composite
def rated_graphs(draw):
    """Any graph, and a strength for each of its vertices."""
    count = draw(st.integers(2, 14))
    pairs = st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)).filter(lambda p: p[0] != p[1])
    edges = draw(st.lists(pairs, max_size=30))
    strength = np.array(draw(st.lists(st.integers(0, 9), min_size=count, max_size=count)), dtype=float)
    points = np.random.default_rng(draw(st.integers(0, 1000))).uniform(0.0, 20.0, (count, 2))
    return points, np.array(edges, dtype=np.int64).reshape(-1, 2), strength


def kept_edges(made, least, sure):
    """Edges that the two thresholds leave, and the ratings."""
    points, edges, strength = made
    graph = Graph(points, edges)
    rated = ratings(graph, lambda _: strength)
    drop_under(graph, rated, least)
    drop_unconnected(graph, strength, sure)
    return {tuple(edge) for edge in graph.edges().tolist()}, by_edge(rated)


def by_edge(rated):
    """Ratings as a dictionary from edges, the lower index first."""
    return {(min(edge), max(edge)): rating for edge, rating in zip(rated.edges.tolist(), rated.rating, strict=True)}


thresholds = st.floats(0.0, 9.0)


@settings(max_examples=150, deadline=None)
@given(rated_graphs(), thresholds, thresholds)
def test_remaining_edges_are_strong_enough_and_connected_to_sure_ones(made, least, sure):
    kept, rated = kept_edges(made, least, sure)
    strength = made[2]
    truth = {e for e, rating in rated.items() if rating >= least and max(strength[e[0]], strength[e[1]]) >= sure}
    while True:
        near = {edge for edge in rated if rated[edge] >= least and any(set(edge) & set(other) for other in truth)}
        if near <= truth:
            break
        truth |= near
    assert kept == truth


@settings(max_examples=150, deadline=None)
@given(rated_graphs(), thresholds, thresholds, thresholds, thresholds)
def test_a_higher_threshold_only_removes(made, least, sure, more, surer):
    kept, _ = kept_edges(made, least, sure)
    fewer, _ = kept_edges(made, least + more, sure + surer)
    assert fewer <= kept


@settings(max_examples=100, deadline=None)
@given(rated_graphs())
def test_without_thresholds_everything_stays(made):
    points, edges, _ = made
    assert kept_edges(made, 0.0, 0.0)[0] == {tuple(edge) for edge in Graph(points, edges).edges().tolist()}


@settings(max_examples=100, deadline=None)
@given(rated_graphs())
def test_closed_contours_and_those_between_junctions_are_rated_as_a_whole(made):
    points, edges, strength = made
    graph = Graph(points, edges)
    rated = by_edge(ratings(graph, lambda _: strength))
    assert set(rated) == {tuple(edge) for edge in graph.edges().tolist()}
    ways = graph.ways()
    assert len(rated) == len(ways.edges()[0])
    for path, closed in ((ways.path(n).tolist(), ways.closed[n]) for n in range(len(ways))):
        if closed or min(graph.degree(path[0]), graph.degree(path[-1])) > 1:
            sides = itertools.pairwise([*path, path[0]] if closed else path)
            np.testing.assert_allclose([rated[min(s), max(s)] for s in sides], strength[path].mean())


def line(strengths):
    """A straight line of vertices, one pixel apart, with these strengths."""
    points = np.stack([np.zeros(len(strengths)), np.arange(float(len(strengths)))], axis=1)
    return points, np.array(list(itertools.pairwise(range(len(strengths))))), np.array(strengths, dtype=float)


def test_a_contour_with_a_loose_end_loses_its_weak_stretch_and_keeps_the_strong_one():
    kept, _ = kept_edges(line([50.0] * 40 + [5.0] * 60), 25.0, 0.0)
    assert kept == {(i, i + 1) for i in range(max(b for _, b in kept))}
    assert 36 <= len(kept) <= 44


def test_a_short_weak_stretch_does_not_cut_a_contour():
    kept, _ = kept_edges(line([50.0] * 40 + [5.0] * 3 + [50.0] * 40), 25.0, 0.0)
    assert len(kept) == 82


def test_a_weak_stretch_does_not_open_a_closed_contour():
    points, edges, strength = line([50.0] * 60 + [5.0] * 20)
    ring = np.concatenate([edges, [(0, 79)]])
    assert len(kept_edges((points, ring, strength), 25.0, 0.0)[0]) == 80
    assert len(kept_edges((points, ring, strength), 40.0, 0.0)[0]) == 0


def test_a_contour_without_its_weak_branch_is_one_contour_again():
    points, edges, strength = line([50.0] * 41)
    branch = np.stack([np.arange(1.0, 31.0), np.full(30, 20.0)], axis=1)
    more = [(20 if i == 0 else 40 + i, 41 + i) for i in range(30)]
    graph = Graph(np.concatenate([points, branch]), np.concatenate([edges, more]))
    rated = ratings(graph, lambda _: np.concatenate([strength, np.full(30, 5.0)]))
    assert len(graph.contours()) == 3
    drop_under(graph, rated, 30.0)
    graph.drop_spurs(5)
    (contour,) = graph.contours()
    assert len(contour.points) == 41


SHAPE = (120, 120)


@pytest.fixture(scope="module")
def edges_of_four_strengths():
    """A strong vertical edge with a faint one that meets it, and an isolated faint one."""
    image = np.full(SHAPE, 100.0)
    image[:, 40:] += 100.0
    image[60:, 40:] += 25.0
    image[20:40, 75:105] -= 30.0
    engine = Engine(image, Parameters(smoothing=1.0))
    state = engine.start(uniform_grid(SHAPE))
    while not state.stop_reason:
        state = engine.step(state, Parameters())
    return engine, state


def test_faint_edges_stay_where_they_continue_strong_ones(edges_of_four_strengths):
    engine, state = edges_of_four_strengths

    def found(**thresholds):
        contours = engine.result(state, Parameters(**thresholds)).contours
        places = np.concatenate([c.points for c in contours])
        tail = ((np.abs(places[:, 0] - 59.5) < 2.0) & (places[:, 1] > 50.0)).any()
        alone = ((places[:, 1] > 70.0) & (places[:, 0] < 45.0)).any()
        strong = (np.abs(places[:, 1] - 39.5) < 1.0).any()
        return strong, tail, alone

    assert found() == (True, True, True)
    assert found(sure_edge=0.4) == (True, True, False)
    assert found(min_strength=20.0) == (True, False, False)
    assert found(min_strength=5.0, sure_edge=0.4) == (True, True, False)


@pytest.mark.parametrize(
    ("name", "top"), [("min_strength", 300.0), ("sure_edge", 0.99), ("min_contrast", 0.99), ("min_length", 300.0)]
)
def test_a_higher_threshold_never_finds_more(edges_of_four_strengths, name, top):
    engine, state = edges_of_four_strengths
    lengths = [
        sum(c.length for c in engine.result(state, Parameters(**{name: share * top})).contours)
        for share in (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
    ]
    assert max(np.diff(lengths)) < 1e-9
    assert lengths[-1] < lengths[0]


def test_a_short_branch_does_not_open_the_outline_that_it_is_joined_to():
    row, col = np.indices((120, 120))
    image = np.where((row > 60) & (col > 60), 60.0, 20.0)
    image[np.hypot(row - 60, col - 50) < 30] = 220.0
    engine = Engine(image, Parameters())
    state = engine.start(uniform_grid(image.shape))
    while not state.stop_reason:
        state = engine.step(state, Parameters())
    branched = engine.result(state, Parameters()).contours
    assert any(any(contour.junctions) for contour in branched)
    (outline,) = engine.result(state, Parameters(min_length=120.0)).contours
    assert outline.closed
    assert outline.length > 170.0
