"""Deletion and insertion, against looking at every pair and on edges that are known exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Parameters
from cpm_core.level import build_level
from cpm_core.particles import Particles
from cpm_core.population import deletion, insertion, on_edge

from .scenes import disk

SHAPE = (40, 48)
EDGE = 21.3
"""Column of the upright edge that the insertion tests stand on."""


def upright(contrast=100.0):
    """A step at a known place, each pixel holding what part of it lies beyond; `contrast` may depend on the row."""
    share = np.clip(np.arange(SHAPE[1]) + 0.5 - EDGE, 0.0, 1.0)
    return np.broadcast_to(np.asarray(contrast, dtype=float).reshape(-1, 1) * share, SHAPE).copy()


@pytest.fixture(scope="module")
def edge():
    return build_level(upright(), 1.0, 0.0)


def apart(points):
    """Distances of all pairs, and infinity to oneself."""
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    np.fill_diagonal(distance, np.inf)
    return distance


coordinate = st.tuples(st.integers(-4, 39 * 8 + 4), st.integers(-4, 47 * 8 + 4)).map(lambda p: (p[0] / 8, p[1] / 8))
crowds = st.one_of(
    st.lists(coordinate, max_size=30),
    st.tuples(coordinate, st.lists(st.tuples(st.floats(0, 3), st.floats(0, 3)), max_size=40)).map(
        lambda c: [(min(c[0][0] + y, 39.5), min(c[0][1] + x, 47.5)) for y, x in c[1]]
    ),
).map(lambda points: np.array(points, dtype=float).reshape(-1, 2))


@settings(max_examples=60, deadline=None)
@given(crowds, st.integers(0, 10**6), st.sampled_from([0.5, 1.0, 2.0, 4.5]))
def test_deletion_leaves_no_two_too_near_and_goes_no_further(points, seed, d_min):
    strength = np.random.default_rng(seed).integers(0, 4, len(points)).astype(float)
    kept = deletion(points, strength, SHAPE, d_min)
    near = ((points[:, None] - points) ** 2).sum(axis=2) < (0.5 * d_min) ** 2
    np.fill_diagonal(near, False)
    assert not near[np.ix_(kept, kept)].any()
    for i in np.flatnonzero(~kept):
        assert (near[i] & kept & (strength >= strength[i])).any()


@settings(max_examples=30, deadline=None)
@given(crowds, st.integers(0, 10**6))
def test_deletion_twice_deletes_no_more(points, seed):
    strength = np.random.default_rng(seed).uniform(0.0, 9.0, len(points))
    kept = deletion(points, strength, SHAPE, 2.0)
    assert deletion(points[kept], strength[kept], SHAPE, 2.0).all()


@settings(max_examples=30, deadline=None)
@given(crowds, st.integers(0, 10**6))
def test_deletion_does_not_depend_on_the_order_of_the_particles(points, seed):
    rng = np.random.default_rng(seed)
    strength = rng.permutation(len(points)).astype(float)
    order = rng.permutation(len(points))
    kept = deletion(points, strength, SHAPE, 2.0)
    np.testing.assert_array_equal(deletion(points[order], strength[order], SHAPE, 2.0), kept[order])


def test_deletion_keeps_the_one_on_the_stronger_edge_and_the_earlier_of_equals():
    pair = np.array([(10.0, 10.0), (10.0, 10.5)])
    assert deletion(pair, np.array([1.0, 2.0]), SHAPE, 2.0).tolist() == [False, True]
    assert deletion(pair, np.array([2.0, 2.0]), SHAPE, 2.0).tolist() == [True, False]
    assert deletion(pair, np.array([1.0, 2.0]), SHAPE, 1.0).tolist() == [True, True]  # exactly d_min / 2 apart


def test_on_edge_asks_for_a_weak_force_and_a_strong_edge():
    felt = np.array([(0.0, 0.1, 9, 9, 5.0), (0.0, -1.0, 9, 9, 5.0), (0.6, 0.8, 9, 9, 5.0), (0.0, 0.1, 9, 9, 0.5)])
    assert on_edge(felt, 1.0).tolist() == [True, False, False, False]
    assert on_edge(felt, 0.0).tolist() == [True, False, False, True]


def births_between(level, points, d_max=3.0, seated=True, d_min=2.0):
    """New particles by the rule for pairs alone: nobody looks ahead."""
    points = np.array(points, dtype=float)
    seats = np.broadcast_to(np.asarray(seated), len(points)).copy()
    looking = np.zeros(len(points), bool)
    return insertion(points, seats, looking, level, d_max, Parameters(d_min=d_min))


@pytest.mark.parametrize("distance", [2.21, 2.5, 3.7, 5.0])
def test_a_pair_within_range_on_an_edge_gets_its_midpoint(edge, distance):
    births = births_between(edge, [(15.0, EDGE), (15.0 + distance, EDGE)])
    np.testing.assert_allclose(births.position, [(15.0 + 0.5 * distance, EDGE)], atol=1e-12)
    assert sorted([*births.parent, *births.other]) == [0, 1]


@pytest.mark.parametrize("distance", [0.5, 1.99, 2.0, 5.01, 7.0, 20.0])
def test_a_pair_too_near_or_too_far_gets_none(edge, distance):
    assert len(births_between(edge, [(15.0, EDGE), (15.0 + distance, EDGE)]).position) == 0


def test_range_shrinks_with_annealing_and_grows_with_d_min(edge):
    pair = [(15.0, EDGE), (18.5, EDGE)]
    assert len(births_between(edge, pair, d_max=1.51).position) == 1
    assert len(births_between(edge, pair, d_max=1.49).position) == 0
    assert len(births_between(edge, pair, d_min=3.1).position) == 1
    assert len(births_between(edge, pair, d_min=3.6).position) == 0


@pytest.mark.parametrize("seated", [(True, False), (False, True), (False, False)], ids=str)
def test_a_pair_of_which_one_does_not_sit_gets_none(edge, seated):
    assert len(births_between(edge, [(15.0, EDGE), (18.0, EDGE)], seated=seated).position) == 0


def test_a_pair_around_another_particle_gets_none(edge):
    assert (
        len(births_between(edge, [(15.0, EDGE), (18.0, EDGE), (16.4, EDGE + 0.2)], seated=(True, True, False)).position)
        == 0
    )


def test_no_particle_is_born_where_there_is_no_edge(edge):
    assert len(births_between(edge, [(15.0, EDGE + 9.0), (18.0, EDGE + 9.0)]).position) == 0
    assert len(births_between(edge, [(15.0, EDGE - 15.0), (18.0, EDGE - 15.0)]).position) == 0


def test_a_chain_gets_one_particle_in_every_gap(edge):
    rows = np.array([5.0, 8.0, 11.5, 15.9, 18.5, 26.0])
    births = births_between(edge, np.stack([rows, np.full(6, EDGE)], axis=1))
    np.testing.assert_allclose(sorted(births.position[:, 0]), [6.5, 9.75, 13.7, 17.2], atol=1e-12)
    np.testing.assert_allclose(births.position[:, 0], 0.5 * (rows[births.parent] + rows[births.other]), atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(2.3, 8.0), min_size=1, max_size=5), st.floats(0.4, 5.0))
def test_gaps_within_range_breed_and_no_others(edge, gaps, d_max):
    rows = 0.5 + np.cumsum([0.0, *gaps])
    births = births_between(edge, np.stack([rows, np.full(len(rows), EDGE)], axis=1), d_max=d_max)
    gaps = np.diff(rows)
    if np.abs(gaps - 2.0 - d_max).min() > 1e-9:
        truth = (rows[:-1] + 0.5 * gaps)[gaps <= 2.0 + d_max]
        np.testing.assert_allclose(np.sort(births.position[:, 0]), truth, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.0, 39.0), min_size=2, max_size=25, unique=True), st.floats(0.0, 3.0))
def test_newborn_lie_midway_between_parents_within_range_and_apart_from_everybody(edge, rows, d_max):
    points = np.stack([np.array(rows), np.full(len(rows), EDGE)], axis=1)
    births = births_between(edge, points, d_max=d_max)
    one, other = points[births.parent], points[births.other]
    np.testing.assert_allclose(births.position, 0.5 * (one + other), atol=1e-12)
    gaps = np.linalg.norm(one - other, axis=1)
    assert np.all((gaps > 2.0) & (gaps <= 2.0 + d_max))
    if len(births.position):
        assert apart(np.concatenate([points, births.position]))[len(points) :].min() >= 1.0


def grown(level, start, rounds, d_min=2.0):
    """Particles after rounds of births from those at `start`, all of whom sit and look ahead."""
    points = np.array(start, dtype=float)
    for _ in range(rounds):
        everybody = np.ones(len(points), bool)
        births = insertion(points, everybody, everybody, level, 0.0, Parameters(d_min=d_min))
        points = np.concatenate([points, births.position])
    return points


def test_a_particle_breeds_along_an_edge_in_both_directions(edge):
    row = 20.0
    newborn = grown(edge, [(row, EDGE)], 1)[1:]
    assert newborn[:, 0].min() < row - 1.0
    assert newborn[:, 0].max() > row + 1.0


def test_a_front_covers_an_edge_from_end_to_end_and_nothing_else(edge):
    points = grown(edge, [(20.0, EDGE)], 40)
    assert np.abs(points[:, 1] - EDGE).max() < 1.0
    rows = np.sort(points[:, 0])
    assert rows[0] < 2.0
    assert rows[-1] > 37.0
    assert np.diff(rows).max() < 4.0
    assert apart(points).min() > 1.0


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5, 4.4])
def test_a_front_goes_all_the_way_round_a_disk(angle):
    scene = disk((56, 60), (27.4, 30.2), 19.0)
    level = build_level(scene.values, 1.0, 0.0)
    start = np.array([(27.4 + 19.0 * np.sin(angle), 30.2 + 19.0 * np.cos(angle))])
    points = grown(level, start, 60)
    assert scene.distance(points).max() < 1.0
    assert np.linalg.norm(scene.boundary[:, None] - points, axis=2).min(axis=1).max() < 2.0
    again = grown(level, points, 1)
    assert len(again) == len(points)


def test_nothing_breeds_on_an_edge_below_the_floor():
    """Two upright edges: beside one of full contrast, one of 5 percent counts as none."""
    image = upright()
    image[:, 40:] += 5.0
    level = build_level(image, 1.0, 0.0)
    assert len(grown(level, [(20.0, 39.5)], 3)) == 1


def test_a_front_stops_where_the_edge_fades():
    contrast = np.interp(np.arange(40.0), [15.0, 22.0], [100.0, 0.0])
    level = build_level(upright(contrast), 1.0, 0.0)
    points = grown(level, [(6.0, EDGE)], 40)
    at = points[points[:, 0] > 3.0]
    assert at[:, 0].max() > 14.0
    assert not np.any((np.abs(points[:, 1] - EDGE) < 4.0) & (points[:, 0] > 26.0))


def test_nobody_looks_ahead_who_is_not_asked_to(edge):
    points = np.array([(20.0, EDGE)])
    births = insertion(points, np.array([True]), np.array([False]), edge, 3.0, Parameters())
    assert len(births.position) == 0
    births = insertion(points, np.array([False]), np.array([True]), edge, 3.0, Parameters())
    assert len(births.position) == 0


def test_births_are_the_same_bits_at_every_call(edge):
    points = np.stack([np.linspace(2.0, 37.0, 9), np.full(9, EDGE)], axis=1)
    first, second = (insertion(points, np.ones(9, bool), np.ones(9, bool), edge, 3.0, Parameters()) for _ in range(2))
    assert first.position.tobytes() == second.position.tobytes()


def parents(count=6, first=10):
    rng = np.random.default_rng(0)
    position, velocity = rng.normal(size=(2, count, 2))
    return Particles(
        position, velocity, rng.normal(size=(2, count, 2)), rng.normal(size=(count, 4)), np.arange(first, first + count)
    )


def test_the_newborn_inherit_the_mean_motion_of_their_parents():
    old = parents()
    one, other = np.array([0, 2, 5]), np.array([1, 2, 3])
    place = np.array([(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)])
    after = old.joined_by(place, one, other, 40)
    assert len(after) == 9
    np.testing.assert_array_equal(after.position[6:], place)
    for n, (i, j) in enumerate(zip(one, other, strict=True)):
        np.testing.assert_allclose(after.velocity[6 + n], (old.velocity[i] + old.velocity[j]) / 2.0)
        np.testing.assert_allclose(after.force[:, 6 + n], (old.force[:, i] + old.force[:, j]) / 2.0)
    assert np.isnan(after.distance[6:]).all()
    for name in ("position", "velocity", "distance", "identity"):
        np.testing.assert_array_equal(getattr(after, name)[:6], getattr(old, name))
    np.testing.assert_array_equal(after.force[:, :6], old.force)


def test_identities_are_numbered_on_and_go_with_their_particles():
    after = parents().joined_by(np.zeros((3, 2)), np.array([0, 0, 1]), np.array([1, 2, 2]), 40)
    assert after.identity.tolist() == [10, 11, 12, 13, 14, 15, 40, 41, 42]
    kept = np.array([True, False] * 4 + [True])
    left = after.where(kept)
    assert left.identity.tolist() == [10, 12, 14, 40, 42]
    np.testing.assert_array_equal(left.position, after.position[kept])
    np.testing.assert_array_equal(left.velocity, after.velocity[kept])
    np.testing.assert_array_equal(left.force, after.force[:, kept])


def test_particles_at_rest_have_no_motion_and_a_copy_of_their_places():
    place = np.array([(1.0, 2.0), (3.0, 4.0)])
    rest = Particles.at_rest(place, 5)
    place[:] = 0.0
    assert rest.position.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert not rest.velocity.any()
    assert not rest.force.any()
    assert rest.identity.tolist() == [5, 6]
