"""The prior: its network against sums over pixels, its windows against what they show, its answers on drawn objects."""

import time
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files

import numpy as np
import pytest
import scipy.ndimage as ndi
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.objects.prior.crops import NETWORK_LUMINANCE_WEIGHTS, Crop2D, ImageSampler, sample_bilinear
from cpm_core.objects.prior.network import Network
from cpm_core.objects.prior.object_predictor import ObjectPredictor, Prompt

SIDE = 128
ROW, COL = np.indices((SIDE, SIDE))


def overlap(one, other):
    return np.count_nonzero(one & other) / np.count_nonzero(one | other)


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_a_convolution_is_the_rectified_sum_over_the_neighbors(seed):
    random = np.random.default_rng(seed)
    maps = random.normal(size=(3, 5, 7)).astype(np.float32)
    weights = random.normal(size=(2, 3, 3, 3)).astype(np.float32)
    network = Network({"layer": weights.reshape(2, -1), "layer.offset": np.float32([0.5, -0.5])})
    sums = [
        sum(ndi.correlate(each, kernel[..., k], mode="constant") for k, each in enumerate(maps)) + offset
        for kernel, offset in zip(weights, (0.5, -0.5), strict=True)
    ]
    np.testing.assert_allclose(network._convolve_rectified(maps, "layer"), np.maximum(sums, 0.0), atol=1e-4)


def test_the_weights_are_small_and_their_origin_is_stated():
    there = files("cpm_core.objects.prior")
    assert len(there.joinpath("weights.npz").read_bytes()) <= 2_000_000
    origin = there.joinpath("weights.md").read_text("utf-8")
    assert all(word in origin for word in ("Data", "Terms", "Seed", "grow.py"))


@settings(deadline=None, max_examples=20)
@given(st.floats(48, 80), st.floats(48, 80), st.floats(20, 90))
def test_what_goes_into_a_window_comes_back(row, col, side):
    ramp = (ROW + 2.0 * COL).astype(np.float32)
    window = Crop2D(np.array([row, col]), side)
    box, back = window.map_back(sample_bilinear(ramp[..., None], *window.axis_positions)[..., 0], ramp.shape)
    inner = np.s_[2:-2, 2:-2]
    np.testing.assert_allclose(back[inner], ramp[box][inner], atol=0.02)


@settings(deadline=None, max_examples=10)
@given(st.floats(1e-3, 1e4), st.floats(-1e4, 1e4))
def test_what_is_seen_does_not_depend_on_the_units_of_gray_levels(factor, offset):
    values = ndi.gaussian_filter(np.random.default_rng(1).normal(size=(SIDE, SIDE)), 3.0)
    window = Crop2D(np.array([60.0, 50.0]), 60.0)
    np.testing.assert_allclose(
        ImageSampler(factor * values + offset).sample_crop(window),
        ImageSampler(values).sample_crop(window),
        rtol=1e-2,
        atol=2e-2,
    )


def test_threads_that_need_the_same_level_of_a_pyramid_compute_it_once(monkeypatch):
    computed, normalize = [], ImageSampler._normalize_grays

    def normalize_slowly(sampler, values):
        computed.append(values.shape[:2])
        time.sleep(0.1)
        return normalize(sampler, values)

    monkeypatch.setattr(ImageSampler, "_normalize_grays", normalize_slowly)
    sampler, window = ImageSampler(np.random.default_rng(1).normal(size=(400, 400))), Crop2D(np.full(2, 200.0), 440.0)
    with ThreadPoolExecutor(3) as threads:
        one, *others = threads.map(sampler.sample_crop, [window] * 3)
    assert computed == [(200, 200)]
    assert all((one == other).all() for other in others)


@pytest.mark.parametrize("bright", [True, False])
@pytest.mark.parametrize("axes", [(9.0, 9.0), (20.0, 14.0), (30.0, 25.0)])
def test_a_click_in_an_ellipse_finds_it_without_any_contour(axes, bright):
    mask = ((ROW - 60.0) / axes[0]) ** 2 + ((COL - 55.0) / axes[1]) ** 2 <= 1.0
    values = 100.0 + (60.0 if bright else -60.0) * ndi.gaussian_filter(1.0 * mask, 1.0)
    values += np.random.default_rng(0).normal(0.0, 3.0, mask.shape)
    assert overlap(next(ObjectPredictor(values).predict_objects(Prompt(np.array([[60, 55]])))).mask, mask) > 0.85


def test_a_point_in_a_narrow_bay_of_a_large_object_cuts_out_the_bay():
    row, col = np.indices((400, 400))
    disk = np.hypot(row - 200, col - 200) <= 170
    bay = disk & (np.abs(col - 120) <= 4) & (row < 160)
    values = 100.0 + 60.0 * ndi.gaussian_filter(1.0 * (disk & ~bay), 1.0)
    values += np.random.default_rng(0).normal(0.0, 3.0, disk.shape)
    prompt = Prompt(np.array([[250, 250]]), np.array([[115, 120]]), previous_mask=disk)
    cut = disk & ~next(ObjectPredictor(values).predict_objects(prompt)).mask
    assert overlap(cut & (np.abs(col - 120) <= 25) & (row < 185), bay) > 0.62


def answers(*given):
    """What a network answers, of pairs of a map of probabilities and an estimated overlap."""
    maps, overlaps = zip(*given, strict=True)
    return np.stack(maps).astype(np.float32), np.float32(overlaps)


def test_all_that_a_click_may_mean_in_one_crop_is_offered():
    row, col = np.indices((300, 300))
    small, large = (np.hypot(row - 150, col - 150) < radius for radius in (30, 100))

    def answer(maps):
        """Answer with what is bright, or all that is not dark; then with that of which most was given."""
        share = (maps[0] - maps[0].min()) / max(np.ptp(maps[0]), 1e-9)
        if maps[8].any():
            return answers((share > (0.75 if np.median(share[maps[8] > 0.5]) > 0.75 else 0.25), 0.9))
        return answers((share > 0.75, 0.5), (share > 0.25, 0.8))

    prompt = Prompt(np.array([[150, 150]]))
    found = [one.mask for one in ObjectPredictor(100.0 * small + 100.0 * large, network=answer).predict_objects(prompt)]
    assert all(max(overlap(one, disk) for one in found) > 0.95 for disk in (small, large))


def test_what_covers_most_of_the_image_comes_after_what_is_smaller_and_holds_the_click():
    prompt, seen = Prompt(np.array([[60, 55]])), []

    def answer(maps):
        """Answer with what is near the click in small crops, and, of a better score, with all of the two largest."""
        seen.append(maps)
        is_large = len(seen) in (count - 1, count) or maps[8].mean() > 0.3
        return answers((np.where(is_large, 1.0, maps[5]), 0.9 if is_large else 0.5))

    predictor = ObjectPredictor(np.zeros((SIDE, SIDE)), network=answer)
    count = len(list(predictor._propose_crops(prompt)))
    shares = [one.mask.mean() for one in predictor.predict_objects(prompt)]
    large = [share > 0.5 for share in shares]
    assert set(large) == {False, True}
    assert large == sorted(large), shares


def test_what_is_cut_at_the_sides_of_its_crop_comes_after_what_is_whole():
    row, col = np.indices((600, 600))
    disk = np.hypot(row - 300, col - 300) < 150

    def answer(maps):
        """Answer with what is bright, and, of a better score, with all of a crop in which nothing is seen."""
        is_flat = np.ptp(maps[0]) < 0.5
        return answers((np.where(is_flat, 1.0, maps[0] > 0.0), 0.9 if is_flat else 0.5))

    first, *others = ObjectPredictor(200.0 * disk, network=answer).predict_objects(Prompt(np.array([[300, 300]])))
    assert overlap(first.mask, disk) > 0.95
    assert overlap(others[-1].mask, disk) < 0.9


def test_of_answers_that_are_about_as_likely_the_one_that_is_more_likely_as_refined_comes_first():
    row, col = np.indices((600, 600))
    disk, seen = np.hypot(row - 300, col - 300) < 150, []

    def answer(maps):
        """Answer with what is near the click where the disk fills the crop, which is likely in the first one alone."""
        seen.append(maps)
        if np.ptp(maps[0]) < 0.5:
            return answers((maps[5] > 0.5, 0.9 if len(seen) == 1 else 0.2))
        return answers((maps[0] > 0.0, 0.87))

    first, *others = ObjectPredictor(200.0 * disk, network=answer).predict_objects(Prompt(np.array([[300, 300]])))
    assert overlap(first.mask, disk) > 0.95
    assert overlap(others[0].mask, disk) < 0.5


def test_objects_of_one_brightness_are_told_apart_by_color():
    mask = np.hypot(ROW - 60.0, COL - 60.0) < 25.0
    color = np.where(mask[..., None], [180.0, 90.0, 110.0], [60.0, 153.0, 97.0])
    image = cpm.Image(np.clip(color + np.random.default_rng(2).normal(0.0, 4.0, color.shape), 0, 255).astype(np.uint8))
    assert np.ptp(ndi.gaussian_filter(image.colors.samples @ NETWORK_LUMINANCE_WEIGHTS, 4.0)) < 3.0
    assert overlap(cpm.select(image, [(60, 60)]).mask, mask) > 0.8
