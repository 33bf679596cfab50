"""Arrays of colors are images by one rule, that of files: luminance, one channel, or the one that varies the most."""

from __future__ import annotations

import numpy as np
import PIL.Image
import pytest

import cpm_core as cpm
from cpm_core.image.colors import COLOR_CHOICES

RGB = cpm.example("colors").colors.samples


@pytest.mark.parametrize("color", COLOR_CHOICES)
@pytest.mark.parametrize("opacity", [None, 255, 128])
def test_an_array_has_the_gray_levels_of_its_file(color, opacity, tmp_path):
    alpha = () if opacity is None else (np.full((*RGB.shape[:2], 1), opacity, np.uint8),)
    samples = np.concatenate([RGB, *alpha], axis=-1)
    PIL.Image.fromarray(samples).save(tmp_path / "colors.png")
    read = cpm.load_image(tmp_path / "colors.png", color=color)
    made = cpm.Image(samples, color=color)
    assert np.array_equal(made.values, read.values)
    assert made.notes == read.notes
    assert (made.colors is None) == (read.colors is None)


def test_a_run_takes_an_array_of_colors_and_a_channel():
    found = cpm.segment(RGB, cpm.circle((32, 32), 8), cpm.Parameters(channel="green"))
    assert found.channel == "green"
    assert found.contours[0].closed
    brightness = RGB[found.labels == 1][:, 1].astype(float)
    assert found.table()["intensity_mean"][0] == pytest.approx(brightness.mean())


def test_arrays_of_floats_and_of_more_bits_keep_their_range():
    assert cpm.Image(RGB / 255.0).values.max() <= 1.0
    deep = cpm.Image(RGB.astype(np.uint16) * 257)
    assert deep.values == pytest.approx(257.0 * cpm.Image(RGB).values)
