"""Noise is measured as strong as it is, and total variation takes it out without moving edges."""

import numpy as np
import pytest

from cpm_core.image.denoising import minimize_total_variation, noise_level


@pytest.mark.parametrize("deviation", [1.0, 20.0, 120.0])
def test_noise_is_measured_as_strong_as_it_is(deviation):
    row, col = np.indices((128, 128))
    scene = 2.0 * row - 0.7 * col
    image = scene + np.random.default_rng(1).normal(0.0, deviation, scene.shape)
    assert noise_level(image) == pytest.approx(deviation, rel=0.05)


def test_of_a_disk_total_variation_takes_as_much_height_as_theory_says():
    row, col = np.indices((128, 128)) - 63.5
    radius, height, weight = 30.0, 100.0, 150.0
    image = height * np.clip(radius + 0.5 - np.hypot(row, col), 0.0, 1.0)
    flat = minimize_total_variation(image, weight)
    # inside the disk sinks by 2 weight / R; outside, over the whole image, rises by perimeter * weight / area
    sunk = height - 2.0 * weight / radius
    risen = 2.0 * np.pi * radius * weight / (128.0**2 - np.pi * radius**2)
    distance = np.hypot(row, col)
    assert flat[distance < 20.0].mean() == pytest.approx(sunk, abs=0.5)
    assert flat[distance > 45.0].mean() == pytest.approx(risen, abs=0.5)
    assert flat.mean() == pytest.approx(image.mean(), rel=1e-4)


def test_no_image_near_it_costs_less():
    rng = np.random.default_rng(2)
    image = 50.0 * (np.indices((24, 24))[1] > 11) + rng.normal(0.0, 20.0, (24, 24))
    weight = 30.0

    def cost(u):
        down, right = np.diff(u, axis=0, append=u[-1:]), np.diff(u, axis=1, append=u[:, -1:])
        return np.hypot(down, right).sum() + ((u - image) ** 2).sum() / (2.0 * weight)

    best = minimize_total_variation(image, weight)
    least = cost(best)
    assert least < cost(image)
    for size in (0.3, 3.0):
        for _ in range(20):
            assert cost(best + rng.normal(0.0, size, image.shape)) > least
    assert all(cost(best + shift) > least for shift in (-1.0, 1.0))
    assert cost(0.9 * best + 0.1 * image) > least
