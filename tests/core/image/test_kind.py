"""The kind of an image is guessed from several signs of it; most images have none."""

from __future__ import annotations

import numpy as np
import pytest
import skimage.data
from scipy.ndimage import gaussian_filter, uniform_filter
from skimage.draw import disk

from cpm_core.image.kind import guess_kind

SIDE = 240
RNG = np.random.default_rng(5)


def line_art() -> np.ndarray:
    """Black ink on white paper, with soft edges."""
    row, col = np.indices((SIDE, SIDE))
    rings = np.sin(np.hypot(row - 120, col - 100) / 5.0) > 0.6
    return 255.0 * (1.0 - gaussian_filter(rings.astype(float), 0.5))


def fluorescence() -> np.ndarray:
    """Bright nuclei on a dark, slightly noisy background."""
    values = np.full((SIDE, SIDE), 6.0)
    for row, col in RNG.uniform(15, SIDE - 15, (25, 2)):
        values[disk((row, col), RNG.uniform(5, 9), shape=values.shape)] += RNG.uniform(60, 200)
    return RNG.poisson(gaussian_filter(values, 1.2)).astype(float)


def angiogram() -> np.ndarray:
    """Dark vessels before a smooth, uneven background."""
    row, col = np.indices((SIDE, SIDE))
    values = 110.0 + 0.25 * row + 0.1 * col
    for offset, slope, width in ((60, 0.3, 2.5), (150, -0.4, 2.0), (90, 0.9, 1.5)):
        away = np.abs(row - offset - slope * col - 12 * np.sin(col / 30.0))
        values -= 45.0 * np.exp(-((away / width) ** 2) / 2)
    return values + RNG.normal(0.0, 1.0, values.shape)


def ultrasound() -> np.ndarray:
    """Speckle that is wider than deep, on layers, around a dark lesion."""
    row, col = np.indices((SIDE, SIDE))
    echo = 60.0 + 70.0 * np.exp(-(((row % 80) - 40.0) ** 2) / 40.0)
    echo[np.hypot((row - 120) / 0.7, col - 120) < 45] = 8.0
    waves = RNG.normal(size=(2, SIDE, SIDE))
    speckle = np.hypot(*(uniform_filter(gaussian_filter(wave, (0.8, 2.6)), (1, 3)) for wave in waves))
    return np.sqrt(echo) * speckle / speckle.mean()


@pytest.mark.parametrize(
    ("draw", "kind"),
    [(line_art, "line art"), (fluorescence, "fluorescence"), (angiogram, "angiogram"), (ultrasound, "ultrasound")],
)
@pytest.mark.parametrize("scale", [1.0, 257.0])
def test_each_kind_is_guessed_whatever_its_range_of_gray_levels(draw, kind, scale) -> None:
    values = draw()
    assert guess_kind(scale * values + 3.0 * scale) == kind
    assert guess_kind(scale * values[:, ::-1]) == kind


@pytest.mark.parametrize(
    "name", ["camera", "coins", "moon", "page", "text", "brick", "grass", "gravel", "clock", "cell"]
)
def test_photographs_and_textures_are_of_no_kind(name) -> None:
    assert guess_kind(getattr(skimage.data, name)().astype(float)) is None


@pytest.mark.parametrize("values", [np.eye(8), np.ones((200, 200)), np.indices((200, 200))[0].astype(float)])
def test_images_without_signs_are_of_no_kind(values) -> None:
    assert guess_kind(values) is None
