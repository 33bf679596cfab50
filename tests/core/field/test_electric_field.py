"""The electric field of eq. (8), against its direct sum and the laws of electrostatics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import electric_field
from cpm_core.field import convolution
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


@settings(max_examples=25, deadline=None)
@given(st.tuples(st.integers(1, 17), st.integers(1, 17)), st.integers(0, 1000), st.booleans())
def test_field_is_the_direct_sum(shape, seed, sparse):
    """To 1e-12 of the largest vector; seen: 4e-15 at most."""
    f = charges(shape, seed)
    if sparse:
        f = np.where(f > 45.0, f, 0.0)
    truth = direct(f, 2.0)
    assert np.abs(electric_field(f) - truth).max() <= 1e-12 * max(np.abs(truth).max(), 1e-300)


@pytest.mark.parametrize("shape", [(31, 32), (40, 23)], ids=str)
def test_field_of_a_larger_map_is_the_direct_sum(shape):
    f = charges(shape)
    truth = direct(f, 2.0)
    assert np.abs(electric_field(f) - truth).max() <= 1e-12 * np.abs(truth).max()


@pytest.mark.parametrize("exponent", [None, 1.7])
@pytest.mark.parametrize("shape", [(41, 32), (22, 25, 24)], ids=str)
def test_the_field_of_blocks_is_the_exact_one_but_for_the_error_that_is_told(shape, exponent):
    middle = [n // 2 for n in shape]
    f = np.zeros(shape)
    f[tuple(slice(m - 2, m + 2) for m in middle)] = charges((4,) * len(shape))
    exact, found = electric_field(f, exponent=exponent), electric_field(f, "blocks", exponent)
    away = np.linalg.norm(np.indices(shape) - np.reshape(middle, (-1, *[1] * len(shape))) + 0.5, axis=0)
    size = np.linalg.norm(exact, axis=0)
    angle = np.degrees(np.arccos(np.clip((exact * found).sum(0) / size / np.linalg.norm(found, axis=0), -1.0, 1.0)))
    off = np.linalg.norm(found - exact, axis=0) / size
    near, far = (away > 5.0) & (away < 9.0), away > 9.0
    assert np.median(angle[near]) < 2.0
    assert angle[far].max() < 4.0
    assert np.median(off[near]) < 0.1
    assert np.median(off[far]) < 0.05


@pytest.mark.parametrize("shape", [(40, 23), (9, 8, 7)], ids=str)
def test_single_precision_is_kept_and_as_good_as_it_can_be(shape):
    """To 1e-6 of the largest vector; seen: 3e-7."""
    f = charges(shape)
    truth = direct(f, float(len(shape)))
    field = convolved_field(f, precision=np.float32)
    assert field.dtype == np.float32
    assert 1e-9 * np.abs(truth).max() < np.abs(field - truth).max() <= 1e-6 * np.abs(truth).max()
    assert electric_field(f).dtype == np.float64


def test_a_size_seen_before_takes_over_its_kernels_unless_it_is_large(monkeypatch):
    convolution._kernel_spectrum.cache_clear()
    one, other = charges((20, 22)), charges((21, 22))
    fields = [electric_field(f) for f in (one, other, one)]
    np.testing.assert_array_equal(fields[0], fields[2])
    assert convolution._kernel_spectrum.cache_info().misses == 4
    monkeypatch.setattr(convolution, "_MOST_KEPT", 100)
    np.testing.assert_array_equal(electric_field(one), fields[0])
    assert convolution._kernel_spectrum.cache_info().hits == 2


def test_one_charge_attracts_with_the_inverse_square_and_not_itself():
    f = np.zeros((12, 15))
    f[4, 6] = 5.0
    field = electric_field(f)
    np.testing.assert_allclose(field[:, 4, 6], 0.0, atol=1e-14)
    np.testing.assert_allclose(field[:, 4, 8], (0.0, -5.0 / 4.0), atol=1e-13)
    np.testing.assert_allclose(field[:, 1, 6], (5.0 / 9.0, 0.0), atol=1e-13)
    np.testing.assert_allclose(field[:, 7, 10], (-0.6 * 5.0 / 25.0, -0.8 * 5.0 / 25.0), atol=1e-13)
    np.testing.assert_allclose(field[:, 11, 14], -5.0 * np.array([7.0, 8.0]) / 113.0**1.5, atol=1e-13)


def test_nothing_wraps_around_the_border():
    f = np.zeros((16, 16))
    f[0, 0] = 1.0
    column = electric_field(f)[0, :, 0]
    np.testing.assert_allclose(column[1:], -1.0 / np.arange(1.0, 16.0) ** 2, rtol=1e-12)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_fields_add_up(seed, a, b):
    one, other = charges((13, 18), seed), charges((13, 18), seed + 1)
    together = electric_field(a * one + b * other)
    apart = a * electric_field(one) + b * electric_field(other)
    np.testing.assert_allclose(together, apart, rtol=0, atol=1e-10)


def test_mirrored_turned_and_transposed_charges_have_such_a_field():
    f = charges((14, 19))
    field = electric_field(f)
    size = 1e-12 * np.abs(field).max()
    row, col = field
    np.testing.assert_allclose(electric_field(f[::-1]), [-row[::-1], col[::-1]], rtol=0, atol=size)
    np.testing.assert_allclose(electric_field(f[:, ::-1]), [row[:, ::-1], -col[:, ::-1]], rtol=0, atol=size)
    np.testing.assert_allclose(electric_field(f.T), [col.T, row.T], rtol=0, atol=size)
    np.testing.assert_allclose(electric_field(np.rot90(f)), [-np.rot90(col), np.rot90(row)], rtol=0, atol=size)


@pytest.mark.parametrize("power", [1.0, 2.0, 3.0, 4.5])
def test_exponent_is_the_power_that_the_force_decays_with(power):
    f = charges((11, 14))
    truth = direct(f, power)
    np.testing.assert_allclose(electric_field(f, exponent=power), truth, rtol=0, atol=1e-12 * np.abs(truth).max())


def test_exponent_is_the_dimension_unless_given():
    f = charges((5, 6, 7))
    truth = direct(f, 3.0)
    np.testing.assert_allclose(electric_field(f), truth, rtol=0, atol=1e-12 * np.abs(truth).max())


def test_no_charge_no_field():
    assert not electric_field(np.zeros((9, 9))).any()


def test_unknown_method_and_impossible_exponent_are_refused():
    with pytest.raises(ValueError, match='method is "guess" but must be "convolution" or "blocks" or "pppm"'):
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
