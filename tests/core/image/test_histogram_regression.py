"""The regression keeps gray levels that are more frequent in one region than in another."""

import numpy as np
import pytest

from cpm_core.image.denoising import expected

HALVES = np.where(np.indices((120, 120))[1] < 60, 40.0, 200.0)
RNG = np.random.default_rng(1)


def step_and_noise(image):
    left, right = image[:, :60], image[:, 60:]
    return right.mean() - left.mean(), np.sqrt(0.5 * (left.var() + right.var()))


def test_an_image_of_two_levels_is_not_changed():
    image = np.where(RNG.random(HALVES.shape) < 0.6, 255.0 * (RNG.random(HALVES.shape) < 0.5), 255.0 * (HALVES > 100))
    np.testing.assert_allclose(expected(image, HALVES), image, atol=1e-6)


@pytest.mark.parametrize("share", [0.6, 0.9])
def test_levels_that_objects_have_kept_stand_out_of_replaced_pixels(share):
    replaced = RNG.random(HALVES.shape) < share
    image = np.where(replaced, RNG.uniform(0.0, 255.0, HALVES.shape), HALVES)
    (before, noise_before), (after, noise_after) = step_and_noise(image), step_and_noise(expected(image, HALVES))
    assert after == pytest.approx(before, rel=0.1)
    assert noise_after < 0.6 * noise_before


def test_added_noise_is_not_made_worse():
    image = HALVES + RNG.normal(0.0, 150.0, HALVES.shape)
    (before, noise_before), (after, noise_after) = step_and_noise(image), step_and_noise(expected(image, HALVES))
    assert after / noise_after > 0.97 * before / noise_before


def test_it_follows_contrast_and_brightness():
    image = np.where(RNG.random(HALVES.shape) < 0.8, RNG.integers(0, 256, HALVES.shape), HALVES)
    once = expected(image, HALVES)
    np.testing.assert_allclose(expected(3.0 * image + 20.0, HALVES), 3.0 * once + 20.0, rtol=1e-9)
    np.testing.assert_allclose(expected(image, 0.5 * HALVES - 9.0), once, rtol=1e-9)


def test_an_estimate_without_information_changes_nothing():
    image = RNG.uniform(size=(9, 11))
    np.testing.assert_array_equal(expected(image, np.full((9, 11), 5.0)), image)
