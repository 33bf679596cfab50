"""What moves, divides and thins out particles on surfaces in a volume, against looking at every pair."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import PRESETS
from cpm_core.field.volume_field import VolumeField, build_volume_field
from cpm_core.model.coverage import cover_surfaces, no_surface_coverage
from cpm_core.model.volume.births import find_surface_insertions, select_spaced, select_surface_survivors
from cpm_core.model.volume.motion import build_volume_cells, move_in_volume
from cpm_core.model.volume.state import VolumeParticles
from cpm_core.model.volume.step import _mark_near

from ..moving import cloud, crowds

SHAPE, SIZE = (20, 24, 15), (20.0, 24.0, 15.0)
EDGE = 6.8
"""Column of the upright edge."""

ROOM, STRIDE = 0.68, 0.9
"""Least distance of a new particle from others of its sheet, and its distance from the one behind it, in d_min."""

UP = np.array([0.0, 0.0, 1.0])
seeds, spacings = st.integers(0, 10**6), st.sampled_from([0.7, 1.75, 2.6])


def particles(points, normals, seated, strength):
    some = VolumeParticles.at_rest(points)
    return replace(some, normal=normals, on_surface=seated, strength=strength)


def crowd(seed):
    """Particles anywhere, some of them seated on surfaces that face anywhere."""
    points, rng = crowds(SHAPE, seed), np.random.default_rng(seed)
    normals = rng.normal(size=points.shape)
    seated = rng.uniform(size=len(points)) < 0.6
    return particles(points, normals, seated, rng.integers(0, 4, len(points)).astype(float))


def on_one_sheet(some):
    """Which pairs count as neighbors: all but those that are seated and face apart."""
    both = np.outer(some.on_surface, some.on_surface)
    return ~both | (some.normal @ some.normal.T > 0.0)


def distances(one, other):
    return np.linalg.norm(one[:, None] - other[None], axis=2)


def cells_for(points, side=4.0):
    return build_volume_cells(points, SIZE, side)


@settings(max_examples=16, deadline=None)
@given(seeds, spacings)
def test_of_two_particles_too_near_on_one_sheet_the_one_on_the_weaker_edge_goes(seed, d_min):
    some = crowd(seed)
    near = (distances(some.position, some.position) < 0.5 * d_min) & on_one_sheet(some)
    np.fill_diagonal(near, val=False)
    kept = select_surface_survivors(some, cells_for(some.position), np.arange(len(some)), d_min)
    truth = np.zeros(len(some), bool)
    for i in np.argsort(-some.strength, kind="stable"):
        truth[i] = not (near[i] & truth).any()
    np.testing.assert_array_equal(kept, truth)


def repulsion(some, i, d_min):
    """The normalized Coulomb force of near pairs, term by term."""
    away = some.position[i] - some.position
    distance = np.maximum(np.linalg.norm(away, axis=1), 0.01)
    near = (distance < 2.2 * d_min) & on_one_sheet(some)[i]
    near[i] = False
    if not near.any():
        return np.zeros(3)
    total = (away[near] / distance[near, None] ** 4).sum(axis=0)
    spacing = np.sort([*distance[near], 4.0 * d_min, 4.0 * d_min])[:2].mean()
    scale = 0.5 * spacing**3 * min(1.0, spacing / d_min)
    return total * scale / max(1.0, scale * np.linalg.norm(total))


@settings(max_examples=10, deadline=None)
@given(seeds, spacings)
def test_near_pairs_on_one_sheet_repel_each_other_and_no_others(seed, d_min):
    nothing = np.zeros(SHAPE, np.float32)
    field = VolumeField(nothing, nothing, (1.0, 1.0, 1.0), 0.0, 1.0, 1.0)
    some, law = crowd(seed), PRESETS["volume"]
    every = np.arange(len(some))
    law = type(law)(w1=law.w1, w2=law.w2, beta=law.beta, d_min=d_min, scales=1)
    cells = cells_for(some.position, max(2.2 * d_min, 4.0))
    force = move_in_volume(some, every, cells, np.zeros(len(some), np.int64), field, law)[0].force[:, 0]
    truth = np.array([repulsion(some, i, d_min) for i in every]).reshape(-1, 3)
    np.testing.assert_allclose(force, law.w1 * truth, atol=1e-9)


@settings(max_examples=16, deadline=None)
@given(seeds, st.floats(0.3, 6.0))
def test_of_places_too_near_on_one_sheet_the_first_stays(seed, room):
    some = crowd(seed)
    near = (distances(some.position, some.position) < room) & (some.normal @ some.normal.T > 0.0)
    truth = np.zeros(len(some), bool)
    for i in range(len(some)):
        truth[i] = not (near[i, :i] & truth[:i]).any()
    np.testing.assert_array_equal(select_spaced(some.position, some.normal, room), truth)


@settings(max_examples=12, deadline=None)
@given(seeds, st.floats(0.3, 6.0))
def test_new_ground_wakes_all_within_reach(seed, reach):
    points, places = crowds(SHAPE, seed), cloud(SHAPE, 4, seed + 1)
    woken = np.zeros(len(points), bool)
    _mark_near(cells_for(points), places, reach, woken)
    np.testing.assert_array_equal(woken, (distances(points, places) < reach).any(axis=1))


@settings(max_examples=12, deadline=None)
@given(seeds, spacings)
def test_a_cell_and_side_is_new_ground_once(seed, side):
    coverage, known = no_surface_coverage(side), set()
    for step in range(4):
        some = crowd(seed + step)
        coverage, fresh = cover_surfaces(coverage, some.position, some.normal)
        for place, normal, new in zip(some.position, some.normal, fresh, strict=True):
            cell = (*np.floor(place / side).astype(int).tolist(), bool(normal @ (1.0, 0.37, 0.21) > 0.0))
            assert new == (cell not in known)
            known.add(cell)
        assert coverage.size == len(known)


@pytest.fixture(scope="module")
def edge():
    """A step along the columns, at a known place between two of them."""
    share = np.clip(np.arange(SHAPE[2]) + 0.5 - EDGE, 0.0, 1.0)
    return build_volume_field(np.broadcast_to(100.0 * share, SHAPE).copy(), (1.0, 1.0, 1.0), 1.0, 0.1)


def seated(points, side=1.0):
    """Particles on the upright edge at some planes and rows, that face up or down the columns."""
    places = np.column_stack([np.reshape(points, (-1, 2)), np.full(len(points), EDGE)])
    return particles(
        places, np.tile(side * UP, (len(places), 1)), np.ones(len(places), bool), np.full(len(places), 9.0)
    )


def test_around_a_single_particle_there_are_six(edge):
    some = seated([[10.0, 12.0]])
    born = find_surface_insertions(some, cells_for(some.position), np.array([0]), edge, 2.0)
    assert len(born.position) == 6
    np.testing.assert_allclose(np.linalg.norm(born.position[:, :2] - (10.0, 12.0), axis=1), STRIDE * 2.0, atol=1e-6)
    np.testing.assert_allclose(born.position[:, 2], EDGE, atol=0.15)
    np.testing.assert_allclose(born.normal, np.tile(UP, (6, 1)), atol=1e-6)
    angles = np.sort(np.arctan2(*(born.position[:, :2] - (10.0, 12.0)).T))
    np.testing.assert_allclose(np.diff(angles), np.pi / 3.0, atol=1e-6)


@settings(max_examples=10, deadline=None)
@given(seed=seeds, d_min=st.sampled_from([1.2, 1.75, 2.6]))
def test_new_particles_lie_on_the_edge_a_stride_ahead_and_keep_their_room(edge, seed, d_min):
    rng = np.random.default_rng(seed)
    points = rng.uniform((0.0, 0.0), (19.0, 23.0), (rng.integers(1, 40), 2))
    some, turn = seated(points), np.flatnonzero(rng.uniform(size=len(points)) < 0.7)
    born = find_surface_insertions(some, cells_for(some.position), turn, edge, d_min).position
    from_all, among = distances(born, some.position), distances(born, born)
    np.fill_diagonal(among, np.inf)
    assert np.abs(born[:, 2] - EDGE).max(initial=0.0) < 0.15
    assert from_all.min(initial=np.inf) >= ROOM * d_min
    assert among.min(initial=np.inf) >= ROOM * d_min
    if len(born):
        ahead = from_all[:, turn]
        assert (np.abs(ahead - STRIDE * d_min).min(axis=1) < 0.05 * d_min).all()
        assert ((born >= 0.0) & (born <= np.array(SHAPE) - 1.0)).all()


def test_fronts_go_on_until_the_whole_edge_is_covered_and_no_denser(edge):
    points, d_min = np.array([[10.0, 12.0]]), 1.75
    for _ in range(40):
        some = seated(points)
        born = find_surface_insertions(some, cells_for(some.position), np.arange(len(some)), edge, d_min).position
        if not len(born):
            break
        points = np.concatenate([points, born[:, :2]])
    grid = np.array(list(product(np.arange(0.0, 19.1, 0.5), np.arange(0.0, 23.1, 0.5))))
    assert not len(born)
    assert distances(grid, points).min(axis=1).max() < 1.5 * d_min
    between = distances(points, points)
    np.fill_diagonal(between, np.inf)
    assert between.min() >= ROOM * d_min


def between(edge, points, d_max, d_min=2.0):
    """Particles born between others on an upright edge, each too surrounded to be one of a front."""
    some = seated(points)
    ahead = find_surface_insertions(some, cells_for(some.position), np.arange(len(some)), edge, d_min).position
    both = find_surface_insertions(some, cells_for(some.position), np.arange(len(some)), edge, d_min, d_max).position
    gap = distances(both, ahead).min(axis=1, initial=np.inf)
    return both[gap > 1e-6]


@settings(max_examples=10, deadline=None)
@given(seed=seeds, d_max=st.sampled_from([0.3, 1.0, 3.0]))
def test_those_between_halve_a_pair_that_no_other_one_of_the_sheet_is_inside_of(edge, seed, d_max):
    rng = np.random.default_rng(seed)
    points = rng.uniform((1.0, 1.0), (18.0, 22.0), (rng.integers(2, 60), 2))
    flat = seated(points).position
    some = seated(points)
    for place in find_surface_insertions(some, cells_for(flat), np.arange(len(flat)), edge, 2.0, d_max).position:
        away = np.linalg.norm(flat - place, axis=1)
        one, other = np.sort(away)[:2]
        halves = 1.9 < one + other < 2.1 + d_max and other - one < 0.05
        assert halves or np.abs(away - STRIDE * 2.0).min() < 0.1


def test_two_on_different_walls_get_none_between_them(edge):
    some, other = seated([[10.0, 12.0]]), seated([[10.0, 15.0]], side=-1.0)
    both = particles(
        np.concatenate([some.position, other.position]),
        np.concatenate([some.normal, other.normal]),
        np.ones(2, bool),
        np.full(2, 9.0),
    )
    born = find_surface_insertions(both, cells_for(both.position), np.arange(2), edge, 2.0, 3.0).position
    assert np.linalg.norm(born - (10.0, 13.5, EDGE), axis=1).min(initial=np.inf) > 0.1


def test_particles_of_the_other_wall_of_a_thin_object_take_no_room(edge):
    some = seated([[10.0, 12.0]])
    other = seated([[10.0, 12.9], [11.0, 12.0], [8.2, 11.0], [11.8, 13.0]], side=-1.0)
    both = particles(
        np.concatenate([some.position, other.position + 0.7 * UP]),
        np.concatenate([some.normal, other.normal]),
        np.ones(5, bool),
        np.full(5, 9.0),
    )
    alone = find_surface_insertions(some, cells_for(some.position), np.array([0]), edge, 2.0)
    beside = find_surface_insertions(both, cells_for(both.position), np.array([0]), edge, 2.0)
    np.testing.assert_array_equal(beside.position, alone.position)
