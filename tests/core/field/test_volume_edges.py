"""The edge map of a smoothed volume."""

import numpy as np
import pytest
import scipy

from cpm_core.field.edge_map import volume_edge_map
from cpm_core.field.volume_field import smooth_volume


@pytest.mark.parametrize("pitch", [(1.0, 1.0, 1.0), (1.0, 2.5, 1.5)])
@pytest.mark.parametrize("limited", [False, True])
def test_the_edge_map_of_a_volume_is_the_size_of_its_gradient(pitch, limited):
    rng = np.random.default_rng(0)
    smoothed = scipy.ndimage.gaussian_filter(rng.normal(0.0, 100.0, (30, 41, 36)), 3.0).astype(np.float32)
    inside = np.indices(smoothed.shape).sum(axis=0) < 60 if limited else None
    whole = volume_edge_map(smoothed, pitch, inside)
    truth = np.sqrt(sum(g**2 for g in np.gradient(smoothed, *pitch))) * (1.0 if inside is None else inside)
    inner = (slice(1, -1),) * 3
    np.testing.assert_allclose(whole[inner], truth[inner], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("sigmas", [[0.7, 0.7, 0.7], [3.0, 0.0, 1.5]])
def test_a_volume_is_smoothed_axis_by_axis(sigmas):
    values = np.random.default_rng(0).normal(100.0, 20.0, (9, 12, 31))
    truth = scipy.ndimage.gaussian_filter(values, sigmas, mode="nearest")
    np.testing.assert_allclose(smooth_volume(values, sigmas), truth, rtol=1e-6)
