"""Deletion and insertion, against looking at every pair and on edges that are known exactly."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core import Parameters, Regions
from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.scale_field import build_scale_field
from cpm_core.model.plane.births import (
    PlaneBirths,
    examine_contacts,
    find_insertions,
    replace_particles,
    search_range,
    select_survivors,
)
from cpm_core.model.plane.motion import edge_contact_at
from cpm_core.model.plane.repulsion import build_plane_cells
from cpm_core.model.state import Particles

from ...scenes import ring
from ..moving import crowds as crowded
from ..moving import edge_contact, even_scale_field

SHAPE = (40, 48)
EDGE = 21.3
"""Column of the upright edge in the insertion tests."""


def upright(contrast=100.0):
    """A step at a known place, each pixel holding what part of it lies beyond; `contrast` may depend on the row."""
    share = np.clip(np.arange(SHAPE[1]) + 0.5 - EDGE, 0.0, 1.0)
    return np.broadcast_to(np.asarray(contrast, dtype=float).reshape(-1, 1) * share, SHAPE).copy()


@pytest.fixture(scope="module")
def edge():
    return build_scale_field(upright(), 1.0, 0.0)


def apart(points):
    """Distances of all pairs, infinite for each with itself."""
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    np.fill_diagonal(distance, np.inf)
    return distance


class TestDeletion:
    @settings(max_examples=24, deadline=None)
    @given(seed=st.integers(0, 10**6), d_min=st.sampled_from([0.5, 1.0, 2.0, 4.5]))
    def test_deletion_leaves_no_two_too_near_and_goes_no_further(self, seed, d_min):
        points = crowded(SHAPE, seed)
        strength = np.random.default_rng(seed).integers(0, 4, len(points)).astype(float)
        kept = select_survivors(points, strength, d_min)
        near = apart(points) < 0.5 * d_min
        assert not near[np.ix_(kept, kept)].any()
        for i in np.flatnonzero(~kept):
            assert (near[i] & kept & (strength >= strength[i])).any()
        assert select_survivors(points[kept], strength[kept], d_min).all()

    @settings(max_examples=12, deadline=None)
    @given(seed=st.integers(0, 10**6))
    def test_deletion_does_not_depend_on_the_order_of_the_particles(self, seed):
        points, rng = crowded(SHAPE, seed), np.random.default_rng(seed)
        strength, order = rng.permutation(len(points)).astype(float), rng.permutation(len(points))
        kept = select_survivors(points, strength, 2.0)
        np.testing.assert_array_equal(select_survivors(points[order], strength[order], 2.0), kept[order])


coordinate = st.tuples(st.integers(-4, 39 * 8 + 4), st.integers(-4, 47 * 8 + 4)).map(lambda p: (p[0] / 8, p[1] / 8))
crowds = st.one_of(
    st.lists(coordinate, max_size=30),
    st.tuples(coordinate, st.lists(st.tuples(st.floats(0, 3), st.floats(0, 3)), max_size=40)).map(
        lambda c: [(min(c[0][0] + y, 39.5), min(c[0][1] + x, 47.5)) for y, x in c[1]]
    ),
).map(lambda points: np.array(points, dtype=float).reshape(-1, 2))


def test_deletion_keeps_the_one_on_the_stronger_edge_and_the_earlier_of_equals():
    pair = np.array([(10.0, 10.0), (10.0, 10.5)])
    assert select_survivors(pair, np.array([1.0, 2.0]), 2.0).tolist() == [False, True]
    assert select_survivors(pair, np.array([2.0, 2.0]), 2.0).tolist() == [True, False]
    assert select_survivors(pair, np.array([1.0, 2.0]), 1.0).tolist() == [True, True]  # exactly d_min / 2 apart


@settings(max_examples=16, deadline=None)
@given(crowds, crowds, st.integers(0, 10**6))
def test_particles_close_to_one_that_has_moved_are_found(points, more, seed):
    rest = select_survivors(points, np.zeros(len(points)), 2.0)
    every = np.concatenate([points[rest], more])
    has_moved = np.arange(len(every)) >= rest.sum()
    scale_field = even_scale_field(SHAPE, (0.0, 0.0))
    cells = build_plane_cells(every, SHAPE, search_range(Parameters()))
    contact, close = examine_contacts(cells, has_moved, scale_field, 2.0)
    np.testing.assert_array_equal(close, (apart(every) < 1.0).any(axis=1))
    for found, truth in zip(
        (contact.strength, contact.on_edge, contact.normal), edge_contact_at(every, scale_field), strict=True
    ):
        np.testing.assert_array_equal(found, truth)
    strength = np.random.default_rng(seed).integers(0, 4, len(every)).astype(float)
    np.testing.assert_array_equal(select_survivors(every, strength, 2.0, close), select_survivors(every, strength, 2.0))


def test_edge_contact_follows_the_field_between_the_pixels(edge):
    points = np.random.default_rng(0).uniform(-0.5, 39.5, (2000, 2))
    force = np.hypot(*interpolate_field(edge.lorentz, points).T)
    strength = edge.strength_at(points)
    clear = (np.abs(force - 0.93) > 1e-5) & (np.abs(strength - edge.floor) > 1e-4)
    truth = (force < 0.93) & (strength >= edge.floor)
    assert 50 < truth.sum() < 1000
    np.testing.assert_array_equal(edge_contact_at(points, edge)[1][clear], truth[clear])
    contact = edge_contact(points, edge, search_range(Parameters()))
    np.testing.assert_array_equal(contact.on_edge, edge_contact_at(points, edge)[1])
    np.testing.assert_allclose(contact.strength, strength, rtol=1e-6, atol=1e-6 * edge.strongest)


def births_of(scale_field, points, d_max=3.0, on_edge=True, looking=True, present=True, d_min=2.0, **parameters):
    """New particles of those at some points; all are on an edge, search and are present unless given otherwise.

    `d_max` is what annealing has left of it, for all or for each.
    """
    points = np.array(points, dtype=float).reshape(-1, 2)
    left = np.broadcast_to(np.asarray(d_max, dtype=float), len(points)).copy()
    asked = Parameters(d_min=d_min, d_max=max(left.max(initial=0.0), 3.0), **parameters)
    contact_at, searching, there = (
        np.broadcast_to(np.asarray(mask, dtype=bool), len(points)).copy() for mask in (on_edge, looking, present)
    )
    contact = replace(edge_contact(points, scale_field, search_range(asked)), on_edge=contact_at)
    return find_insertions(contact, there, searching, scale_field, left, asked)


def births_between(scale_field, points, d_max=3.0, d_min=2.0):
    """New particles between two others, without those of lone particles."""
    births = births_of(scale_field, points, d_max, d_min=d_min)
    paired = births.parents[:, 0] != births.parents[:, 1]
    return PlaneBirths(births.position[paired], births.parents[paired])


@pytest.mark.parametrize("distance", [2.21, 2.5, 3.7, 5.0])
def test_a_pair_within_range_on_an_edge_gets_its_midpoint(edge, distance):
    births = births_between(edge, [(15.0, EDGE), (15.0 + distance, EDGE)])
    np.testing.assert_allclose(births.position, [(15.0 + 0.5 * distance, EDGE)], atol=1e-12)
    assert sorted(births.parents[0]) == [0, 1]


@settings(max_examples=16, deadline=None)
@given(st.lists(st.floats(2.3, 8.0), min_size=1, max_size=5), st.floats(0.4, 5.0))
def test_gaps_within_range_are_filled_and_no_others(edge, gaps, d_max):
    rows = 0.5 + np.cumsum([0.0, *gaps])
    gaps = np.diff(rows)
    assume(np.abs(gaps - 2.0 - d_max).min() > 1e-9)
    births = births_between(edge, np.stack([rows, np.full(len(rows), EDGE)], axis=1), d_max=d_max)
    truth = (rows[:-1] + 0.5 * gaps)[gaps <= 2.0 + d_max]
    np.testing.assert_allclose(np.sort(births.position[:, 0]), truth, atol=1e-12)


@settings(max_examples=16, deadline=None)
@given(st.lists(st.floats(0.0, 39.0), min_size=2, max_size=25, unique=True), st.floats(0.0, 3.0))
def test_new_particles_are_midway_between_parents_within_range_and_apart_from_all(edge, rows, d_max):
    points = np.stack([np.array(rows), np.full(len(rows), EDGE)], axis=1)
    births = births_between(edge, points, d_max=d_max)
    one, other = points[births.parents.T]
    np.testing.assert_allclose(births.position, 0.5 * (one + other), atol=1e-12)
    gaps = np.linalg.norm(one - other, axis=1)
    assert np.all((gaps > 2.0) & (gaps <= 2.0 + d_max))
    if len(births.position):
        assert apart(np.concatenate([points, births.position]))[len(points) :].min() >= 1.0


@pytest.mark.parametrize(("left", "born"), [((0.0, 2.5), 1), ((2.5, 0.0), 1), ((1.5, 1.5), 0), ((0.0, 0.0), 0)])
def test_the_particle_that_annealing_has_left_more_range_decides_on_a_pair(edge, left, born):
    """Two particles 4 px apart need 2 px beyond d_min; both have another on the far side, so that none is alone."""
    points = [(13.2, EDGE), (15.0, EDGE), (19.0, EDGE), (20.8, EDGE)]
    births = births_of(edge, points, d_max=(0.0, *left, 0.0))
    np.testing.assert_allclose(births.position, np.reshape(born * [(17.0, EDGE)], (-1, 2)), atol=1e-12)


def test_a_particle_alone_on_an_edge_gets_one_to_each_side_at_d_min_along_it(edge):
    births = births_of(edge, [(20.0, EDGE)])
    np.testing.assert_allclose(np.sort(births.position[:, 0]), [18.0, 22.0], atol=1e-9)
    np.testing.assert_allclose(births.position[:, 1], EDGE, atol=0.2)
    assert (births.parents == 0).all()
    three = np.concatenate([[(20.0, EDGE)], births.position])
    assert len(births_of(edge, three).position) == 0


@pytest.mark.parametrize(("other", "alone"), [(6.0, True), (5.0, False)])
@pytest.mark.parametrize("left", [3.0, 0.5])
def test_a_particle_is_alone_with_none_in_reach_whatever_annealing_has_left(edge, other, left, alone):
    births = births_of(edge, [(15.0, EDGE), (15.0 + other, EDGE)], d_max=left)
    assert (births.parents[:, 0] == births.parents[:, 1]).any() == alone
    assert len(births_of(edge, [(15.0, EDGE + 6.0)]).position) == 0  # off the edge there is no place beside it


def test_without_an_insertion_range_no_particle_is_born(edge):
    assert len(births_of(edge, [(15.0, EDGE)], d_max=0.0).position) == 0


def test_a_particle_next_to_the_beginning_of_another_edge_gets_one_there():
    """Where a T meets: the weaker edge begins some pixels beside the stronger one."""
    rows, cols = np.mgrid[:40, :40]
    meeting = np.where(cols < 20, 200.0, np.where(rows < 20, 140.0, 20.0))
    scale_field = build_scale_field(meeting, 1.0, 0.0)
    stem = np.stack([np.arange(4.5, 37.0, 1.5), np.full(22, 19.5)], axis=1)
    births = births_of(scale_field, stem)
    beside = births.position[births.parents[:, 0] == births.parents[:, 1]]
    np.testing.assert_allclose(beside[:, 0], 19.5, atol=0.5)
    assert len(beside) == 1
    assert beside[0, 1] > 21.0


def test_a_row_ahead_of_which_an_edge_is_free_grows_by_no_birth(edge):
    rows = np.arange(10.0, 21.0, 2.0)
    assert len(births_of(edge, np.stack([rows, np.full(len(rows), EDGE)], axis=1)).position) == 0


def test_a_deleted_particle_is_no_parent_and_blocks_no_position(edge):
    points = [(15.0, EDGE), (16.9, EDGE), (18.6, EDGE)]
    assert len(births_of(edge, points).position) == 0
    births = births_of(edge, points, present=(True, False, True))
    np.testing.assert_allclose(births.position, [(16.8, EDGE)], atol=1e-12)
    assert (births_of(edge, points, present=(True, False, False)).parents == 0).all()


def test_no_particle_is_inserted_across_a_barrier():
    """Neither between two on both sides of it, nor beside one that is alone."""
    scale_field = build_scale_field(upright(), 1.0, 0.0, Regions(barriers=(((20.2, 0.0), (20.2, 47.0)),)))
    assert len(births_of(scale_field, [(19.0, EDGE), (22.0, EDGE)]).position) == 0
    assert len(births_of(scale_field, [(15.0, EDGE), (18.0, EDGE)]).position) == 1
    for row in (19.0, 21.4):
        (beside,) = births_of(scale_field, [(row, EDGE)]).position
        assert (beside[0] < 20.2) == (row < 20.2)


@pytest.fixture(scope="module")
def curved():
    return build_scale_field(ring((60, 64), (29.4, 31.2), 14.0, 22.0).values, 1.0, 0.0)


def on_the_ring(seed, count=120):
    """Particles on and beside the rims of the ring, with gaps and crowds, thinned as in a step."""
    rng = np.random.default_rng(seed)
    angle, radius = rng.uniform(0.0, 6.0, count), rng.choice([14.0, 22.0], count) + rng.normal(0.0, 0.3, count)
    points = np.stack([29.4 + radius * np.sin(angle), 31.2 + radius * np.cos(angle)], axis=1)
    return points[select_survivors(points, np.zeros(count), 2.0)]


@settings(max_examples=16, deadline=None)
@given(st.integers(0, 10**6), st.integers(5, 150), st.floats(0.0, 6.0))
def test_new_particles_keep_their_distance_from_all_and_from_each_other(curved, seed, count, d_max):
    """Half the distance of two parents, or half of d_min beside one; and no more than three are within 1.5 d_min."""
    points = on_the_ring(seed, count)
    births = births_of(curved, points, d_max=d_max)
    there = points
    for place, (one, other) in zip(births.position, births.parents, strict=True):
        room = 1.0 if one == other else 0.5 * np.linalg.norm(points[one] - points[other]) - 2e-9
        distance = np.linalg.norm(there - place, axis=1)
        assert distance.min() >= room
        assert (distance < 3.0).sum() <= 3
        assert curved.strength_at(place[None])[0] >= curved.floor * (1.0 - 1e-6)
        there = np.concatenate([there, place[None]])


def parents(count=6, first=10):
    rng = np.random.default_rng(0)
    position, velocity = rng.normal(size=(2, count, 2))
    force, distance, crept = rng.normal(size=(count, 2, 2)), rng.normal(size=(count, 4)), rng.uniform(size=count)
    return Particles(position, velocity, force, distance, np.arange(first, first + count), crept)


def test_new_particles_inherit_the_mean_motion_and_way_of_their_parents():
    old = parents()
    pairs = np.array([(0, 1), (2, 2), (5, 3)])
    place = np.array([(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)])
    stay = np.array([4, 0, 1, 5, 2])
    after = replace_particles(old, stay, PlaneBirths(place, pairs), 40)
    assert len(after) == 8
    np.testing.assert_array_equal(after.position[5:], place)
    for n, (i, j) in enumerate(pairs):
        np.testing.assert_allclose(after.velocity[5 + n], (old.velocity[i] + old.velocity[j]) / 2.0)
        np.testing.assert_allclose(after.force[5 + n], (old.force[i] + old.force[j]) / 2.0)
        assert after.crept[5 + n] == pytest.approx((old.crept[i] + old.crept[j]) / 2.0)
    assert np.isnan(after.distance[5:]).all()
    for name in ("position", "velocity", "force", "distance", "identity", "crept"):
        np.testing.assert_array_equal(getattr(after, name)[:5], getattr(old, name)[stay])
