"""The electric field of eq. (8), against its direct sum and the laws of electrostatics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import electric_field
from cpm_core.field.convolution import convolved_field
from cpm_core.field.scale_field import unit_vectors


def direct(f, power):
    """Eq. (8), one charge after the other: ``sum_k -f_k (r - R_k) / |r - R_k|^(power + 1)``, itself excluded."""
    places = np.argwhere(np.ones(f.shape, bool)).astype(float)
    field = np.zeros((len(places), f.ndim))
    for place, charge in zip(places, -f.ravel(), strict=True):
        apart = places - place
        distance = np.linalg.norm(apart, axis=1)
        others = distance > 0
        field[others] += charge * apart[others] / distance[others, None] ** (power + 1.0)
    return field.T.reshape(f.ndim, *f.shape)


def charges(shape, seed=0):
    return np.random.default_rng(seed).uniform(0.0, 50.0, shape)


@settings(max_examples=10, deadline=None)
@given(st.tuples(st.integers(1, 17), st.integers(1, 17)), st.integers(0, 1000), st.booleans())
def test_field_is_the_direct_sum(shape, seed, sparse):
    """To 1e-12 of the largest vector; seen: 4e-15 at most."""
    f = charges(shape, seed)
    if sparse:
        f = np.where(f > 45.0, f, 0.0)
    truth = direct(f, 2.0)
    assert np.abs(electric_field(f) - truth).max() <= 1e-12 * max(np.abs(truth).max(), 1e-300)


@pytest.mark.parametrize("shape", [(40, 23), (9, 8, 7)], ids=str)
def test_single_precision_is_kept_and_as_good_as_it_can_be(shape):
    """To 1e-6 of the largest vector; seen: 3e-7."""
    f = charges(shape)
    truth = direct(f, float(len(shape)))
    field = convolved_field(f, precision=np.float32)
    assert field.dtype == np.float32
    assert 1e-9 * np.abs(truth).max() < np.abs(field - truth).max() <= 1e-6 * np.abs(truth).max()
    assert electric_field(f).dtype == np.float64


@pytest.mark.parametrize("power", [1.0, 2.0, 3.0, 4.5])
def test_exponent_is_the_power_that_the_force_decays_with(power):
    f = charges((11, 14))
    truth = direct(f, power)
    np.testing.assert_allclose(electric_field(f, exponent=power), truth, rtol=0, atol=1e-12 * np.abs(truth).max())


def test_unknown_method_and_impossible_exponent_are_refused():
    with pytest.raises(ValueError, match='method is "guess" but must be "convolution" or "pppm"'):
        electric_field(np.ones((8, 8)), method="guess")
    for exponent in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match=r"exponent is .* must be above 0"):
            electric_field(np.ones((8, 8)), exponent=exponent)


def test_unit_vectors_keep_the_direction_and_lose_the_size():
    field = np.random.default_rng(3).normal(size=(2, 6, 7)) * 10.0 ** np.arange(-3, 4)
    field[:, 2, 2] = 0.0
    unit = unit_vectors(field)
    size = np.hypot(*unit)
    assert size[2, 2] == 0.0
    size[2, 2] = 1.0
    np.testing.assert_allclose(size, 1.0, rtol=1e-14)
    np.testing.assert_allclose(unit * np.hypot(*field), field, rtol=1e-12)
