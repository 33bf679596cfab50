"""The Coulomb force of eq. (9), against two nested loops and the laws that any such force follows."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import coulomb_force
from cpm_core.model.coulomb import METHODS
from cpm_core.numerics import parallel


def naive(points):
    """Eq. (9) term by term, summed without rounding; and the sum of the terms' sizes."""
    force, size = np.zeros((len(points), 2)), np.zeros(len(points))
    for i, (y, x) in enumerate(points.tolist()):
        terms = []
        for j, (v, u) in enumerate(points.tolist()):
            distance = math.hypot(y - v, x - u)
            if i != j and distance > 0.0:
                terms.append(((y - v) / distance**3, (x - u) / distance**3))
        force[i] = math.fsum(t[0] for t in terms), math.fsum(t[1] for t in terms)
        size[i] = math.fsum(math.hypot(*t) for t in terms)
    return force, size


def crowd(count, seed=0, extent=300.0):
    return np.random.default_rng(seed).uniform(0.0, extent, (count, 2))


coordinate = st.integers(0, 64 * 200).map(lambda n: n / 64.0)
clouds = st.lists(st.tuples(coordinate, coordinate), min_size=0, max_size=24).map(
    lambda points: np.array(points, dtype=float).reshape(-1, 2)
)


def with_some_twice(points, data):
    """The points, and a few of them once more on the very same spots."""
    if not len(points):
        return points
    return np.concatenate([points, points[data.draw(st.lists(st.integers(0, len(points) - 1), max_size=4))]])


@settings(max_examples=60, deadline=None)
@given(clouds, st.data())
def test_force_is_the_sum_over_all_pairs(points, data):
    """To 1e-10 of the terms' sizes (seen: 4e-14), with any number of particles on the same spot."""
    points = with_some_twice(points, data)
    force, size = naive(points)
    assert np.all(np.linalg.norm(coulomb_force(points, "exact") - force, axis=1) <= 1e-10 * size)


def test_force_of_a_large_crowd_is_the_sum_over_all_pairs():
    points = crowd(700)
    force, _ = naive(points)
    error = np.linalg.norm(coulomb_force(points, "exact") - force, axis=1)
    assert np.all(error <= 1e-10 * np.linalg.norm(force, axis=1))


def test_two_particles_repel_with_the_inverse_square():
    force = coulomb_force([(10.0, 20.0), (13.0, 24.0)])
    np.testing.assert_allclose(force, [(-0.6 / 25.0, -0.8 / 25.0), (0.6 / 25.0, 0.8 / 25.0)], rtol=1e-14)


def test_particles_on_one_spot_do_not_act_on_each_other():
    assert not coulomb_force(np.full((5, 2), 7.25)).any()


@pytest.mark.parametrize("count", [1, 2, 50, 1500])
def test_forces_sum_to_zero(count):
    force = coulomb_force(crowd(count), "exact")
    assert np.all(np.abs(force.sum(axis=0)) <= 1e-12 * max(np.abs(force).sum(), 1e-300))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("count", [0, 1, 2, 301, 3000])
def test_same_bits_whatever_the_number_of_threads(count, method, monkeypatch):
    points = crowd(count)
    first = coulomb_force(points, method)
    for cores in (1, 2, 3, 8):
        monkeypatch.setattr(parallel, "cores", lambda cores=cores: cores)
        assert coulomb_force(points, method).tobytes() == first.tobytes()


@pytest.mark.parametrize("method", ["exact", "tree"])
@pytest.mark.parametrize("count", [100, 700, 3000])
def test_force_on_some_is_that_part_of_the_force_on_all(count, method):
    """Bit for bit, in any order, and some of them twice."""
    points = crowd(count, seed=1)
    targets = np.random.default_rng(2).integers(0, count, 37)
    some = coulomb_force(points, method, targets=targets)
    assert some.tobytes() == coulomb_force(points, method)[targets].tobytes()
    assert coulomb_force(points, method, targets=targets[:0]).shape == (0, 2)


def test_force_turns_with_the_particles_and_does_not_mind_where_they_are():
    points = crowd(80)
    angle = 0.7
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    force = coulomb_force(points)
    largest = np.abs(force).max()
    np.testing.assert_allclose(coulomb_force(points @ turn.T), force @ turn.T, rtol=0, atol=1e-10 * largest)
    np.testing.assert_allclose(coulomb_force(points + np.array([512.0, -64.0])), force, rtol=0, atol=1e-10 * largest)


def test_force_falls_with_the_square_of_the_scale():
    points = crowd(40)
    np.testing.assert_allclose(coulomb_force(4.0 * points), coulomb_force(points) / 16.0, rtol=1e-11)


@pytest.mark.parametrize("method", ["exact", "tree"])
@pytest.mark.parametrize("gap", [2.0**-20, 2.0**-40, 2.0**-43])
def test_particles_that_nearly_touch_push_one_another_as_hard_as_they_should(gap, method):
    """Though single precision has no number for it."""
    points = np.concatenate([crowd(200), crowd(200)]) * 2.0**-9
    points[200:] += gap
    found, (force, _) = coulomb_force(points, method), naive(points)
    np.testing.assert_allclose(found, force, rtol=0, atol=1e-6 * np.abs(force).max())


def test_force_far_from_the_origin_is_that_of_the_same_particles_near_it():
    points = np.round(crowd(500) * 1024.0) / 1024.0
    far = points + 2.0**30
    for method in ("exact", "tree"):
        np.testing.assert_array_equal(coulomb_force(far, method), coulomb_force(far - 2.0**30, method))


@pytest.mark.parametrize("points", [np.zeros(4), np.zeros((3, 4)), np.zeros((2, 2, 2))], ids=str)
def test_other_shapes_are_refused(points):
    with pytest.raises(ValueError, match=r"positions have the shape .* must be \(N, 2\)"):
        coulomb_force(points)


def test_unknown_method_is_refused():
    with pytest.raises(ValueError, match='method is "magic" but must be one of auto, exact, tree'):
        coulomb_force(np.zeros((3, 2)), method="magic")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", [0, 1, slice(None)])
@pytest.mark.parametrize("method", METHODS)
def test_positions_that_are_no_numbers_are_refused(bad, column, method):
    points = crowd(10)
    points[3, column] = bad
    with pytest.raises(ValueError, match="positions must be finite numbers"):
        coulomb_force(points, method)


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("method", METHODS)
def test_forces_that_are_no_numbers_are_refused_in_a_sentence(axes, method):
    with pytest.raises(ValueError, match=r"positions lie within .* so near to each other"):
        coulomb_force(np.eye(4, axes) * 1e-300, method)
    with pytest.raises(ValueError, match=r"positions lie within .* so near to each other"):
        coulomb_force(np.eye(2, axes) * 5e-324, method)


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("unit", [1e-140, 1e150, 1e300])
def test_forces_are_numbers_in_any_unit_that_has_them(axes, unit):
    points = np.eye(4, axes)
    expected = coulomb_force(points) / unit / unit
    np.testing.assert_allclose(coulomb_force(points * unit), expected, rtol=1e-12)


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, 0.2, np.nan])
def test_tolerance_out_of_range_is_refused(tolerance):
    with pytest.raises(ValueError, match=r"tolerance is .* but must be from 1e-12 to 0\.1"):
        coulomb_force(crowd(3), tolerance=tolerance)


@pytest.mark.parametrize(
    ("targets", "sentence"),
    [
        ([0, 3], "targets go from 0 to 3 but must be indices of the 3 particles"),
        ([-1], "targets go from -1 to -1"),
        ([0.5], "targets must be a list of indices, not float64"),
        ([[0, 1]], r"of the shape \(1, 2\)"),
        (np.ones(3, bool), "not bool"),
    ],
)
def test_targets_that_are_no_particles_are_refused(targets, sentence):
    with pytest.raises(ValueError, match=sentence):
        coulomb_force(crowd(3), targets=targets)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000), scale=st.sampled_from([1e-3, 1.0, 1e5]))
def test_the_force_in_space_is_the_sum_over_all_pairs(seed, scale):
    points = scale * np.random.default_rng(seed).normal(size=(40, 3))
    points[7] = points[3]  # at the same position: no force on each other
    apart = points[:, None] - points[None]
    distance = np.linalg.norm(apart, axis=-1)
    distance[distance == 0.0] = np.inf
    truth = (apart / distance[..., None] ** 3).sum(axis=1)
    np.testing.assert_allclose(coulomb_force(points), truth, rtol=1e-9, atol=1e-11 * np.abs(truth).max())
    np.testing.assert_array_equal(coulomb_force(points, targets=[5, 2]), coulomb_force(points)[[5, 2]])
    assert coulomb_force(np.zeros((0, 3))).shape == (0, 3)
