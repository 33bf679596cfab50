"""Settings for large images: as many scales as particles need, and no less smoothing than the noise asks for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.field.edge_map import automatic_smoothing
from cpm_core.image.pyramid import most_scales, shape_of_scale
from cpm_core.segmentation import large_images
from cpm_core.segmentation.large_images import large_image_settings

from ..scenes import disk

SCENE = disk((300, 300), (180.0, 190.0), 60.0).values


@pytest.fixture
def small_counts_as_large(monkeypatch):
    for name, value in (("LARGE", 100), ("_COARSEST", 64), ("_SAMPLE", 128)):
        monkeypatch.setattr(large_images, name, value)


@given(st.integers(2049, 40_000), st.integers(2049, 40_000))
def test_the_coarsest_scale_is_just_small_enough(rows, cols):
    scales = large_images.scales_for((rows, cols))
    assert max(shape_of_scale((rows, cols), scales - 1)) <= 512 < max(shape_of_scale((rows, cols), scales - 2))
    assert scales <= most_scales((rows, cols))


@pytest.mark.parametrize("noise", [5.0, 30.0, 60.0])
def test_the_smoothing_is_that_of_the_strongest_edge_not_of_the_empty_background(small_counts_as_large, noise):
    values = SCENE + np.random.default_rng(2).normal(0.0, noise, SCENE.shape)
    found = large_image_settings(values)
    assert found.scales == 4
    assert abs(found.smoothing - automatic_smoothing(values[120:240, 130:250])) <= 0.5
    assert found.smoothing >= (1.0 if noise < 10.0 else 1.5)
