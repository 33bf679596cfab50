"""Heavy noise is taken out, edges stay, and what remains of it is under the floor."""

import numpy as np
import pytest

from cpm_core.field.edge_map import smoothed_gradient, vector_magnitudes
from cpm_core.image.denoising import minimize_total_variation, noise_level, remove_noise

from ..scenes import disk

SCENE = disk((128, 128), (63.0, 65.0), 35.0).values


def noisy(kind, seed=1):
    rng = np.random.default_rng(seed)
    if kind == "normal":
        return SCENE + rng.normal(0.0, 150.0, SCENE.shape)
    other = rng.uniform(0.0, 255.0, SCENE.shape) if kind == "uniform" else 255.0 * (rng.random(SCENE.shape) < 0.5)
    return np.where(rng.random(SCENE.shape) < 0.8, other, SCENE)


def off_the_circle(image, sigma):
    """Mean distance of the steepest place from the true circle, along rays [px]."""
    strength = vector_magnitudes(smoothed_gradient(image, sigma))
    angle = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)[:, None]
    radius = np.arange(20.0, 50.0, 0.5)
    rows = np.rint(63.0 + radius * np.sin(angle)).astype(int)
    cols = np.rint(65.0 + radius * np.cos(angle)).astype(int)
    return np.abs(radius[strength[rows, cols].argmax(axis=1)] - 35.0).mean()


@pytest.mark.parametrize("kind", ["normal", "uniform", "salt and pepper"])
def test_edges_are_nearer_to_their_place_than_total_variation_alone_leaves_them(kind):
    image = noisy(kind)
    cleaned = remove_noise(image)
    alone = minimize_total_variation(image, 1.75 * noise_level(image))
    assert off_the_circle(cleaned.image, cleaned.sigma) < min(1.3, off_the_circle(alone, 4.0))


@pytest.mark.parametrize("kind", ["normal", "uniform", "salt and pepper"])
def test_what_is_left_away_from_edges_is_under_the_floor(kind):
    row, col = np.indices(SCENE.shape)
    away = np.abs(np.hypot(row - 63.0, col - 65.0) - 35.0) > 12.0
    cleaned = remove_noise(noisy(kind))
    strength = vector_magnitudes(smoothed_gradient(cleaned.image, cleaned.sigma))
    assert np.mean(strength[away] > cleaned.floor * strength.max()) < 0.03
