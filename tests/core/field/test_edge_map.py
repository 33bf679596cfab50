"""The edge map: derivatives of known images, symmetry, and what it makes of noise."""

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import edge_map, electric_field
from cpm_core.field.convolution import convolved_potential
from cpm_core.field.edge_map import automatic_smoothing, background_strength, prepare_for_edges, smoothed_gradient

from ..scenes import disk


@settings(max_examples=12, deadline=None)
@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.sampled_from([0.0, 0.5, 1.0, 2.0]))
def test_gradient_of_a_ramp_is_its_slope(down, right, smoothing):
    row, col = np.indices((40, 44)).astype(float)
    inner = int(np.ceil(4.0 * smoothing)) + 2  # what the continued border does not reach
    inside = (slice(None), slice(inner, -inner), slice(inner, -inner))
    found = smoothed_gradient(100.0 + down * row + right * col, smoothing)[inside]
    np.testing.assert_allclose(found[0], down, atol=1e-9)
    np.testing.assert_allclose(found[1], right, atol=1e-9)
    slope = edge_map(100.0 + down * row + right * col, smoothing)[inside[1:]]
    np.testing.assert_allclose(slope, np.hypot(down, right), atol=1e-9)


@pytest.mark.parametrize("smoothing", [0.0, 1.5])
def test_border_adds_no_edge_to_what_reaches_it(smoothing):
    """A step from top to bottom is the same step in every row, the outermost ones included."""
    f = edge_map(np.where(np.arange(30) < 14, 10.0, 90.0) * np.ones((25, 1)), smoothing)
    np.testing.assert_allclose(f, np.broadcast_to(f[12], f.shape), atol=1e-10)
    np.testing.assert_allclose(f[:, [0, -1]], 0.0, atol=1e-9)


def test_smoothed_step_is_as_steep_as_a_gaussian():
    """A blurred step of height h has the slope of h times a Gaussian; central differences take its mean over 2 px."""
    sigma, height = 4.0, 80.0
    f = edge_map(np.where(np.arange(80) < 40, 10.0, 10.0 + height) * np.ones((9, 1)), sigma)
    x = np.arange(80) - 39.5
    truth = height * np.exp(-0.5 * (x / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
    np.testing.assert_allclose(f[4], truth, atol=0.04 * truth.max())


@pytest.mark.parametrize("smoothing", [0.0, 1.0, 2.5])
def test_mirrored_and_turned_images_have_such_an_edge_map(smoothing):
    image = np.random.default_rng(0).uniform(0.0, 255.0, (23, 30))
    f = edge_map(image, smoothing)
    for change in (np.flipud, np.fliplr, np.rot90, np.transpose):
        np.testing.assert_allclose(edge_map(change(image), smoothing), change(f), atol=1e-10)


def noise_of_a_component(sigma):
    """Standard deviation that unit white noise leaves in one derivative: the size of the filter's weights."""
    reach = int(4.0 * sigma + 0.5)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    weights /= weights.sum()
    slope = np.convolve(weights, [0.5, 0.0, -0.5])
    return np.linalg.norm(weights) * np.linalg.norm(slope)


@pytest.mark.parametrize("sigma", [0.7, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("noise", [1.0, 30.0])
def test_background_strength_of_pure_noise_is_four_deviations_of_its_gradient(sigma, noise):
    """Within 5 percent on 256 x 256 pixels."""
    image = np.random.default_rng(5).normal(100.0, noise, (256, 256))
    assert background_strength(edge_map(image, sigma)) == pytest.approx(
        4.0 * noise * noise_of_a_component(sigma), rel=0.05
    )


def test_more_noise_never_gives_less_automatic_smoothing():
    scene = disk((96, 96), (47.0, 48.0), 25.0).values
    noise = np.random.default_rng(7).normal(size=scene.shape)
    chosen = [
        automatic_smoothing(scene + scale_field * noise) for scale_field in (0.0, 5.0, 20.0, 40.0, 60.0, 80.0, 120.0)
    ]
    assert chosen == sorted(chosen)
    assert chosen[-1] > chosen[0] + 1.0
    assert chosen[0] == min(chosen) == automatic_smoothing(np.zeros((20, 20)))


def test_light_noise_is_left_to_the_chosen_gaussian():
    image = disk((64, 64), (31.0, 33.0), 15.0).values + np.random.default_rng(8).normal(0.0, 20.0, (64, 64))
    ready = prepare_for_edges(image)
    assert ready.image is image
    assert ready.floor == 0.0
    np.testing.assert_array_equal(edge_map(image, "auto"), edge_map(image, automatic_smoothing(image)))


def test_heavy_noise_is_removed_before_the_search_for_edges():
    scene = disk((128, 128), (63.0, 65.0), 35.0).values
    image = scene + np.random.default_rng(8).normal(0.0, 150.0, scene.shape)
    ready = prepare_for_edges(image)
    assert np.abs(ready.image - scene).mean() < 0.2 * np.abs(image - scene).mean()
    row, col = np.unravel_index(edge_map(image, "auto").argmax(), scene.shape)
    assert abs(np.hypot(row - 63.0, col - 65.0) - 35.0) < 3.0


def ball(shape, center, radius, noise):
    """A volume of a bright ball with noise."""
    away = np.sqrt(sum((g - c) ** 2 for g, c in zip(np.indices(shape), center, strict=True)))
    return np.where(away < radius, 150.0, 50.0) + np.random.default_rng(3).normal(0.0, noise, shape)


@pytest.mark.parametrize("noise", [0.0, 15.0])
def test_the_smoothing_of_a_volume_is_chosen_as_that_of_an_image(noise):
    """The edge map along rays from the center is largest on the ball."""
    center, radius = np.array([15.0, 16.0, 14.5]), 9.0
    strength = edge_map(ball((32, 33, 30), center, radius, noise), "auto")
    assert strength.shape == (32, 33, 30)
    rays = np.random.default_rng(4).normal(size=(60, 3))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    along = np.linspace(0.0, 13.0, 131)
    places = center[:, None, None] + rays.T[:, :, None] * along
    summit = along[scipy.ndimage.map_coordinates(strength, places, order=1).argmax(axis=1)]
    assert abs(np.median(summit) - radius) < 0.7


@pytest.mark.parametrize("shape", [(9, 11), (7, 6, 8)])
def test_the_potential_is_the_sum_over_all_other_charges_and_the_field_its_slope(shape):
    charges = np.random.default_rng(6).uniform(0.0, 3.0, shape)
    dimension, places = len(shape), np.argwhere(np.ones(shape, bool)).astype(float)
    away = np.linalg.norm(places[:, None] - places, axis=-1)
    np.fill_diagonal(away, np.inf)
    expected = -(charges.ravel() / ((dimension - 1) * away ** (dimension - 1))).sum(axis=1)
    np.testing.assert_allclose(convolved_potential(charges).ravel(), expected, rtol=2e-6)
    lonely = np.zeros((15,) * dimension)
    lonely[(7,) * dimension] = 1.0
    force = -smoothed_gradient(convolved_potential(lonely), 0.0)
    far = (2,) * dimension
    np.testing.assert_allclose(force[(..., *far)], electric_field(lonely)[(..., *far)], rtol=0.1)
