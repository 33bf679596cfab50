"""Where particles start."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import circle, edge_map, gradient_threshold, uniform_grid

from .scenes import disk


@settings(max_examples=50, deadline=None)
@given(st.floats(-50, 300), st.floats(-50, 300), st.floats(0.1, 200.0), st.floats(0.5, 10.0))
def test_circle_has_the_radius_and_an_even_spacing(row, col, radius, spacing):
    points = circle((row, col), radius, spacing)
    np.testing.assert_allclose(np.hypot(points[:, 0] - row, points[:, 1] - col), radius, rtol=1e-9, atol=1e-9)
    sides = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    np.testing.assert_allclose(sides, sides[0], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(points.mean(axis=0), (row, col), rtol=1e-9, atol=1e-9 * (radius + 1.0))
    count = 2.0 * np.pi * radius / spacing
    assert len(points) == max(5, round(count))


def test_circle_of_no_room_still_has_five_particles():
    assert len(circle((5.0, 5.0), 0.01)) == 5
    assert len(circle(center=(5.0, 5.0), radius=10.0)) == 31


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_circle_without_a_size_is_refused(value):
    with pytest.raises(ValueError, match=r"radius is .* must be above 0"):
        circle((5.0, 5.0), value)
    with pytest.raises(ValueError, match=r"spacing is .* must be above 0"):
        circle((5.0, 5.0), 3.0, value)


@pytest.mark.parametrize("center", [(np.nan, 1.0), (1.0, np.inf), (1.0, 2.0, 3.0)], ids=str)
def test_circle_without_a_place_is_refused(center):
    with pytest.raises(ValueError, match=r"center is .* two finite numbers"):
        circle(center, 3.0)


@settings(max_examples=50, deadline=None)
@given(st.tuples(st.integers(1, 70), st.integers(1, 70)), st.floats(0.6, 30.0))
def test_uniform_grid_is_inside_symmetric_and_evenly_spaced(shape, spacing):
    points = uniform_grid(shape, spacing)
    extent = np.array(shape) - 1.0
    assert np.all((points >= -1e-9) & (points <= extent + 1e-9))
    opposite = extent - points
    assert sorted(np.round(points, 6).tolist()) == sorted((np.round(opposite, 6) + 0.0).tolist())
    for axis, n in enumerate(shape):
        lines = np.unique(np.round(points[:, axis], 9))
        np.testing.assert_allclose(np.diff(lines), spacing, atol=1e-6)
        assert n - 1.0 - (lines[-1] - lines[0]) < spacing + 1e-6  # no room for another line
    assert len(points) == np.prod([len(np.unique(np.round(points[:, axis], 9))) for axis in range(2)])


def test_uniform_grid_has_as_many_axes_as_the_image():
    assert uniform_grid((17, 17, 9), 8.0).shape == (3 * 3 * 2, 3)


def test_uniform_grid_without_a_spacing_is_refused():
    with pytest.raises(ValueError, match="spacing is -8 but must be above 0"):
        uniform_grid((10, 10), -8.0)


@pytest.mark.parametrize("fraction", [0.0, 0.1, 0.5, 1.0])
def test_gradient_threshold_takes_the_pixels_of_the_strong_edges(fraction):
    image = disk((40, 50), (20.0, 22.0), 11.0).values
    points = gradient_threshold(image, fraction, smoothing=1.5)
    mask = np.zeros(image.shape, bool)
    mask[tuple(points.astype(int).T)] = True
    f = edge_map(image, 1.5)
    np.testing.assert_array_equal(mask, f > fraction * f.max())
    assert len(points) == mask.sum()


@pytest.mark.parametrize("fraction", [-0.1, 1.1, float("nan")])
def test_gradient_threshold_of_no_fraction_is_refused(fraction):
    with pytest.raises(ValueError, match=r"fraction is .* must be from 0 to 1"):
        gradient_threshold(np.eye(10), fraction)
