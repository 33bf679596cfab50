"""All bodies of a volume, split where they touch, and those that are similar to one."""

import tracemalloc

import numpy as np
import pytest
import scipy

import cpm_core as cpm
from cpm_core.image.region import Region
from cpm_core.objects import compute_iou
from cpm_core.objects.boundaries.inner_parts import find_inner_parts
from cpm_core.objects.boundaries.necks import split_at_clear_necks
from cpm_core.objects.confidence import (
    BodyFeatures,
    InnerFeatures,
    estimate_body_confidence,
    estimate_inner_confidence,
)
from tests.benchmarks.prior.bodies import scan

SHAPE = (30, 36, 66)
ONE, OTHER, APART, RADIUS = (14, 17, 13), (14, 17, 28), (15, 17, 52), 8.5


def ball(center):
    return np.linalg.norm(np.moveaxis(np.indices(SHAPE), 0, -1) - center, axis=-1) < RADIUS


def torus():
    plane, row, col = np.moveaxis(np.moveaxis(np.indices(SHAPE), 0, -1) - np.array([15.0, 17.0, 33.0]), -1, 0)
    return np.hypot(np.hypot(row, col) - 11.0, plane) < 3.5 + 1.5 * np.cos(2.0 * np.arctan2(row, col))


def partition(mask, spacing=(1.0, 1.0, 1.0)):
    values = np.random.default_rng(3).normal(20.0 + 100.0 * mask, 4.0)
    return cpm.VolumePartition(cpm.Image(values, spacing=spacing), Region.from_mask(mask).find_surface())


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (3.0, 3.0, 3.0)])
def test_touching_bodies_are_split_at_their_neck_and_one_alone_keeps_its_surface(spacing):
    there = partition(ball(ONE) | ball(OTHER) | ball(APART), spacing)
    found = cpm.select_all(there)
    assert len(found) == 3
    for center in (ONE, OTHER, APART):
        (held,) = (one for one in found if one.contains(np.array([center], float))[0])
        assert compute_iou(held.mask, ball(center)) > 0.95
        assert (held.region.surface is None) == (center != APART)
        assert 0.0 < held.confidence < 1.0


def test_a_body_whose_parts_are_not_convex_stays_whole():
    (found,) = cpm.select_all(partition(torus()))
    assert np.count_nonzero(found.mask != torus()) < 0.02 * np.count_nonzero(torus())


@pytest.mark.parametrize("holds", [False, True])
def test_a_body_is_not_cut_at_its_hollow_and_what_lies_in_it_is_split_off_at_a_narrow_neck(holds):
    plane, row, col = np.indices((48, 48, 80)) - np.array([23.5, 23.5, 39.5]).reshape(3, 1, 1, 1)
    away = np.sqrt(plane**2 + row**2 + col**2)
    body = np.hypot(np.hypot(plane, row), np.maximum(np.abs(col) - 16.0, 0.0)) < 20.0
    bridge = (np.abs(plane) < 2.0) & (np.abs(row) < 2.0) & (col > 0.0) & (away < 15.0)
    parts = split_at_clear_necks(body & ~(away < 12.0) | (holds & ((away < 9.0) | bridge)))
    assert parts.max() == 1 + holds
    if holds:
        assert compute_iou(parts == parts[24, 24, 40], away < 9.0) > 0.9


def test_a_steady_convex_body_is_likelier_than_a_ragged_speck():
    sure, doubtful = BodyFeatures(4.0, 0.94, 3000.0, 0.0), BodyFeatures(0.8, 0.6, 40.0, 0.0)
    assert estimate_body_confidence(sure) > 0.8
    assert estimate_body_confidence(doubtful) < 0.4


def test_a_round_inner_part_with_a_sharp_edge_is_likelier_than_a_ragged_blurred_or_uneven_one():
    sure = InnerFeatures(contrast=25.0, sharpness=0.9, unevenness=1.0, volume=500.0, sphericity=0.93)
    assert estimate_inner_confidence(sure) > 0.8
    for doubtful in (
        sure._replace(contrast=8.0, sphericity=0.6),
        sure._replace(contrast=8.0, sharpness=0.4),
        sure._replace(contrast=8.0, unevenness=3.0),
    ):
        assert estimate_inner_confidence(doubtful) < 0.5


def test_bodies_like_one_are_found_with_or_without_a_run_and_none_is_found_twice():
    there = partition(ball(ONE) | ball(OTHER) | ball(APART))
    first = cpm.VolumePartition(there.image).build_selection(Region.from_mask(ball(APART)), [APART])
    for volume in (there, there.image):
        found = cpm.select_all(volume, [first])
        assert found[0] is first
        assert sum(one.mask.astype(int) for one in found).max() == 1
        for one, center in zip(sorted(found[1:], key=lambda each: each.inside[0, 2]), (ONE, OTHER), strict=True):
            assert compute_iou(one.mask, ball(center)) > 0.9


def test_a_volume_is_run_from_everywhere_for_its_objects():
    values = cpm.example("ball")
    (found,) = cpm.select_all(values)
    (same,) = cpm.segment(values, cpm.seeds_everywhere(values), cpm.PRESETS["volume"]).objects
    assert found.has_same_region(same)
    assert found.confidence == same.confidence


@pytest.mark.parametrize(("seed", "noise"), [pytest.param(31, 12.0, marks=pytest.mark.long), (32, 40.0)])
def test_a_run_everywhere_in_a_scan_proposes_the_body_its_faint_organ_and_each_ball_of_a_clump_once(seed, noise):
    values, truths = scan(seed, (56, 64, 72), noise)
    result = cpm.segment(values, cpm.seeds_everywhere(values), cpm.PRESETS["volume"])
    found = result.objects
    assert len(found) == len(truths)
    for truth in truths.values():
        assert max(one.confidence for one in found if compute_iou(one.mask, truth) > 0.85) > 0.8
    there = cpm.VolumePartition.from_result(result)
    clump = truths["ball 1"] | truths["ball 2"] | truths["ball 3"]
    for name, whole in (("ball 1", clump), ("organ", truths["body"])):
        at = np.argwhere(truths[name]).mean(axis=0)
        assert compute_iou(there.select([at]).mask, truths[name]) > 0.85
        assert max(compute_iou(one.mask, whole | truths[name]) for one in there.find_candidates([at])) > 0.8


@pytest.mark.parametrize("seed", [0, *(pytest.param(each, marks=pytest.mark.long) for each in (1, 2))])
def test_no_wall_is_found_beyond_the_edge_of_what_is_brighter_within_something_bright(seed):
    away = np.linalg.norm(np.moveaxis(np.indices((56, 56, 56)), 0, -1) - 27.5, axis=-1)
    values = np.random.default_rng(seed).normal(np.select([away < 9.0, away < 24.0], [300.0, 40.0], -1000.0), 30.0)
    result = cpm.segment(values, cpm.seeds_everywhere(values), cpm.PRESETS["volume"])
    radii = np.linalg.norm(result.surface.vertices - 27.5, axis=-1)
    assert np.minimum(np.abs(radii - 9.0), np.abs(radii - 24.0)).max() < 2.0
    hollow, body = sorted(result.objects, key=lambda one: one.size)
    assert compute_iou(hollow.mask, away < 9.0) > 0.9
    assert compute_iou(body.mask, (away >= 9.0) & (away < 24.0)) > 0.9


@pytest.mark.parametrize("rise", [30.0, 80.0])
def test_what_lies_between_an_organ_and_a_wall_around_it_without_an_edge_belongs_to_the_body(rise):
    places = np.moveaxis(np.indices((40, 44, 48)), 0, -1) - np.array([20.0, 22.0, 23.0])
    body, organ = np.linalg.norm(places, axis=-1) < 17.0, np.linalg.norm(places - [2.0, -6.0, 4.0], axis=-1) < 6.0
    values = np.random.default_rng(1).normal(np.select([organ, body], [90.0 + rise, 90.0], 10.0), 5.0)
    found = cpm.segment(values, cpm.seeds_everywhere(values), cpm.PRESETS["volume"]).objects
    inner, rest = sorted((one.mask for one in found), key=np.count_nonzero)
    assert compute_iou(inner, organ) > 0.9
    assert compute_iou(rest, body & ~organ) > 0.98


@pytest.mark.parametrize("rise", [60.0, 200.0])
def test_a_small_part_of_a_body_ends_at_its_edge_however_much_it_differs(rise):
    places = np.moveaxis(np.indices((40, 40, 40)), 0, -1)
    part, body = (np.linalg.norm(places - at, axis=-1) < radius for at, radius in ((21.0, 5.0), (19.5, 18.0)))
    values = scipy.ndimage.gaussian_filter(np.select([part, body], [40.0 + rise, 40.0], -1000.0), 0.7)
    values += np.random.default_rng(2).normal(0.0, 10.0, body.shape)
    (found,) = find_inner_parts(values, Region.from_mask(body), np.ones(3))
    assert Region.from_mask(part).compute_iou(found) > 0.9


def test_parts_of_a_body_are_looked_for_in_few_bytes_of_each_of_its_voxels():
    values = np.random.default_rng(0).normal(40.0, 5.0, (64, 64, 64))
    body = Region.from_mask(np.ones(values.shape, bool))
    assert not list(find_inner_parts(values, body, np.ones(3)))
    tracemalloc.start()
    list(find_inner_parts(values, body, np.ones(3)))  # again: the first call imports
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 16 * values.size


@pytest.mark.parametrize("texture", [0.0, 12.0])
def test_neither_noise_nor_shading_nor_texture_is_a_part_of_a_body(texture):
    rng, away = np.random.default_rng(5), np.linalg.norm(np.moveaxis(np.indices((48, 48, 48)), 0, -1) - 23.5, axis=-1)
    body = away < 19.0
    pattern = scipy.ndimage.gaussian_filter(rng.normal(size=body.shape), 2.0)
    values = 20.0 + body * (100.0 + 0.8 * np.arange(48.0) + texture * pattern / pattern.std())
    there = cpm.VolumePartition(cpm.Image(rng.normal(values, 8.0)), Region.from_mask(body).find_surface())
    assert len(there.split_body(1)) == 1


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_click_in_or_beside_an_organ_as_faint_as_noise_selects_without_a_run_what_one_proposes(seed):
    places = np.moveaxis(np.indices((52, 56, 60)), 0, -1) - np.array([26.0, 28.0, 29.0])
    body, at = np.linalg.norm(places, axis=-1) < 23.0, np.array([3.0, -8.0, 5.0])
    organ = np.linalg.norm((places - at) / (1.0, 1.2, 0.9), axis=-1) < 8.0
    values = np.random.default_rng(seed).normal(np.select([organ, body], [75.0, 40.0], -1000.0), 30.0)
    image = cpm.Image(values)
    found = cpm.select_all(cpm.VolumePartition(image, Region.from_mask(body).find_surface()))
    rest, proposed = found
    assert compute_iou(proposed.mask, organ) > 0.8
    there, click = cpm.VolumePartition(image), at + np.array([26.0, 28.0, 29.0])
    chosen = there.select([click])
    np.testing.assert_array_equal(chosen.mask, proposed.mask)
    assert compute_iou(there.find_candidates([click])[-1].mask, body) > 0.9
    beside = there.select([(26, 45, 29)])
    assert compute_iou(beside.mask, rest.mask) > 0.97
    assert compute_iou(there.select(click[None], previous=beside).mask, body) > 0.97


def test_a_run_from_all_centers_of_a_volume_proposes_what_one_from_everywhere_does():
    values, truths = scan(33, (48, 56, 64), 20.0)
    found = cpm.segment(values, cpm.seeds_at_centers(values), cpm.PRESETS["volume"]).objects
    assert len(found) == len(truths)
    drawn = cpm.sphere(tuple(np.argwhere(truths["ball 1"]).mean(axis=0)), 2.0, 60)
    assert len(cpm.segment(values, drawn, cpm.PRESETS["volume"]).objects) == 1
