"""The pyramid and the mapping between its scales."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.image.pyramid import most_scales, pyramid, shape_of_scale, to_image, to_scale

shapes = st.tuples(st.integers(32, 75), st.integers(32, 75))
SIZES = [(32, 32), (33, 40), (41, 35), (64, 47)]


@settings(max_examples=40, deadline=None)
@given(shapes, st.integers(0, 3), st.integers(0, 10**6))
def test_to_image_undoes_to_scale(shape, scale, seed):
    points = np.random.default_rng(seed).uniform(-2.0, 80.0, (20, 2))
    np.testing.assert_allclose(to_image(to_scale(points, scale, shape), scale, shape), points, atol=1e-10)
    np.testing.assert_allclose(to_scale(to_image(points, scale, shape), scale, shape), points, atol=1e-10)


@settings(max_examples=40, deadline=None)
@given(shapes, st.integers(0, 3))
def test_the_center_of_the_image_is_the_center_of_every_scale(shape, scale):
    centre = 0.5 * (np.array([shape]) - 1.0)
    reduced = 0.5 * (np.array([shape_of_scale(shape, scale)]) - 1.0)
    np.testing.assert_allclose(to_scale(centre, scale, shape), reduced, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(shapes, st.integers(1, 3), st.integers(0, 10**6))
def test_distances_halve_from_scale_to_scale(shape, scale, seed):
    points = np.random.default_rng(seed).uniform(0.0, 40.0, (10, 2))
    reduced = to_scale(points, scale, shape)
    np.testing.assert_allclose(np.diff(reduced, axis=0) * 2**scale, np.diff(points, axis=0), atol=1e-10)


@settings(max_examples=40, deadline=None)
@given(shapes, st.integers(1, 3))
def test_every_scale_covers_the_image(shape, scale):
    """The outermost pixels of a scale, whole, reach at least over the outermost pixel centers of the image."""
    reduced = np.array(shape_of_scale(shape, scale))
    low, high = to_image(np.array([[-0.5, -0.5], reduced - 0.5]), scale, shape)
    assert np.all(low <= 0.0)
    assert np.all(high >= np.array(shape) - 1.0)


@pytest.mark.parametrize("shape", SIZES, ids=str)
@pytest.mark.parametrize("change", [np.flipud, np.fliplr, np.rot90, np.transpose], ids=lambda f: f.__name__)
def test_mirrored_and_turned_images_have_such_a_pyramid(shape, change):
    image = np.random.default_rng(0).uniform(0.0, 255.0, shape)
    for reduced, other in zip(pyramid(image, 3), pyramid(change(image), 3), strict=True):
        np.testing.assert_allclose(other, change(reduced), atol=1e-10)


@pytest.mark.parametrize("shape", [(80, 80), (81, 90), (97, 83)], ids=str)
def test_a_ramp_keeps_its_values_at_every_scale(shape):
    """Away from the border, a pixel of a scale has the value of the image at its position."""
    row, col = np.indices(shape).astype(float)
    for scale, reduced in enumerate(pyramid(3.0 * row - 2.0 * col + 7.0, 3)):
        assert reduced.shape == shape_of_scale(shape, scale)
        inner = 5 if scale else 0
        nodes = np.argwhere(np.ones(reduced.shape, bool)).astype(float)
        within = ((nodes >= inner) & (nodes <= np.array(reduced.shape) - 1 - inner)).all(axis=1)
        place = to_image(nodes[within], scale, shape)
        truth = 3.0 * place[:, 0] - 2.0 * place[:, 1] + 7.0
        np.testing.assert_allclose(reduced[tuple(nodes[within].astype(int).T)], truth, atol=1e-3)


def test_scales_keep_the_mean_and_do_not_ring():
    image = np.where(np.indices((64, 64)).sum(axis=0) < 60, 0.0, 100.0)
    for reduced in pyramid(image, 4):
        assert reduced.min() >= -1e-9
        assert reduced.max() <= 100.0 + 1e-9
        assert reduced.mean() == pytest.approx(image.mean(), abs=1.5)


def test_scale_zero_is_the_image_itself():
    image = np.random.default_rng(1).uniform(size=(32, 32))
    np.testing.assert_array_equal(pyramid(image, 2)[0], image)
    points = np.array([(3.25, 4.5)])
    np.testing.assert_array_equal(to_image(points, 0, image.shape), points)
    np.testing.assert_array_equal(to_scale(points, 0, image.shape), points)


@settings(max_examples=40, deadline=None)
@given(shapes)
def test_as_many_scales_as_leave_eight_pixels(shape):
    most = most_scales(shape)
    assert min(shape_of_scale(shape, most - 1)) >= 8
    assert min(shape_of_scale(shape, most)) < 8


def test_too_many_scales_are_refused_with_field_value_and_range():
    with pytest.raises(ValueError, match=r"scales is 4 but must be from 1 to 3 for an image of 32 x 300 pixels"):
        pyramid(np.zeros((32, 300)), 4)
