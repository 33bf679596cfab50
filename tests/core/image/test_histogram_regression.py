"""The regression keeps gray levels that are more frequent in one region than in another."""

import numpy as np
import pytest

from cpm_core.image.denoising import regress_gray_levels

HALVES = np.where(np.indices((120, 120))[1] < 60, 40.0, 200.0)
RNG = np.random.default_rng(1)


def step_and_noise(image):
    left, right = image[:, :60], image[:, 60:]
    return right.mean() - left.mean(), np.sqrt(0.5 * (left.var() + right.var()))


@pytest.mark.parametrize("share", [0.6, 0.9])
def test_levels_that_objects_have_kept_stand_out_of_replaced_pixels(share):
    replaced = RNG.random(HALVES.shape) < share
    image = np.where(replaced, RNG.uniform(0.0, 255.0, HALVES.shape), HALVES)
    (before, noise_before), (after, noise_after) = (
        step_and_noise(image),
        step_and_noise(regress_gray_levels(image, HALVES)),
    )
    assert after == pytest.approx(before, rel=0.1)
    assert noise_after < 0.6 * noise_before
