"""The Coulomb force of eq. (9), pair by pair and by the tree, against sums over all pairs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import coulomb_force
from cpm_core.model.coulomb import COULOMB_METHODS
from cpm_core.numerics import parallel
from tests.core.model.crowds import PLANE, SPACE, relative_error

SCENES = {f"{name}, plane": points for name, points in PLANE.items()}
SCENES |= {f"{name}, space": points for name, points in SPACE.items()}
EVEN = ("line", "column", "row", "ring")
"""Scenes in which nearly all forces on a particle cancel."""


@settings(max_examples=16, deadline=None)
@given(seed=st.integers(0, 1000), axes=st.sampled_from([2, 3]), scale=st.sampled_from([1e-140, 1e-3, 1.0, 1e5, 1e150]))
def test_the_force_is_the_sum_over_all_pairs_in_any_unit(seed, axes, scale):
    points = np.random.default_rng(seed).normal(size=(40, axes))
    points[7] = points[3]  # at the same position: no force on each other
    apart = points[:, None] - points[None]
    distance = np.linalg.norm(apart, axis=-1)
    distance[distance == 0.0] = np.inf
    truth = (apart / distance[..., None] ** 3).sum(axis=1)
    found = coulomb_force(scale * points) * scale * scale
    np.testing.assert_allclose(found, truth, rtol=1e-9, atol=1e-11 * np.abs(truth).max())
    assert np.abs(found.sum(axis=0)).max() <= 1e-11 * np.abs(found).sum()


def test_two_particles_repel_with_the_inverse_square_and_one_spot_not_at_all():
    force = coulomb_force([(10.0, 20.0), (13.0, 24.0)])
    np.testing.assert_allclose(force, [(-0.6 / 25.0, -0.8 / 25.0), (0.6 / 25.0, 0.8 / 25.0)], rtol=1e-14)
    for method in COULOMB_METHODS:
        assert not coulomb_force(np.full((3000, 2), 7.25), method).any()
        assert coulomb_force(np.zeros((0, 3)), method).shape == (0, 3)


@pytest.mark.parametrize("name", SCENES)
def test_the_error_of_the_tree_is_small_however_the_particles_lie(name):
    assert relative_error(SCENES[name], coulomb_force(SCENES[name], "tree")) <= (
        2e-2 if name.startswith(EVEN) else 1e-3
    )


@settings(max_examples=12, deadline=None)
@given(
    axes=st.sampled_from([2, 3]), spots=st.integers(1, 30), copies=st.integers(1, 40), seed=st.integers(0, 2**32 - 1)
)
def test_the_error_of_the_tree_is_small_around_any_spots(axes, spots, copies, seed):
    random = np.random.default_rng(seed)
    points = np.repeat(random.uniform(-1000.0, 1000.0, (spots, axes)), copies, axis=0)
    points += random.normal(0.0, 0.3, points.shape)
    assert relative_error(points, coulomb_force(points, "tree"), seed) <= 1e-3


@pytest.mark.parametrize("method", COULOMB_METHODS)
def test_same_bits_whatever_the_number_of_threads(method, monkeypatch):
    first = coulomb_force(PLANE["cloud"], method)
    for cores in (1, 3):
        monkeypatch.setattr(parallel, "count_cores", lambda cores=cores: cores)
        assert coulomb_force(PLANE["cloud"], method).tobytes() == first.tobytes()


def test_what_gives_no_force_is_refused_in_a_sentence():
    with pytest.raises(ValueError, match=r"positions have the shape .* must be \(N, 2\)"):
        coulomb_force(np.zeros((3, 4)))
    with pytest.raises(ValueError, match='method is "magic" but must be one of auto, exact, tree'):
        coulomb_force(np.zeros((3, 2)), method="magic")
    with pytest.raises(ValueError, match="positions must be finite numbers"):
        coulomb_force([(0.0, np.nan), (1.0, 1.0)])
    with pytest.raises(ValueError, match=r"positions lie within .* so close together"):
        coulomb_force(np.eye(4, 2) * 1e-300)
