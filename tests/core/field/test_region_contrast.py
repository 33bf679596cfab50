"""The contrast of the regions on both sides of an edge."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import Contour, Engine
from cpm_core.field.region_contrast import region_contrast
from cpm_core.model.starts import uniform_grid
from cpm_core.parameters import Parameters
from cpm_core.reconstruction import find_contours
from cpm_core.segmentation.evolve import segment

POINTS = np.stack([np.linspace(30.0, 70.0, 15), np.full(15, 49.5)], axis=1)
NORMALS = np.tile([0.0, 3.0], (15, 1))


def halves(left, right, noise=0.0):
    image = np.full((100, 100), float(left))
    image[:, 50:] = right
    return image + noise * np.random.default_rng(4).normal(size=image.shape)


@pytest.mark.parametrize("noise", [5.0, 20.0, 60.0])
def test_noise_takes_contrast_as_its_strength_says(noise):
    found = region_contrast(halves(50, 110, noise), POINTS, NORMALS, 1.0).mean()
    # interpolation between pixels quiets the noise by up to a half
    assert 60.0 / (60.0 + noise) - 0.05 < found < 60.0 / (60.0 + 0.5 * noise) + 0.05


def test_the_contrast_of_a_contour_is_the_mean_along_it_and_stays_with_it_elsewhere():
    engine = Engine(halves(50, 110, 10.0), Parameters())
    state = engine.start(uniform_grid((100, 100)))
    for _ in range(60):
        state = engine.step(state, Parameters())
    found, *_ = find_contours(state.position, engine.scale_field(Parameters()), Parameters())
    assert found
    for contour in found:
        expected = engine.scale_field(Parameters()).contrast_at(contour.points).mean()
        assert contour.contrast == pytest.approx(expected, rel=1e-12)
        assert replace(contour, points=2.0 * contour.points).contrast == contour.contrast
    assert Contour(POINTS, closed=False).contrast == 0.0


def test_texture_is_left_out_and_the_object_stays():
    rng = np.random.default_rng(5)
    image = np.full((128, 128), 60.0)
    row, col = np.indices(image.shape)
    for _ in range(60):  # blobs of both signs on the background only
        r, c = rng.uniform(0, 128, 2)
        image += rng.choice([-25.0, 25.0]) * np.exp(-((row - r) ** 2 + (col - c) ** 2) / (2 * 1.8**2))
    image[np.hypot(row - 64, col - 64) < 34] = 160.0
    seeds = uniform_grid(image.shape)
    every = segment(image, seeds, Parameters(w1=0.6, w2=0.7, beta=0.4)).contours
    chosen = segment(image, seeds, Parameters(w1=0.6, w2=0.7, beta=0.4, min_contrast=0.7)).contours
    assert len(every) > 3
    assert len(chosen) == 1
    assert chosen[0].closed
    assert np.abs(np.hypot(*(chosen[0].points - 64.0).T) - 34.0).max() < 1.5
    assert chosen[0].contrast > 0.8
