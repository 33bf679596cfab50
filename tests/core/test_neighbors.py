"""Neighbours by cells, against looking at every pair."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.neighbors import block, build_cells, count_near, nearest_spacing, sort_in

RINGS = 8
EXTENT = np.array([60, 45])


def every_index(points):
    return np.arange(len(points))


def brute_spacing(points, targets, size):
    """Mean of the two least distances, none counted as more than eight cells."""
    out = []
    for i in targets:
        apart = [np.linalg.norm(points[i] - p) for j, p in enumerate(points) if j != i]
        nearest = sorted([*apart, np.inf, np.inf])[:2]
        out.append(0.5 * sum(min(d, RINGS * size) for d in nearest))
    return np.array(out)


inside = st.tuples(st.integers(-4, 59 * 8 + 4), st.integers(-4, 44 * 8 + 4)).map(lambda p: (p[0] / 8.0, p[1] / 8.0))
spread = st.lists(inside, min_size=1, max_size=40)
clustered = st.tuples(inside, st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=12)).map(
    lambda c: [(c[0][0] + y, c[0][1] + x) for y, x in c[1]]
)
clouds = st.one_of(spread, clustered, st.tuples(spread, clustered).map(lambda c: c[0] + c[1])).map(
    lambda points: np.array(points, dtype=float)
)


@settings(max_examples=80, deadline=None)
@given(clouds, st.sampled_from([0.7, 2.0, 5.0, 13.0]))
def test_spacing_is_the_mean_distance_of_the_two_nearest(points, size):
    truth = brute_spacing(points, every_index(points), size)
    found = nearest_spacing(points, every_index(points), EXTENT, size)
    np.testing.assert_allclose(found, truth, rtol=1e-12, atol=1e-12)


def test_spacing_of_targets_is_that_part_of_the_spacing_of_all():
    points = np.random.default_rng(0).uniform(0, 40, (200, 2))
    targets = np.array([5, 199, 0, 5, 77])
    whole = nearest_spacing(points, every_index(points), EXTENT, 3.0)
    np.testing.assert_array_equal(nearest_spacing(points, targets, EXTENT, 3.0), whole[targets])


def test_the_lonely_count_as_eight_cells_from_anybody():
    one = np.array([(10.0, 10.0)])
    np.testing.assert_allclose(nearest_spacing(one, np.array([0]), EXTENT, 2.5), [20.0])
    two = np.array([(10.0, 10.0), (10.0, 13.0)])
    np.testing.assert_allclose(nearest_spacing(two, np.array([0, 1]), EXTENT, 2.5), [0.5 * (3.0 + 20.0)] * 2)
    far = np.array([(2.0, 2.0), (50.0, 40.0)])
    np.testing.assert_allclose(nearest_spacing(far, np.array([0, 1]), EXTENT, 2.5), [20.0, 20.0])


def test_particles_on_one_spot_have_no_spacing():
    np.testing.assert_array_equal(nearest_spacing(np.full((3, 2), 8.5), np.arange(3), EXTENT, 2.0), 0.0)


def test_nobody_has_a_spacing_in_an_empty_image():
    assert nearest_spacing(np.zeros((0, 2)), np.zeros(0, np.int64), EXTENT, 2.0).shape == (0,)


@settings(max_examples=60, deadline=None)
@given(clouds, st.sampled_from([1.0, 2.0, 6.0]), st.floats(0.05, 0.99), st.floats(0.0, 6.28), st.integers(0, 60))
def test_as_many_are_near_as_are_nearer_than_the_radius(points, size, fraction, angle, which):
    """At a radius that just includes or just excludes one of them, in whatever direction that one lies."""
    distance = fraction * size
    place = points[which % len(points)] + distance * np.array([np.sin(angle), np.cos(angle)])
    cells = build_cells(points, len(points), EXTENT, size)
    for radius in (distance * (1.0 - 1e-6), distance * (1.0 + 1e-6)):
        truth = int((((points - place) ** 2).sum(axis=1) < radius**2).sum())
        assert count_near(cells, place, radius) == truth


def chains(cells):
    """Particles in the chain of each cell, by the index of the cell along each axis."""
    found = {}
    for cell, first in enumerate(cells.head):
        chain, j = [], int(first)
        while j >= 0:
            chain.append(j)
            j = int(cells.following[j])
        found[np.unravel_index(cell, tuple(cells.along))] = chain
    return found


@settings(max_examples=30, deadline=None)
@given(clouds, st.sampled_from([1.0, 3.0]), st.integers(0, 40))
def test_every_particle_is_in_the_chain_of_its_cell_and_no_other(points, size, count):
    """Those sorted in at once and those added one by one alike; particles not yet sorted in are in none."""
    count = min(count, len(points))
    cells = build_cells(points, count, EXTENT, size)
    assert sorted(itertools.chain.from_iterable(chains(cells).values())) == list(range(count))
    for i in range(count, len(points)):
        sort_in(cells, i)
    found = chains(cells)
    assert sorted(itertools.chain.from_iterable(found.values())) == list(range(len(points)))
    for cell, chain in found.items():
        for i in chain:
            own = np.clip(np.floor(points[i] / size + 0.5), 0, cells.along - 1)
            assert tuple(own.astype(int)) == tuple(map(int, cell))


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("reach", [1, 2, 3])
def test_block_holds_the_cells_around_a_place_and_ends_at_the_border(dimension, reach):
    extent = np.array([3, 5, 2][:dimension])
    cells = build_cells(np.zeros((0, dimension)), 0, extent, 1.0)
    assert np.all(cells.along > extent)
    for own in itertools.product(*(range(n) for n in cells.along)):
        point = np.array(own, dtype=float)
        out = np.empty((2 * reach + 1) ** dimension, np.int64)
        count = block(cells, point, reach, out)
        ranges = [range(max(o - reach, 0), min(o + reach, n - 1) + 1) for o, n in zip(own, cells.along, strict=True)]
        truth = [np.ravel_multi_index(cell, tuple(cells.along)) for cell in itertools.product(*ranges)]
        assert sorted(out[:count]) == sorted(truth)
