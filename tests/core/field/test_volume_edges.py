"""The edge map of a volume in bricks is the whole one wherever it counts."""

import numpy as np
import pytest
import scipy

from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.volume_edges import SLOPE_ONSET, EdgeBricks, VolumeSlopes
from cpm_core.field.volume_field import smooth_volume


@pytest.mark.parametrize("pitch", [(1.0, 1.0, 1.0), (1.0, 2.5, 1.5)])
@pytest.mark.parametrize("limited", [False, True])
def test_edges_are_those_of_the_whole_volume_near_all_that_count(pitch, limited):
    rng = np.random.default_rng(0)
    smoothed = scipy.ndimage.gaussian_filter(rng.normal(0.0, 100.0, (30, 41, 36)), 3.0).astype(np.float32)
    inside = np.indices(smoothed.shape).sum(axis=0) < 60 if limited else None
    slopes = VolumeSlopes.from_volume(smoothed, pitch, inside)
    whole = slopes.edge_strengths(0, len(smoothed))
    truth = np.sqrt(sum(g**2 for g in np.gradient(smoothed, *pitch))) * (1.0 if inside is None else inside)
    inner = (slice(1, -1),) * 3
    np.testing.assert_allclose(whole[inner], truth[inner], rtol=1e-4, atol=1e-5)
    floor = float(np.quantile(whole, 0.97))
    edges = EdgeBricks.from_slopes(slopes, floor)
    assert edges.voxels_above(floor).tolist() == np.argwhere(whole >= np.float32(floor)).tolist()
    places = rng.uniform(-1.0, 42.0, (20_000, 3))
    strength, found = interpolate_field(whole[None], places)[:, 0], edges.strengths_at(pitch, places * pitch)
    counts = strength >= SLOPE_ONSET * floor
    np.testing.assert_allclose(found[counts], strength[counts], rtol=1e-6)
    shift = rng.normal(size=(20_000, 3))
    near = places + shift / np.linalg.norm(shift, axis=1)[:, None] * 2.0 / np.array(pitch)
    strength, found = interpolate_field(whole[None], near)[counts, 0], edges.strengths_at(pitch, near * pitch)[counts]
    np.testing.assert_allclose(found, strength, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("sigmas", [[0.7, 0.7, 0.7], [3.0, 0.0, 1.5]])
def test_a_volume_is_smoothed_axis_by_axis(sigmas):
    values = np.random.default_rng(0).normal(100.0, 20.0, (9, 12, 31))
    truth = scipy.ndimage.gaussian_filter(values, sigmas, mode="nearest")
    np.testing.assert_allclose(smooth_volume(values, sigmas), truth, rtol=1e-6)
