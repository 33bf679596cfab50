"""Fields between the pixels, against SciPy and against functions that a multilinear rule reproduces exactly."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cpm_core.field.interpolation import between, component, interpolate, value_at


def random_field(shape, channels, seed):
    return np.random.default_rng(seed).normal(size=(channels, *shape))


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.integers(1, 7), min_size=1, max_size=3).map(tuple),
    st.integers(1, 5),
    st.integers(0, 10**6),
)
def test_interpolation_is_multilinear_also_beyond_the_border(shape, channels, seed):
    field = random_field(shape, channels, seed)
    positions = np.random.default_rng(seed + 1).uniform(-3.0, np.array(shape) + 2.0, (40, len(shape)))
    truth = [ndimage.map_coordinates(part, positions.T, order=1, mode="nearest") for part in field]
    np.testing.assert_allclose(interpolate(field, positions), np.transpose(truth), rtol=0, atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 3), st.integers(0, 10**6))
def test_multilinear_functions_are_reproduced_exactly(dimension, seed):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(2, 8, dimension))
    weight = rng.normal(size=(2,) * dimension)

    def function(points):
        """Sum over all products of coordinates."""
        total = np.zeros(points.shape[:-1])
        for powers in np.ndindex(weight.shape):
            total += weight[powers] * np.prod(points ** np.array(powers), axis=-1)
        return total

    nodes = np.moveaxis(np.indices(shape).astype(float), 0, -1)
    positions = rng.uniform(0.0, np.array(shape) - 1.0, (30, dimension))
    values = interpolate(function(nodes)[None], positions)[:, 0]
    np.testing.assert_allclose(values, function(positions), rtol=1e-10, atol=1e-10)


def test_pixels_keep_their_values():
    field = random_field((5, 6), 3, 0)
    nodes = np.argwhere(np.ones((5, 6), bool)).astype(float)
    np.testing.assert_array_equal(interpolate(field, nodes), field.reshape(3, -1).T)


def test_far_outside_the_value_is_that_of_the_nearest_corner():
    field = random_field((5, 6), 2, 0)
    far = np.array([(-100.0, -1.0), (1e6, 1e6), (-0.5, 5.5)])
    np.testing.assert_array_equal(interpolate(field, far), [field[:, 0, 0], field[:, 4, 5], field[:, 0, 5]])


def test_arrays_of_any_layout_are_taken():
    field = random_field((6, 5), 2, 1)
    positions = np.random.default_rng(2).uniform(0.0, 4.0, (20, 4))[:, ::2]
    straight = interpolate(field.copy(), positions.copy())
    np.testing.assert_array_equal(interpolate(np.asfortranarray(field), positions), straight)


def test_no_position_has_no_value():
    assert interpolate(random_field((5, 6), 3, 0), np.zeros((0, 2))).shape == (0, 3)


def felt_at(packed, place):
    """All components of a packed field, shape (H, W, C), at a place."""
    corner = between(packed, *place)
    return [component(packed, c, corner) for c in range(packed.shape[2])]


@settings(max_examples=60, deadline=None)
@given(st.tuples(st.integers(1, 7), st.integers(1, 7)), st.integers(1, 5), st.integers(0, 10**6))
def test_the_packed_field_is_bilinear_also_beyond_the_border(shape, channels, seed):
    field = random_field(shape, channels, seed).astype(np.float32)
    packed = np.ascontiguousarray(np.moveaxis(field, 0, -1))
    for place in np.random.default_rng(seed + 1).uniform(-3.0, np.array(shape) + 2.0, (10, 2)):
        truth = [ndimage.map_coordinates(part.astype(float), place[:, None], order=1, mode="nearest") for part in field]
        np.testing.assert_allclose(felt_at(packed, place), np.ravel(truth), rtol=0, atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.floats(-3.0, 9.0), st.floats(-3.0, 9.0))
def test_a_position_lies_between_the_pixels_that_are_found(y, x):
    row, col, down, right = between(np.zeros((6, 7, 5), np.float32), y, x)
    assert 0 <= row <= 4
    assert 0 <= col <= 5
    assert 0.0 <= down <= 1.0
    assert 0.0 <= right <= 1.0
    assert (row + down, col + right) == (min(max(y, 0.0), 5.0), min(max(x, 0.0), 6.0))


def test_the_packed_field_is_exact_on_pixels():
    packed = np.ascontiguousarray(np.moveaxis(random_field((5, 6), 3, 0), 0, -1).astype(np.float32))
    for row, col in np.ndindex(5, 6):
        np.testing.assert_array_equal(felt_at(packed, (float(row), float(col))), packed[row, col])


def test_a_place_that_is_no_number_is_read_within_the_field():
    """Else a loop would read from memory that is not of the field."""
    flat, space = random_field((4, 5), 1, 3)[0].astype(np.float32), random_field((3, 4, 5), 1, 3)[0].astype(np.float32)
    for y, x in [(np.nan, 2.0), (2.0, np.nan), (-np.inf, np.inf)]:
        row, col, down, right = between(flat[..., None], y, x)
        assert 0 <= row <= 2
        assert 0 <= col <= 3
        assert 0.0 <= down <= 1.0
        assert 0.0 <= right <= 1.0
    assert value_at(space, np.nan, np.nan, np.nan) == space[0, 0, 0]
    assert value_at(space, 1.0, np.nan, np.inf) == space[1, 0, 4]
