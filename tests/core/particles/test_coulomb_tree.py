"""The fast sums of eq. (9): their error against the sum over all pairs, for particles that lie in all sorts of ways."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import coulomb_force
from cpm_core.numerics import parallel
from tests.core.particles.crowds import PLANE, SPACE, even_sphere, relative_error, rings

SCENES = {f"{name}, plane": points for name, points in PLANE.items()}
SCENES |= {f"{name}, space": points for name, points in SPACE.items()}
_HARD = ["curves", "cloud", "ring", "rings in rings", "grid", "line", "clusters"]
_HARD_IN_SPACE = ["sphere", "torus", "grid", "cloud", "line", "shell"]


@pytest.mark.parametrize("name", SCENES)
def test_error_is_within_the_tolerance_however_the_particles_lie(name):
    assert relative_error(SCENES[name], coulomb_force(SCENES[name], "tree")) <= 1e-3
    assert relative_error(SCENES[name], coulomb_force(SCENES[name])) <= 1e-3


@pytest.mark.parametrize("tolerance", [0.1, 1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("name", _HARD)
def test_error_is_within_any_tolerance(name, tolerance):
    for method in ("tree", "auto"):
        assert relative_error(PLANE[name], coulomb_force(PLANE[name], method, tolerance=tolerance)) <= tolerance


@pytest.mark.parametrize("tolerance", [0.1, 1e-2, 1e-4, 1e-7])
@pytest.mark.parametrize("name", _HARD_IN_SPACE)
def test_error_is_within_any_tolerance_in_space(name, tolerance):
    assert relative_error(SPACE[name], coulomb_force(SPACE[name], "tree", tolerance=tolerance)) <= tolerance


def test_a_smaller_tolerance_gives_a_smaller_error():
    errors = [
        relative_error(PLANE["curves"], coulomb_force(PLANE["curves"], "tree", tolerance=10.0**-k))
        for k in (1, 3, 5, 7)
    ]
    assert all(later < earlier / 10.0 for earlier, later in itertools.pairwise(errors))


coordinate = st.one_of(
    st.integers(0, 40).map(float), st.floats(-1000.0, 1000.0, width=32), st.floats(-0.25, 0.25, width=32)
)


@pytest.mark.parametrize("dimensions", [2, 3])
@settings(max_examples=40, deadline=None)
@given(data=st.data(), copies=st.integers(1, 40), seed=st.integers(0, 2**32 - 1))
def test_error_is_within_the_tolerance_around_any_spots(dimensions, data, copies, seed):
    """Up to 1200 particles: a number of them around each of the spots."""
    spots = data.draw(st.lists(st.tuples(*[coordinate] * dimensions), min_size=1, max_size=30))
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


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("count", [40, 5000])
def test_particles_on_one_spot_do_not_act_on_each_other_however_many(count, dimensions):
    assert not coulomb_force(np.full((count, dimensions), 7.3), "tree").any()


def test_pairs_at_one_position_have_twice_the_force_of_single_particles():
    points = PLANE["cloud"]
    found = coulomb_force(np.concatenate([points, points]), "tree")
    exact = 2.0 * coulomb_force(points, "exact")
    for half in (found[: len(points)], found[len(points) :]):
        assert np.linalg.norm(half - exact) <= 1e-3 * np.linalg.norm(exact)


@pytest.mark.parametrize("count", [2, 150, 301, 900, 1499, 1500, 1501, 4000])
def test_the_choice_is_one_of_the_methods(count):
    points = rings(4000, np.random.default_rng(3))[:count]
    chosen = coulomb_force(points)
    ways = [coulomb_force(points, method).tobytes() for method in ("exact", "tree")]
    assert chosen.tobytes() in ways
    expected = coulomb_force(points, "exact")
    assert np.linalg.norm(chosen - expected) <= 1e-3 * np.linalg.norm(expected)


def test_few_targets_among_many_particles_are_summed_exactly():
    points = PLANE["curves"]
    targets = np.arange(0, len(points), 40)
    chosen = coulomb_force(points, targets=targets)
    assert chosen.tobytes() == coulomb_force(points, "exact", targets=targets).tobytes()


def test_force_on_many_targets_is_that_part_of_the_force_on_all():
    points = PLANE["cloud"]
    targets = np.random.default_rng(1).permutation(len(points))[:2000]
    assert coulomb_force(points, targets=targets).tobytes() == coulomb_force(points)[targets].tobytes()
    near = np.flatnonzero(np.linalg.norm(points - 100.0, axis=1) < 80.0)
    assert coulomb_force(points, "tree", targets=near).tobytes() == coulomb_force(points, "tree")[near].tobytes()


def test_positions_are_left_as_they_are():
    points = PLANE["cloud"].copy()
    coulomb_force(points, "tree")
    np.testing.assert_array_equal(points, PLANE["cloud"])
    turned = np.asfortranarray(points)
    assert coulomb_force(turned, "tree").tobytes() == coulomb_force(points, "tree").tobytes()


def test_a_large_crowd_is_summed_by_the_tree_and_a_small_one_exactly():
    crowd = even_sphere(6000)
    assert coulomb_force(crowd).tobytes() == coulomb_force(crowd, "tree").tobytes()
    assert coulomb_force(crowd).tobytes() != coulomb_force(crowd, "exact").tobytes()
    assert coulomb_force(crowd[:900]).tobytes() == coulomb_force(crowd[:900], "exact").tobytes()
    few = np.arange(0, 6000, 40)
    assert coulomb_force(crowd, targets=few).tobytes() == coulomb_force(crowd, "exact", targets=few).tobytes()


def test_force_on_some_in_space_is_that_part_of_the_force_on_all():
    """Bit for bit, in any order, and some of them twice."""
    targets = np.random.default_rng(2).integers(0, 4000, 37)
    whole = coulomb_force(SPACE["torus"], "tree")
    assert coulomb_force(SPACE["torus"], "tree", targets=targets).tobytes() == whole[targets].tobytes()


@pytest.mark.parametrize("count", [0, 1, 2, 64, 65, 3000])
def test_same_bits_whatever_the_number_of_threads(count, monkeypatch):
    points = SPACE["cloud"][:count]
    first = coulomb_force(points, "tree")
    for cores in (1, 3, 8):
        monkeypatch.setattr(parallel, "cores", lambda cores=cores: cores)
        assert coulomb_force(points, "tree").tobytes() == first.tobytes()


@pytest.mark.parametrize("method", ["auto", "exact", "tree"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_positions_that_are_no_numbers_are_refused(bad, method):
    points = SPACE["cloud"][:10].copy()
    points[3, 0] = bad
    with pytest.raises(ValueError, match="positions must be finite numbers"):
        coulomb_force(points, method)
