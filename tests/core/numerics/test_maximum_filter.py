"""The running maximum is the maximum over a box, as a filter finds it; high maxima stand out around them."""

import numpy as np
import skimage
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cpm_core.image.border import dilate_by_distance
from cpm_core.numerics.grids import find_high_maxima, running_maximum

shapes = st.one_of(st.tuples(st.integers(1, 12), st.integers(1, 12)), st.tuples(*[st.integers(1, 6)] * 3))


@settings(max_examples=16, deadline=None)
@given(shapes, st.integers(0, 7), st.integers(0, 10**6))
def test_it_is_the_maximum_over_a_box(shape, reach, seed):
    values = np.random.default_rng(seed).normal(size=shape)
    before = values.copy()
    for reached in (np.full(values.ndim, reach), np.arange(values.ndim)):
        found = running_maximum(values, reached)
        np.testing.assert_array_equal(found, ndimage.maximum_filter(values, tuple(2 * reached + 1), mode="nearest"))
    np.testing.assert_array_equal(running_maximum(values, 1), running_maximum(values, np.ones(values.ndim, int)))
    np.testing.assert_array_equal(values, before)


@settings(max_examples=12, deadline=None)
@given(shapes, st.integers(0, 6), st.integers(0, 10**6))
def test_within_a_distance_of_some_pixels(shape, reach, seed):
    """By the distance transform."""
    some = np.random.default_rng(seed).uniform(size=shape) > 0.9
    some[(0,) * len(shape)] = True
    distance = ndimage.distance_transform_edt(~some)
    np.testing.assert_array_equal(dilate_by_distance(some, reach), distance <= reach + 1e-9)


@settings(max_examples=24, deadline=None)
@given(shapes, st.floats(0.5, 2.0), st.integers(0, 10**6), st.booleans())
def test_high_maxima_are_those_that_a_reconstruction_leaves(shape, least, seed, equal):
    """Equal maxima count together, whether a way between them descends or not."""
    heights = np.random.default_rng(seed).normal(scale=2.0, size=shape)
    heights = np.round(heights) if equal else heights
    expected = skimage.morphology.h_maxima(heights, least) > 0
    np.testing.assert_array_equal(find_high_maxima(heights, least), expected)
