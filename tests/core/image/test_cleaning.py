"""Heavy noise is taken out, edges stay, and what remains of it is under the floor."""

import numpy as np
import pytest
from scipy import ndimage

from cpm_core.field.edge_map import gradient, magnitude
from cpm_core.image.denoising import clean, noise_level, total_variation

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
    strength = magnitude(gradient(image, sigma))
    angle = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)[:, None]
    radius = np.arange(20.0, 50.0, 0.5)
    rows = np.rint(63.0 + radius * np.sin(angle)).astype(int)
    cols = np.rint(65.0 + radius * np.cos(angle)).astype(int)
    return np.abs(radius[strength[rows, cols].argmax(axis=1)] - 35.0).mean()


@pytest.mark.parametrize("kind", ["normal", "uniform", "salt and pepper"])
def test_edges_are_nearer_to_their_place_than_total_variation_alone_leaves_them(kind):
    image = noisy(kind)
    cleaned = clean(image)
    alone = total_variation(image, 1.75 * noise_level(image))
    assert off_the_circle(cleaned.image, cleaned.sigma) < min(1.3, off_the_circle(alone, 4.0))


@pytest.mark.parametrize("kind", ["normal", "uniform", "salt and pepper"])
def test_what_is_left_away_from_edges_is_under_the_floor(kind):
    row, col = np.indices(SCENE.shape)
    away = np.abs(np.hypot(row - 63.0, col - 65.0) - 35.0) > 12.0
    cleaned = clean(noisy(kind))
    strength = magnitude(gradient(cleaned.image, cleaned.sigma))
    assert np.mean(strength[away] > cleaned.floor * strength.max()) < 0.03


def test_heavier_noise_gives_a_coarser_result():
    noise = np.random.default_rng(3).normal(size=SCENE.shape)
    found = [clean(SCENE + strength * noise) for strength in (60.0, 120.0, 240.0, 480.0)]
    sigmas, floors = [c.sigma for c in found], [c.floor for c in found]
    assert sigmas == sorted(sigmas) and sigmas[-1] > sigmas[0]
    assert floors == sorted(floors) and 0.0 < floors[0] < floors[-1] < 0.5


@pytest.mark.parametrize("kind", ["normal", "uniform"])
def test_it_follows_contrast_and_brightness(kind):
    image = noisy(kind)
    once, other = clean(image), clean(40.0 - 2.0 * image)
    # single precision, and which class a gray strength between two is counted in
    assert np.abs(other.image - (40.0 - 2.0 * once.image)).mean() < 2.0
    assert other.sigma == pytest.approx(once.sigma, rel=0.02)
    assert other.floor == pytest.approx(once.floor, rel=0.05)


@pytest.mark.parametrize("shape", [(3, 3), (9, 14), (31, 8)])
def test_small_images_of_odd_sizes_keep_their_shape(shape):
    cleaned = clean(np.random.default_rng(4).normal(0.0, 50.0, shape))
    assert cleaned.image.shape == shape
    assert np.isfinite(cleaned.image).all()


def test_texture_counts_as_noise_of_the_strength_that_it_has_on_the_scale_of_edges():
    """Texture with a grain leaves no more than white noise does that is as strong in means over many pixels."""
    row, col = np.indices(SCENE.shape)
    away = np.abs(np.hypot(row - 63.0, col - 65.0) - 35.0) > 12.0
    texture = ndimage.gaussian_filter(np.random.default_rng(5).normal(size=SCENE.shape), 1.0, mode="wrap")
    cleaned = clean(0.5 * SCENE + 20.0 * texture / texture.std())
    strength = magnitude(gradient(cleaned.image, cleaned.sigma))
    assert np.mean(strength[away] > cleaned.floor * strength.max()) < 0.03
