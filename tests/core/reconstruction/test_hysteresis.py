"""Hysteresis thresholding against brute force, and thresholds that only remove."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Engine, Parameters, uniform_grid
from cpm_core.contours.graph import Graph
from cpm_core.reconstruction.curve.hysteresis import drop_unconnected, rate_edges


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
    rated, rating = rate_edges(graph, lambda _: strength)
    graph.remove_edges(rated[rating < least])
    drop_unconnected(graph, strength, sure)
    return {tuple(edge) for edge in graph.edges().tolist()}, by_edge(rated, rating)


def by_edge(edges, ratings):
    """Ratings as a dictionary from edges, the lower index first."""
    return {(min(edge), max(edge)): rating for edge, rating in zip(edges.tolist(), ratings, strict=True)}


thresholds = st.floats(0.0, 9.0)


@settings(max_examples=60, deadline=None)
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


@settings(max_examples=60, deadline=None)
@given(rated_graphs())
def test_closed_contours_and_those_between_junctions_are_rated_as_a_whole(made):
    points, edges, strength = made
    graph = Graph(points, edges)
    rated = by_edge(*rate_edges(graph, lambda _: strength))
    assert set(rated) == {tuple(edge) for edge in graph.edges().tolist()}
    ways = graph.find_paths()
    assert len(rated) == len(ways.path_edges()[0])
    for path, closed in ((ways.path_vertices(n).tolist(), ways.closed[n]) for n in range(len(ways))):
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
