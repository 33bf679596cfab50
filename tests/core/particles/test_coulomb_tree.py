"""The fast sums of eq. (9): their error against the sum over all pairs, for particles that lie in all sorts of ways."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import coulomb_force


def sum_of_all_pairs(points, some):
    """Eq. (9) for some particles, on distances that are divided by the largest one, times its square."""
    difference = points[some, None] - points[None]
    extent = np.ptp(points, axis=0).max() or 1.0
    difference = difference / extent
    distance = np.hypot(difference[..., 0], difference[..., 1])
    distance[distance == 0.0] = np.inf
    return (difference / distance[..., None] ** 3).sum(axis=1), extent


def relative_error(points, force, seed=0):
    """Root of the sum of the squared errors of some hundred particles over that of their forces."""
    some = np.random.default_rng(seed).choice(len(points), min(len(points), 150), replace=False)
    exact, extent = sum_of_all_pairs(points, some)
    size = np.abs(exact).max() or 1.0
    return np.linalg.norm((force[some] * extent * extent - exact) / size) / (np.linalg.norm(exact / size) or 1.0)


def ring(count, radius=1.0):
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)


def rings(count, rng, noise=0.1):
    """Particles 1.5 px apart along circles that cross."""
    centers = 140.0 * np.stack(np.divmod(np.arange(count // 400), 5), axis=1)
    points = (centers[:, None] + ring(400, 600.0 / (2.0 * np.pi))[None]).reshape(-1, 2)
    return points + rng.normal(0.0, noise, points.shape)


def scenes():
    rng = np.random.default_rng(7)
    grid = np.stack(np.mgrid[:60, :60], axis=-1).reshape(-1, 2).astype(float)
    line = np.stack([np.arange(4000) * 1.5, np.arange(4000) * 0.5], axis=1)
    cluster = rng.normal(0.0, 1.0, (3000, 2))
    angle = rng.uniform(0.0, 7.0, 4000)
    return {
        "curves": rings(6000, rng),
        "cloud": rng.uniform(0.0, 500.0, (5000, 2)),
        "grid": grid,
        "grid far away": grid + 1e8,
        "ring": ring(6000, 500.0),
        "rings in rings": np.concatenate([ring(1500, radius) for radius in (100.0, 200.0, 300.0)]),
        "line": line,
        "column": line * (1.0, 0.0),
        "row": line * (0.0, 1.0),
        "clusters": rng.uniform(0.0, 1000.0, (20, 2))[rng.integers(0, 20, 4000)] + rng.normal(0.0, 0.5, (4000, 2)),
        "cluster with outliers": np.concatenate([cluster, rng.uniform(-1e6, 1e6, (80, 2))]),
        "some spots": np.round(rng.uniform(0.0, 40.0, (4000, 2))),
        "two spots": np.array([(0.0, 0.0), (3.0, 4.0)])[rng.integers(0, 2, 3000)],
        "many twins": np.repeat(rng.uniform(0.0, 500.0, (2000, 2)), 2, axis=0),
        "near twins": np.repeat(rng.uniform(0.0, 500.0, (2000, 2)), 2, axis=0) + rng.normal(0.0, 1e-9, (4000, 2)),
        "all scales": np.exp(rng.uniform(-25.0, 5.0, 4000))[:, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1),
        "one scale in another": np.concatenate([rng.normal(0.0, 1e-14, (1500, 2)), rng.normal(0.0, 1.0, (1500, 2))]),
        "huge": rings(4000, rng) * 1e120,
        "tiny": rings(4000, rng) * 1e-120,
    }


SCENES = scenes()


@pytest.mark.parametrize("name", SCENES)
def test_error_is_within_the_tolerance_however_the_particles_lie(name):
    assert relative_error(SCENES[name], coulomb_force(SCENES[name], "tree")) <= 1e-3
    assert relative_error(SCENES[name], coulomb_force(SCENES[name])) <= 1e-3


@pytest.mark.parametrize("tolerance", [0.1, 1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("name", ["curves", "cloud", "ring", "rings in rings", "grid", "line", "clusters"])
def test_error_is_within_any_tolerance(name, tolerance):
    for method in ("tree", "auto"):
        assert relative_error(SCENES[name], coulomb_force(SCENES[name], method, tolerance=tolerance)) <= tolerance


def test_a_smaller_tolerance_gives_a_smaller_error():
    errors = [
        relative_error(SCENES["curves"], coulomb_force(SCENES["curves"], "tree", tolerance=10.0**-k))
        for k in (1, 3, 5, 7)
    ]
    assert all(later < earlier / 10.0 for earlier, later in itertools.pairwise(errors))


coordinate = st.one_of(
    st.integers(0, 40).map(float), st.floats(-1000.0, 1000.0, width=32), st.floats(-0.25, 0.25, width=32)
)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=30), st.integers(1, 40), st.integers(0, 2**32 - 1)
)
def test_error_is_within_the_tolerance_around_any_spots(spots, copies, seed):
    """Up to 1200 particles: a number of them around each of the spots."""
    points = np.repeat(np.array(spots), copies, axis=0)
    points = points + np.random.default_rng(seed).normal(0.0, 0.3, points.shape)
    assert relative_error(points, coulomb_force(points, "tree"), seed) <= 1e-3


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 130), st.integers(0, 2**32 - 1), st.booleans())
def test_few_particles_are_summed_like_many(count, seed, whole):
    points = np.random.default_rng(seed).uniform(0.0, 20.0, (count, 2))
    points = np.round(points) if whole else points
    force = coulomb_force(points, "tree")
    assert force.shape == (count, 2)
    assert not count or relative_error(points, force) <= 1e-3


def test_particles_on_one_spot_do_not_act_on_each_other_however_many():
    assert not coulomb_force(np.full((5000, 2), 7.3), "tree").any()
    assert not coulomb_force(np.full((40, 2), 7.3), "tree").any()


def test_pairs_at_one_position_have_twice_the_force_of_single_particles():
    points = SCENES["cloud"]
    found = coulomb_force(np.concatenate([points, points]), "tree")
    exact = 2.0 * coulomb_force(points, "exact")
    for half in (found[: len(points)], found[len(points) :]):
        assert np.linalg.norm(half - exact) <= 1e-3 * np.linalg.norm(exact)


@pytest.mark.parametrize("count", [2, 150, 301, 900, 1499, 1500, 1501, 4000])
def test_the_choice_is_one_of_the_methods(count):
    points = rings(4000, np.random.default_rng(3))[:count]
    chosen = coulomb_force(points)
    ways = [coulomb_force(points, method).tobytes() for method in ("exact", "single", "tree")]
    assert chosen.tobytes() in ways
    expected = coulomb_force(points, "exact")
    assert np.linalg.norm(chosen - expected) <= 1e-3 * np.linalg.norm(expected)


def test_single_precision_is_not_chosen_where_it_is_not_enough():
    """On a ring the pushes from both sides cancel; with so small a tolerance nothing but double precision is right."""
    points = ring(1000, 300.0)
    assert coulomb_force(points, tolerance=1e-8).tobytes() == coulomb_force(points, "exact").tobytes()
    assert coulomb_force(points, "single").tobytes() != coulomb_force(points, "exact").tobytes()


def test_few_targets_among_many_particles_are_summed_exactly():
    points = SCENES["curves"]
    targets = np.arange(0, len(points), 40)
    chosen = coulomb_force(points, targets=targets)
    assert chosen.tobytes() == coulomb_force(points, "exact", targets=targets).tobytes()


def test_force_on_many_targets_is_that_part_of_the_force_on_all():
    points = SCENES["cloud"]
    targets = np.random.default_rng(1).permutation(len(points))[:2000]
    assert coulomb_force(points, targets=targets).tobytes() == coulomb_force(points)[targets].tobytes()
    near = np.flatnonzero(np.linalg.norm(points - 100.0, axis=1) < 80.0)
    assert coulomb_force(points, "tree", targets=near).tobytes() == coulomb_force(points, "tree")[near].tobytes()


def test_positions_are_left_as_they_are():
    points = SCENES["cloud"].copy()
    coulomb_force(points, "tree")
    np.testing.assert_array_equal(points, SCENES["cloud"])
    turned = np.asfortranarray(points)
    assert coulomb_force(turned, "tree").tobytes() == coulomb_force(points, "tree").tobytes()
