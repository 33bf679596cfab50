"""The pyramid and the mapping between its scales."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.image.pyramid import build_pyramid, max_scales, shape_at_scale, to_image, to_scale

shapes = st.tuples(st.integers(32, 75), st.integers(32, 75))


@settings(max_examples=16, deadline=None)
@given(shapes, st.integers(0, 3), st.integers(0, 10**6))
def test_to_image_undoes_to_scale(shape, scale, seed):
    points = np.random.default_rng(seed).uniform(-2.0, 80.0, (20, 2))
    np.testing.assert_allclose(to_image(to_scale(points, scale, shape), scale, shape), points, atol=1e-10)
    np.testing.assert_allclose(to_scale(to_image(points, scale, shape), scale, shape), points, atol=1e-10)


@pytest.mark.parametrize("shape", [(80, 80), (81, 90), (97, 83)], ids=str)
def test_a_ramp_keeps_its_values_at_every_scale(shape):
    """Away from the border, a pixel of a scale has the value of the image at its position."""
    row, col = np.indices(shape).astype(float)
    for scale, reduced in enumerate(build_pyramid(3.0 * row - 2.0 * col + 7.0, 3)):
        assert reduced.shape == shape_at_scale(shape, scale)
        inner = 5 if scale else 0
        nodes = np.argwhere(np.ones(reduced.shape, bool)).astype(float)
        within = ((nodes >= inner) & (nodes <= np.array(reduced.shape) - 1 - inner)).all(axis=1)
        place = to_image(nodes[within], scale, shape)
        truth = 3.0 * place[:, 0] - 2.0 * place[:, 1] + 7.0
        np.testing.assert_allclose(reduced[tuple(nodes[within].astype(int).T)], truth, atol=1e-3)


@settings(max_examples=16, deadline=None)
@given(shapes)
def test_as_many_scales_as_leave_eight_pixels(shape):
    most = max_scales(shape)
    assert min(shape_at_scale(shape, most - 1)) >= 8
    assert min(shape_at_scale(shape, most)) < 8
