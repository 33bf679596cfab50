"""The fast sum of eq. (9) in space: its error against the sum over all pairs, however the particles lie."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import coulomb_force
from cpm_core.numerics import parallel


def sum_of_all_pairs(points, some):
    """Eq. (9) for some particles, on distances that are divided by the largest one, times its square."""
    extent = np.ptp(points, axis=0).max() or 1.0
    apart = (points[some, None] - points[None]) / extent
    distance = np.linalg.norm(apart, axis=-1)
    distance[distance == 0.0] = np.inf
    return (apart / distance[..., None] ** 3).sum(axis=1), extent


def relative_error(points, force, seed=0):
    """Root of the sum of the squared errors of some hundred particles over that of their forces."""
    some = np.random.default_rng(seed).choice(len(points), min(len(points), 150), replace=False)
    exact, extent = sum_of_all_pairs(points, some)
    size = np.abs(exact).max() or 1.0
    return np.linalg.norm((force[some] * extent * extent - exact) / size) / (np.linalg.norm(exact / size) or 1.0)


def even_sphere(count, radius=60.0):
    """Particles that lie evenly on a sphere, so that most of the pushes on each along it cancel."""
    turn, height = np.pi * (1.0 + 5.0**0.5) * np.arange(count), 1.0 - (2.0 * np.arange(count) + 1.0) / count
    across = np.sqrt(1.0 - height**2)
    return radius * np.stack([height, across * np.sin(turn), across * np.cos(turn)], axis=1)


def scenes():
    rng = np.random.default_rng(7)
    grid = np.stack(np.mgrid[:16, :16, :16], axis=-1).reshape(-1, 3).astype(float)
    one, other = rng.uniform(0.0, 2.0 * np.pi, (2, 4000))
    torus = np.stack([np.sin(other), (3 + np.cos(other)) * np.sin(one), (3 + np.cos(other)) * np.cos(one)], axis=1)
    cloud = rng.uniform(0.0, 200.0, (4000, 3))
    sphere = even_sphere(4000)
    return {
        "sphere": sphere,
        "shell": np.concatenate([even_sphere(2000, 40.0), even_sphere(3000, 60.0)]),
        "torus": 20.0 * torus,
        "cloud": cloud,
        "grid": grid,
        "grid far away": grid + 1e8,
        "plane": sphere * (0.0, 1.0, 1.0),
        "line": np.arange(4000)[:, None] * np.array([1.5, 0.5, 0.25]),
        "clusters": cloud[rng.integers(0, 20, 4000)] + rng.normal(0.0, 0.5, (4000, 3)),
        "cluster with outliers": np.concatenate([rng.normal(size=(3000, 3)), rng.uniform(-1e6, 1e6, (80, 3))]),
        "some spots": np.round(cloud / 20.0),
        "two spots": np.array([(0.0, 0.0, 1.0), (3.0, 4.0, 0.0)])[rng.integers(0, 2, 3000)],
        "near twins": np.concatenate([sphere[:2000], sphere[:2000] + 1e-9]),
        "all scales": np.exp(rng.uniform(-25.0, 5.0, 4000))[:, None] * sphere,
        "huge": sphere * 1e100,
        "tiny": sphere * 1e-100,
    }


SCENES = scenes()


@pytest.mark.parametrize("name", SCENES)
def test_error_is_within_the_tolerance_however_the_particles_lie(name):
    assert relative_error(SCENES[name], coulomb_force(SCENES[name], "tree")) <= 1e-3


@pytest.mark.parametrize("tolerance", [0.1, 1e-2, 1e-4, 1e-7])
@pytest.mark.parametrize("name", ["sphere", "torus", "grid", "cloud", "line", "shell"])
def test_error_is_within_any_tolerance(name, tolerance):
    assert relative_error(SCENES[name], coulomb_force(SCENES[name], "tree", tolerance=tolerance)) <= tolerance


coordinate = st.one_of(
    st.integers(0, 40).map(float), st.floats(-1000.0, 1000.0, width=32), st.floats(-0.25, 0.25, width=32)
)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=1, max_size=30),
    st.integers(1, 40),
    st.integers(0, 2**32 - 1),
)
def test_error_is_within_the_tolerance_around_any_spots(spots, copies, seed):
    """Up to 1200 particles: a number of them around each of the spots."""
    points = np.repeat(np.array(spots), copies, axis=0)
    points = points + np.random.default_rng(seed).normal(0.0, 0.3, points.shape)
    assert relative_error(points, coulomb_force(points, "tree"), seed) <= 1e-3


def test_a_large_crowd_is_summed_by_the_tree_and_a_small_one_exactly():
    crowd = even_sphere(6000)
    assert coulomb_force(crowd).tobytes() == coulomb_force(crowd, "tree").tobytes()
    assert coulomb_force(crowd).tobytes() != coulomb_force(crowd, "exact").tobytes()
    assert coulomb_force(crowd[:900]).tobytes() == coulomb_force(crowd[:900], "exact").tobytes()
    few = np.arange(0, 6000, 40)
    assert coulomb_force(crowd, targets=few).tobytes() == coulomb_force(crowd, "exact", targets=few).tobytes()


def test_force_on_some_is_that_part_of_the_force_on_all():
    """Bit for bit, in any order, and some of them twice."""
    targets = np.random.default_rng(2).integers(0, 4000, 37)
    whole = coulomb_force(SCENES["torus"], "tree")
    assert coulomb_force(SCENES["torus"], "tree", targets=targets).tobytes() == whole[targets].tobytes()


@pytest.mark.parametrize("count", [0, 1, 2, 64, 65, 3000])
def test_same_bits_whatever_the_number_of_threads(count, monkeypatch):
    points = SCENES["cloud"][:count]
    first = coulomb_force(points, "tree")
    for cores in (1, 3, 8):
        monkeypatch.setattr(parallel, "cores", lambda cores=cores: cores)
        assert coulomb_force(points, "tree").tobytes() == first.tobytes()


def test_particles_on_one_spot_do_not_act_on_each_other_however_many():
    assert not coulomb_force(np.full((5000, 3), 7.3), "tree").any()


@pytest.mark.parametrize("method", ["auto", "exact", "tree"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_positions_that_are_no_numbers_are_refused(bad, method):
    points = SCENES["cloud"][:10].copy()
    points[3, 0] = bad
    with pytest.raises(ValueError, match="positions must be finite numbers"):
        coulomb_force(points, method)
