"""Deletion and insertion, against looking at every pair and on edges that are known exactly."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Parameters, Regions
from cpm_core.field.interpolation import interpolate
from cpm_core.field.scale_field import build_scale_field
from cpm_core.model.plane import births as deletions
from cpm_core.model.plane import births as insertions
from cpm_core.model.plane.births import Search, deletion, insertion, search_range, thinned
from cpm_core.model.plane.motion import contact_at
from cpm_core.model.state import Particles
from cpm_core.numerics import parallel

from ..scenes import disk, ring
from .moving import cloud, edge_contact, even_scale_field
from .moving import crowds as crowded

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


@pytest.mark.parametrize(("kernels", "shape"), [pytest.param(deletions, SHAPE, id="plane")])
class TestDeletion:
    """What holds for deletion in any dimension."""

    @settings(max_examples=60, deadline=None)
    @given(seed=st.integers(0, 10**6), d_min=st.sampled_from([0.5, 1.0, 2.0, 4.5]))
    def test_deletion_leaves_no_two_too_near_and_goes_no_further(self, kernels, shape, seed, d_min):
        points = crowded(shape, seed)
        strength = np.random.default_rng(seed).integers(0, 4, len(points)).astype(float)
        kept = kernels.deletion(points, strength, shape, d_min)
        near = apart(points) < 0.5 * d_min
        assert not near[np.ix_(kept, kept)].any()
        for i in np.flatnonzero(~kept):
            assert (near[i] & kept & (strength >= strength[i])).any()
        assert kernels.deletion(points[kept], strength[kept], shape, d_min).all()

    @settings(max_examples=30, deadline=None)
    @given(seed=st.integers(0, 10**6))
    def test_deletion_does_not_depend_on_the_order_of_the_particles(self, kernels, shape, seed):
        points, rng = crowded(shape, seed), np.random.default_rng(seed)
        strength, order = rng.permutation(len(points)).astype(float), rng.permutation(len(points))
        kept = kernels.deletion(points, strength, shape, 2.0)
        np.testing.assert_array_equal(kernels.deletion(points[order], strength[order], shape, 2.0), kept[order])


@pytest.mark.parametrize(("kernels", "shape"), [pytest.param(insertions, SHAPE, id="plane")])
class TestInsertion:
    """What holds for insertion in any dimension, on a flat edge across the last axis."""

    def born(self, kernels, shape, points, d_max, ahead):
        share = np.clip(np.arange(shape[-1]) + 0.5 - EDGE, 0.0, 1.0)
        scale_field = build_scale_field(np.broadcast_to(100.0 * share, shape).copy(), 1.0, 0.0)
        parameters = Parameters(d_max=max(d_max, 3.0))
        contact, every = edge_contact(points, scale_field, search_range(parameters)), np.ones(len(points), bool)
        search = Search(every, every, every, ahead & every)
        return contact, kernels.insertion(contact, search, scale_field, d_max, parameters)

    def beside(self, shape, seed, on_edge):
        """Particles on the edge, and some elsewhere."""
        points = cloud(shape, on_edge + 8, seed)
        points[:on_edge, -1] = EDGE + np.random.default_rng(seed).normal(0.0, 0.2, on_edge)
        return points

    @settings(max_examples=40, deadline=None)
    @given(seed=st.integers(0, 10**6), d_max=st.floats(0.0, 4.0))
    def test_those_between_halve_a_pair_within_range_that_none_is_inside_of(self, kernels, shape, seed, d_max):
        points = self.beside(shape, seed, 32)
        contact, births = self.born(kernels, shape, points, d_max, ahead=False)
        one, other = points[births.parent], points[births.other]
        assert contact.on_edge[births.parent].all()
        assert contact.on_edge[births.other].all()
        np.testing.assert_allclose(births.position, 0.5 * (one + other), atol=1e-12)
        gap = np.linalg.norm(one - other, axis=1)
        assert np.all((gap > 2.0) & (gap <= 2.0 + d_max))
        distance = np.linalg.norm(births.position[:, None] - points, axis=2)
        assert np.all(distance.min(axis=1, initial=np.inf) >= 0.5 * gap - 1e-8)
        assert np.all((distance < 3.0).sum(axis=1) <= 3)

    @settings(max_examples=40, deadline=None)
    @given(seed=st.integers(0, 10**6))
    def test_those_ahead_are_on_the_edge_a_stride_from_one_and_keep_their_room_from_all(self, kernels, shape, seed):
        points = self.beside(shape, seed, 5)
        contact, births = self.born(kernels, shape, points, 0.0, ahead=True)
        assert len(births.position)
        assert contact.on_edge[births.parent].all()
        np.testing.assert_array_equal(births.parent, births.other)
        assert np.abs(births.position[:, -1] - EDGE).max() < 1.0
        assert np.linalg.norm(births.position - points[births.parent], axis=1).max() < 2.8
        assert apart(np.concatenate([points, births.position]))[len(points) :].min() >= 1.6


coordinate = st.tuples(st.integers(-4, 39 * 8 + 4), st.integers(-4, 47 * 8 + 4)).map(lambda p: (p[0] / 8, p[1] / 8))
crowds = st.one_of(
    st.lists(coordinate, max_size=30),
    st.tuples(coordinate, st.lists(st.tuples(st.floats(0, 3), st.floats(0, 3)), max_size=40)).map(
        lambda c: [(min(c[0][0] + y, 39.5), min(c[0][1] + x, 47.5)) for y, x in c[1]]
    ),
).map(lambda points: np.array(points, dtype=float).reshape(-1, 2))


def test_deletion_keeps_the_one_on_the_stronger_edge_and_the_earlier_of_equals():
    pair = np.array([(10.0, 10.0), (10.0, 10.5)])
    assert deletion(pair, np.array([1.0, 2.0]), SHAPE, 2.0).tolist() == [False, True]
    assert deletion(pair, np.array([2.0, 2.0]), SHAPE, 2.0).tolist() == [True, False]
    assert deletion(pair, np.array([1.0, 2.0]), SHAPE, 1.0).tolist() == [True, True]  # exactly d_min / 2 apart


@settings(max_examples=40, deadline=None)
@given(crowds, crowds, st.integers(0, 10**6))
def test_among_thinned_particles_only_those_that_have_moved_need_a_search(points, more, seed):
    strength = np.random.default_rng(seed).integers(0, 4, len(points) + len(more)).astype(float)
    rest = deletion(points, strength[: len(points)], SHAPE, 2.0)
    every = np.concatenate([points[rest], more])
    strength = np.concatenate([strength[: len(points)][rest], strength[len(points) :]])
    has_moved = np.arange(len(every)) >= rest.sum()
    contact = replace(
        edge_contact(every, even_scale_field(SHAPE, (0.0, 0.0)), search_range(Parameters())), strength=strength
    )
    truth = deletion(every, strength, SHAPE, 2.0)
    np.testing.assert_array_equal(thinned(contact, has_moved, 2.0), truth)


@pytest.mark.parametrize("distance", [0.25, 0.6, 0.99, 1.01])
def test_of_two_too_near_either_one_may_have_moved(distance):
    """It is enough that one of them has, whichever it is."""
    pair = np.array([(10.0, 10.0), (10.0, 10.0 + distance)])
    contact = replace(
        edge_contact(pair, even_scale_field(SHAPE, (0.0, 0.0)), search_range(Parameters())),
        strength=np.array([1.0, 2.0]),
    )
    for has_moved in ([True, False], [False, True], [True, True]):
        assert thinned(contact, np.array(has_moved), 2.0).tolist() == [distance > 1.0, True]


@pytest.mark.parametrize(
    ("lorentz", "strength", "on_edge"),
    [
        ((0.0, 0.1), 5.0, True),
        ((0.0, -1.0), 5.0, False),
        ((0.6, 0.8), 5.0, False),
        ((0.55, 0.74), 5.0, True),
        ((0.0, 0.1), 1.5, False),
        ((0.0, 0.1), 2.0, True),
    ],
    ids=str,
)
def test_edge_contact_needs_a_weak_force_and_an_edge_that_is_strong_enough(lorentz, strength, on_edge):
    scale_field = even_scale_field((20, 30), lorentz, strength=strength, floor=2.0)
    points = np.array([(3.2, 4.7), (10.0, 29.5), (-0.5, -0.5)])
    assert contact_at(points, scale_field)[1].tolist() == [on_edge] * 3
    assert edge_contact(points, scale_field, search_range(Parameters())).on_edge.tolist() == [on_edge] * 3


def test_edge_contact_follows_the_field_between_the_pixels(edge):
    points = np.random.default_rng(0).uniform(-0.5, 39.5, (2000, 2))
    force = np.hypot(*interpolate(edge.lorentz, points).T)
    strength = edge.strength(points)
    clear = (np.abs(force - 0.93) > 1e-5) & (np.abs(strength - edge.floor) > 1e-4)
    truth = (force < 0.93) & (strength >= edge.floor)
    assert 50 < truth.sum() < 1000
    np.testing.assert_array_equal(contact_at(points, edge)[1][clear], truth[clear])
    contact = edge_contact(points, edge, search_range(Parameters()))
    np.testing.assert_array_equal(contact.on_edge, contact_at(points, edge)[1])
    np.testing.assert_allclose(contact.strength, strength, rtol=1e-6, atol=1e-6 * edge.strongest)


def births_of(
    scale_field,
    points,
    d_max=3.0,
    on_edge=True,
    looking=True,
    ahead=True,
    present=True,
    thorough=True,
    turn=0,
    d_min=2.0,
    **parameters,
):
    """New particles of those at some points; all are on an edge, search and are present unless given otherwise."""
    points = np.array(points, dtype=float).reshape(-1, 2)
    asked = Parameters(d_min=d_min, d_max=max(d_max, 3.0), **parameters)
    masks = (on_edge, looking, ahead, present, thorough)
    contact_at, searching, searching_ahead, there, careful = (
        np.broadcast_to(np.asarray(mask, dtype=bool), len(points)).copy() for mask in masks
    )
    contact = replace(edge_contact(points, scale_field, search_range(asked)), on_edge=contact_at)
    return insertion(contact, Search(there, searching, careful, searching_ahead), scale_field, d_max, asked, turn)


def births_between(scale_field, points, d_max=3.0, on_edge=True, d_min=2.0):
    """New particles by the rule for pairs alone: no particle searches ahead."""
    return births_of(scale_field, points, d_max, on_edge, ahead=False, d_min=d_min)


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


@pytest.mark.parametrize("on_edge", [(True, False), (False, True), (False, False)], ids=str)
def test_a_pair_of_which_one_is_off_the_edge_gets_none(edge, on_edge):
    assert len(births_between(edge, [(15.0, EDGE), (18.0, EDGE)], on_edge=on_edge).position) == 0


def test_a_pair_around_another_particle_gets_none(edge):
    assert (
        len(
            births_between(edge, [(15.0, EDGE), (18.0, EDGE), (16.4, EDGE + 0.2)], on_edge=(True, True, False)).position
        )
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
def test_gaps_within_range_are_filled_and_no_others(edge, gaps, d_max):
    rows = 0.5 + np.cumsum([0.0, *gaps])
    births = births_between(edge, np.stack([rows, np.full(len(rows), EDGE)], axis=1), d_max=d_max)
    gaps = np.diff(rows)
    if np.abs(gaps - 2.0 - d_max).min() > 1e-9:
        truth = (rows[:-1] + 0.5 * gaps)[gaps <= 2.0 + d_max]
        np.testing.assert_allclose(np.sort(births.position[:, 0]), truth, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.0, 39.0), min_size=2, max_size=25, unique=True), st.floats(0.0, 3.0))
def test_new_particles_are_midway_between_parents_within_range_and_apart_from_all(edge, rows, d_max):
    points = np.stack([np.array(rows), np.full(len(rows), EDGE)], axis=1)
    births = births_between(edge, points, d_max=d_max)
    one, other = points[births.parent], points[births.other]
    np.testing.assert_allclose(births.position, 0.5 * (one + other), atol=1e-12)
    gaps = np.linalg.norm(one - other, axis=1)
    assert np.all((gaps > 2.0) & (gaps <= 2.0 + d_max))
    if len(births.position):
        assert apart(np.concatenate([points, births.position]))[len(points) :].min() >= 1.0


def grown(scale_field, start, rounds, d_min=2.0):
    """Particles after rounds of insertion from those at `start`, all of them on an edge and searching ahead."""
    points = np.array(start, dtype=float)
    for _ in range(rounds):
        points = np.concatenate([points, births_of(scale_field, points, d_max=0.0, d_min=d_min).position])
    return points


def test_insertion_continues_along_an_edge_in_both_directions(edge):
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
    scale_field = build_scale_field(scene.values, 1.0, 0.0)
    start = np.array([(27.4 + 19.0 * np.sin(angle), 30.2 + 19.0 * np.cos(angle))])
    points = grown(scale_field, start, 60)
    assert scene.distance(points).max() < 1.0
    assert np.linalg.norm(scene.boundary[:, None] - points, axis=2).min(axis=1).max() < 2.0
    again = grown(scale_field, points, 1)
    assert len(again) == len(points)


def test_no_particle_is_inserted_on_an_edge_below_the_floor():
    """Two upright edges: beside one of full contrast, one of 5 percent counts as none."""
    image = upright()
    image[:, 40:] += 5.0
    scale_field = build_scale_field(image, 1.0, 0.0)
    assert len(grown(scale_field, [(20.0, 39.5)], 3)) == 1


def test_a_front_stops_where_the_edge_fades():
    contrast = np.interp(np.arange(40.0), [15.0, 22.0], [100.0, 0.0])
    scale_field = build_scale_field(upright(contrast), 1.0, 0.0)
    points = grown(scale_field, [(6.0, EDGE)], 40)
    at = points[points[:, 0] > 3.0]
    assert at[:, 0].max() > 14.0
    assert not np.any((np.abs(points[:, 1] - EDGE) < 4.0) & (points[:, 0] > 26.0))


@pytest.mark.parametrize("missing", ["on_edge", "looking", "ahead", "present"])
def test_no_particle_searches_ahead_unless_selected(edge, missing):
    assert len(births_of(edge, [(20.0, EDGE)]).position) > 1
    assert len(births_of(edge, [(20.0, EDGE)], **{missing: False}).position) == 0


@pytest.mark.parametrize("looking", [(True, False), (False, True), (True, True)], ids=str)
def test_one_of_a_pair_that_searches_is_enough_and_two_make_no_second(edge, looking):
    births = births_of(edge, [(15.0, EDGE), (18.6, EDGE)], looking=looking, ahead=False)
    np.testing.assert_allclose(births.position, [(16.8, EDGE)], atol=1e-12)
    assert sorted([*births.parent, *births.other]) == [0, 1]


def test_a_pair_that_does_not_search_gets_no_particle(edge):
    assert len(births_of(edge, [(15.0, EDGE), (18.6, EDGE)], looking=False).position) == 0


def test_a_deleted_particle_is_no_parent_and_blocks_no_position(edge):
    points = [(15.0, EDGE), (16.9, EDGE), (18.6, EDGE)]
    assert len(births_of(edge, points, ahead=False).position) == 0
    births = births_of(edge, points, ahead=False, present=(True, False, True))
    np.testing.assert_allclose(births.position, [(16.8, EDGE)], atol=1e-12)
    assert len(births_of(edge, points, ahead=False, present=(True, False, False)).position) == 0


def test_no_particle_is_inserted_across_a_barrier():
    """Neither between two on both sides of it, nor ahead."""
    scale_field = build_scale_field(upright(), 1.0, 0.0, Regions(barriers=(((20.2, 0.0), (20.2, 47.0)),)))
    assert len(births_of(scale_field, [(19.0, EDGE), (22.0, EDGE)], ahead=False).position) == 0
    assert len(births_of(scale_field, [(15.0, EDGE), (18.0, EDGE)], ahead=False).position) == 1
    points = grown(scale_field, [(12.0, EDGE)], 40)
    assert points[:, 0].max() < 20.2
    assert points[:, 0].max() > 17.0


@pytest.fixture(scope="module")
def curved():
    return build_scale_field(ring((60, 64), (29.4, 31.2), 14.0, 22.0).values, 1.0, 0.0)


def on_the_ring(seed, count=120):
    """Particles on and beside the rims of the ring, with gaps and crowds, thinned as in a step."""
    rng = np.random.default_rng(seed)
    angle, radius = rng.uniform(0.0, 6.0, count), rng.choice([14.0, 22.0], count) + rng.normal(0.0, 0.3, count)
    points = np.stack([29.4 + radius * np.sin(angle), 31.2 + radius * np.cos(angle)], axis=1)
    return points[deletion(points, np.zeros(count), (60, 64), 2.0)]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(5, 150), st.floats(0.0, 6.0))
def test_new_particles_keep_their_distance_from_all_and_from_each_other(curved, seed, count, d_max):
    """Half the distance of two parents, or 0.8 d_min ahead of one; and no more than three are within 1.5 d_min."""
    points = on_the_ring(seed, count)
    births = births_of(curved, points, d_max=d_max)
    there = points
    for place, one, other in zip(births.position, births.parent, births.other, strict=True):
        room = 1.6 if one == other else 0.5 * np.linalg.norm(points[one] - points[other]) - 2e-9
        distance = np.linalg.norm(there - place, axis=1)
        assert distance.min() >= room
        assert (distance < 3.0).sum() <= 3
        assert curved.strength(place[None])[0] >= curved.floor * (1.0 - 1e-6)
        there = np.concatenate([there, place[None]])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_places_ahead_are_at_rest_on_the_edge_one_stride_off(curved, seed):
    points = on_the_ring(seed, 12)
    births = births_of(curved, points, d_max=0.0)
    assert np.all(births.parent == births.other)
    force = np.hypot(*interpolate(curved.lorentz, births.position).T)
    assert np.all(force < 0.2 + 1e-6)
    stride = np.linalg.norm(births.position - points[births.parent], axis=1)
    assert np.all((stride >= 1.6) & (stride < 2.8))


def test_no_third_row_is_born_beside_two_on_one_edge(edge):
    """A gap in a row with another row beside it is left alone where more than three are around."""
    row = np.arange(6.0, 34.0, 1.2)
    beside = np.concatenate([np.stack([row, np.full(len(row), EDGE + off)], axis=1) for off in (-0.6, 0.6)])
    births = births_of(edge, beside, d_max=1.5)
    assert not np.any((births.position[:, 0] > row[0]) & (births.position[:, 0] < row[-1]))


@pytest.mark.parametrize(("d_min", "d_max"), [(0.5, 10.0), (0.5, 50.0), (1.0, 10.0), (4.0, 20.0)])
def test_a_gap_is_filled_however_many_particles_are_within_the_range(edge, d_min, d_max):
    rows = np.arange(1.0, 38.0, 1.01 * d_min)
    rows = rows[(rows < 17.0) | (rows > 21.0)]
    gap = rows[rows < 17.0].max(), rows[rows > 21.0].min()
    births = births_of(edge, np.stack([rows, np.full(len(rows), EDGE)], axis=1), d_max, ahead=False, d_min=d_min)
    middle = births.position[(births.position[:, 0] > gap[0]) & (births.position[:, 0] < gap[1])]
    np.testing.assert_allclose(middle, [(0.5 * sum(gap), EDGE)], atol=1e-9)


@pytest.mark.parametrize(("d_min", "d_max"), [(2.0, 3.0), (0.5, 0.0), (5.0, 0.0), (1.0, 30.0)])
def test_cells_reach_as_far_as_a_step_searches(d_min, d_max):
    """To the other one of a pair, and from the position of a new particle to all around it."""
    parameters = Parameters(d_min=d_min, d_max=d_max)
    reach = search_range(parameters)
    assert reach >= d_min + d_max
    assert reach >= 0.5 * (d_min + d_max) + 1.5 * d_min
    assert reach >= (0.9 + 1.5) * d_min
    assert (
        edge_contact(np.zeros((1, 2)), even_scale_field(SHAPE, (0.0, 0.0)), search_range(parameters)).cells.size
        >= reach
    )


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(3.01, 8.0), min_size=1, max_size=5), st.integers(0, 10**6))
def test_the_order_of_the_particles_does_not_matter_without_conflicts(edge, gaps, seed):
    """Midpoints less than 3 px apart count as near each other, so that the first may exclude the other."""
    rows = 0.5 + np.cumsum([0.0, *gaps])
    points = np.stack([rows, np.full(len(rows), EDGE)], axis=1)
    order = np.random.default_rng(seed).permutation(len(points))
    one, other = births_between(edge, points), births_between(edge, points[order])
    np.testing.assert_allclose(np.sort(other.position[:, 0]), np.sort(one.position[:, 0]), rtol=0, atol=1e-12)
    pairs = {frozenset(p) for p in zip(one.parent.tolist(), one.other.tolist(), strict=True)}
    assert pairs == {frozenset((int(order[i]), int(order[j]))) for i, j in zip(other.parent, other.other, strict=True)}


def test_births_and_deletions_are_the_same_bits_at_every_call_and_on_any_number_of_cores(monkeypatch):
    scene = ring((400, 400), (199.3, 201.2), 130.0, 180.0)
    scale_field = build_scale_field(scene.values, 1.0, 0.0)
    points = scene.boundary + np.random.default_rng(0).normal(0.0, 0.4, scene.boundary.shape)
    points = np.concatenate([points, points[:400] + 0.1])
    assert len(points) > 1500
    found = []
    for cores in (1, 2, 3, 3):
        monkeypatch.setattr(parallel, "cores", lambda cores=cores: cores)
        contact = edge_contact(points, scale_field, search_range(Parameters()))
        kept = thinned(contact, np.ones(len(points), bool), 2.0)
        births = births_of(scale_field, points, present=kept)
        arrays = (contact.strength, contact.on_edge, kept, births.position, births.parent, births.other)
        found.append([array.tobytes() for array in arrays])
    assert len(births.position) > 0
    assert found[0] == found[1] == found[2] == found[3]


def parents(count=6, first=10):
    rng = np.random.default_rng(0)
    position, velocity = rng.normal(size=(2, count, 2))
    return Particles(
        position, velocity, rng.normal(size=(count, 2, 2)), rng.normal(size=(count, 4)), np.arange(first, first + count)
    )


def test_new_particles_inherit_the_mean_motion_of_their_parents():
    old = parents()
    one, other = np.array([0, 2, 5]), np.array([1, 2, 3])
    place = np.array([(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)])
    after = old.joined_by(place, one, other, 40)
    assert len(after) == 9
    np.testing.assert_array_equal(after.position[6:], place)
    for n, (i, j) in enumerate(zip(one, other, strict=True)):
        np.testing.assert_allclose(after.velocity[6 + n], (old.velocity[i] + old.velocity[j]) / 2.0)
        np.testing.assert_allclose(after.force[6 + n], (old.force[i] + old.force[j]) / 2.0)
    assert np.isnan(after.distance[6:]).all()
    for name in ("position", "velocity", "force", "distance", "identity"):
        np.testing.assert_array_equal(getattr(after, name)[:6], getattr(old, name))


def test_identities_are_numbered_on_and_go_with_their_particles():
    after = parents().joined_by(np.zeros((3, 2)), np.array([0, 0, 1]), np.array([1, 2, 2]), 40)
    assert after.identity.tolist() == [10, 11, 12, 13, 14, 15, 40, 41, 42]
    kept = np.array([True, False] * 4 + [True])
    left = after.where(kept)
    assert left.identity.tolist() == [10, 12, 14, 40, 42]
    np.testing.assert_array_equal(left.position, after.position[kept])
    np.testing.assert_array_equal(left.velocity, after.velocity[kept])
    np.testing.assert_array_equal(left.force, after.force[kept])
    np.testing.assert_array_equal(left.distance, after.distance[kept])


def test_particles_taken_in_another_order_keep_all_that_is_theirs():
    old = parents()
    order = np.array([3, 0, 5])
    after = old.taken(order)
    for name in ("position", "velocity", "force", "distance", "identity"):
        np.testing.assert_array_equal(getattr(after, name), getattr(old, name)[order])


def test_the_young_are_those_whose_history_is_not_full():
    old = parents()
    old.distance[2, -1] = np.nan
    old.distance[4, 1:] = np.nan
    assert old.young.tolist() == [False, False, True, False, True, False]
    assert Particles.at_rest(np.zeros((3, 2))).young.all()


def test_particles_at_rest_have_no_motion_and_a_copy_of_their_places():
    place = np.array([(1.0, 2.0), (3.0, 4.0)])
    rest = Particles.at_rest(place, 5)
    place[:] = 0.0
    assert rest.position.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert not rest.velocity.any()
    assert not rest.force.any()
    assert rest.identity.tolist() == [5, 6]


def test_a_flanked_particle_searches_only_if_thorough(edge):
    chain = [(15.0, EDGE), (18.0, EDGE), (21.0, EDGE)]
    middle = (False, True, False)
    assert len(births_of(edge, chain, looking=middle, thorough=False).position) == 0
    assert len(births_of(edge, chain, looking=middle, thorough=True).position) == 2
    # and with an open side it looks in any case
    assert len(births_of(edge, chain[:2], looking=middle[:2], thorough=False).position) == 2


def test_directions_that_are_not_along_the_edge_take_turns():
    """Where there is room everywhere but along the edge, which others have taken: across it and diagonally in turn."""
    scale_field = even_scale_field(SHAPE, (0.0, 0.0), (1.0, 0.0), 1.0, 0.5)
    points = [(20.0, 20.0), (20.0, 23.0), (20.0, 17.0)]
    for turn in range(8):
        births = births_of(scale_field, points, d_max=0.0, looking=(True, False, False), turn=turn)
        places = births.position - 20.0
        np.testing.assert_allclose(np.linalg.norm(places, axis=1), 1.8)
        angles = np.degrees(np.arctan2(places[:, 0], places[:, 1])) % 180.0
        np.testing.assert_allclose(angles, [[], [45.0] * 2, [90.0] * 2, [135.0] * 2][turn % 4])
