"""Fields between the pixels, against SciPy and against functions that a multilinear rule reproduces exactly."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cpm_core.field.interpolation import interpolate_component, interpolate_field, pixel_before, value_at


def random_field(shape, channels, seed):
    return np.random.default_rng(seed).normal(size=(channels, *shape))


@settings(max_examples=16, deadline=None)
@given(
    st.lists(st.integers(1, 7), min_size=1, max_size=3).map(tuple),
    st.integers(1, 5),
    st.integers(0, 10**6),
)
def test_interpolation_is_multilinear_also_beyond_the_border(shape, channels, seed):
    field = random_field(shape, channels, seed)
    positions = np.random.default_rng(seed + 1).uniform(-3.0, np.array(shape) + 2.0, (40, len(shape)))
    truth = [ndimage.map_coordinates(part, positions.T, order=1, mode="nearest") for part in field]
    np.testing.assert_allclose(interpolate_field(field, positions), np.transpose(truth), rtol=0, atol=1e-12)


def felt_at(packed, place):
    """All components of a packed field, shape (H, W, C), at a place."""
    corner = pixel_before(packed, *place)
    return [interpolate_component(packed, c, corner) for c in range(packed.shape[2])]


@settings(max_examples=24, deadline=None)
@given(st.tuples(st.integers(1, 7), st.integers(1, 7)), st.integers(1, 5), st.integers(0, 10**6))
def test_the_packed_field_is_bilinear_also_beyond_the_border(shape, channels, seed):
    field = random_field(shape, channels, seed).astype(np.float32)
    packed = np.ascontiguousarray(np.moveaxis(field, 0, -1))
    for place in np.random.default_rng(seed + 1).uniform(-3.0, np.array(shape) + 2.0, (10, 2)):
        truth = [ndimage.map_coordinates(part.astype(float), place[:, None], order=1, mode="nearest") for part in field]
        np.testing.assert_allclose(felt_at(packed, place), np.ravel(truth), rtol=0, atol=1e-6)


def test_a_place_that_is_no_number_is_read_within_the_field():
    """Else a loop would read from memory that is not of the field."""
    flat, space = random_field((4, 5), 1, 3)[0].astype(np.float32), random_field((3, 4, 5), 1, 3)[0].astype(np.float32)
    for y, x in [(np.nan, 2.0), (2.0, np.nan), (-np.inf, np.inf)]:
        row, col, down, right = pixel_before(flat[..., None], y, x)
        assert 0 <= row <= 2
        assert 0 <= col <= 3
        assert 0.0 <= down <= 1.0
        assert 0.0 <= right <= 1.0
    assert value_at(space, np.nan, np.nan, np.nan) == space[0, 0, 0]
    assert value_at(space, 1.0, np.nan, np.inf) == space[1, 0, 4]
