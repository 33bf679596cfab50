"""All objects of an image: what contours bound, alone or together, each once, the likeliest first."""

import itertools

import numpy as np
import pytest
import scipy

from cpm_core.image.image import Image
from cpm_core.image.region import Region
from cpm_core.image.regions import Regions
from cpm_core.model.starts import uniform_grid
from cpm_core.objects import compute_iou
from cpm_core.objects.all_objects import predict_candidates
from cpm_core.objects.candidate_regions import CandidateRegions
from cpm_core.objects.confidence import estimate_among_siblings
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.merged_basins import MergedBasins
from cpm_core.objects.partition import Partition, partition_without_run
from cpm_core.objects.region_evidence import RegionEvidence
from cpm_core.objects.selection import Candidate
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.evolve import segment
from cpm_core.segmentation.select import select_all

ROW, COL = np.indices((120, 130)).astype(float)


def disk(row, col, radius):
    return np.hypot(ROW - row, COL - col) < radius


def picture(values):
    noise = np.random.default_rng(5).normal(0.0, 3.0, values.shape)
    return np.clip(scipy.ndimage.gaussian_filter(np.asarray(values, float), 0.8) + noise, 0.0, 255.0)


def best_overlaps(found, objects):
    return [max((compute_iou(one.mask, each) for one in found), default=0.0) for each in objects]


GRAINS = scipy.spatial.cKDTree([(r + 7 * (c % 2), 18 + 31 * c) for r in (15, 55, 95) for c in range(4)]).query(
    np.stack([ROW, COL], axis=-1)
)[1]
LINES = scipy.ndimage.morphological_gradient(GRAINS, 3) > 0
PAIR = [disk(60, 40, 17), disk(60, 70, 17) & ~disk(60, 40, 17)]


@pytest.fixture(scope="module")
def crowd():
    rng = np.random.default_rng(2)
    disks = [disk(r, c, rng.uniform(8, 12)) for r in (18, 58, 98) for c in (20, 50, 80, 110)]
    specks = sum(40.0 * disk(*rng.uniform(5, 115, 2), 1.5) for _ in range(12))
    return disks, select_all(picture(40.0 + 120.0 * np.any(disks, axis=0) + specks))


def test_regions_between_contours_that_meet_are_objects_and_the_lines_between_them_are_none():
    found = select_all(picture(np.where(LINES, 60.0, 170.0)))
    corners = 0, 3, 8, 11  # half of their boundary is the border of the image
    grains = [(number == GRAINS) & ~LINES for number in range(12)]
    assert min(best_overlaps(found, [grain for number, grain in enumerate(grains) if number not in corners])) > 0.9
    assert all(max(compute_iou(one.mask, grain) for grain in grains) > 0.7 for one in found)


def test_a_pair_that_touches_is_two_objects_that_meet_at_the_waist():
    found = select_all(picture(30.0 + 130.0 * np.any(PAIR, axis=0)))
    assert len(found) == 2
    assert min(best_overlaps(found, PAIR)) > 0.8


def test_each_object_is_found_once_and_is_likelier_than_specks_and_background(crowd):
    disks, found = crowd
    assert min(best_overlaps(found[: len(disks)], disks)) > 0.9
    assert all(one.confidence < 0.1 for one in found[len(disks) :])
    assert not any((one.mask & other.mask).any() for one, other in itertools.combinations(found, 2))


def test_the_likeliest_objects_come_first(crowd):
    confidences = [one.confidence for one in crowd[1]]
    assert confidences == sorted(confidences, reverse=True)
    assert confidences[0] > 0.7


def test_the_border_of_a_region_of_interest_bounds_no_object():
    border = [(30.0, 30.0), (30.0, 100.0), (90.0, 100.0), (90.0, 30.0)]
    interest = Regions(interest=[border]).contains(np.stack([ROW, COL], axis=-1).reshape(-1, 2)).reshape(ROW.shape)
    rectangle = Region.from_mask(interest & ~disk(60, 60, 12))
    whole, half = Region.from_mask(disk(60, 60, 12)), Region.from_mask(disk(60, 30, 12) & interest)
    found = CandidateRegions([], [], ROW, interest)
    assert [found.may_be_object(one) for one in (rectangle, whole, half)] == [False, True, True]
    everywhere = CandidateRegions([], [], ROW, np.ones(ROW.shape, bool))
    assert everywhere.may_be_object(Region.from_mask(np.ones(ROW.shape, bool)))  # of the image, another rule


def test_all_objects_of_an_image_are_those_of_a_run_from_everywhere_in_it():
    values = picture(np.where(LINES, 60.0, 170.0))
    run = segment(values, uniform_grid(values.shape), PRESETS["automatic"])
    assert [one.region for one in select_all(values)] == [one.region for one in run.objects]


def test_what_edges_bound_around_a_click_is_among_its_candidates_whatever_else_the_network_answers():
    levels = np.random.default_rng(5).permutation(np.linspace(60.0, 200.0, 12))
    cut = partition_without_run(Image(picture(levels[GRAINS])))
    for number in (2, 7, 11):
        depth = scipy.ndimage.distance_transform_edt(number == GRAINS)
        found = cut.find_candidates([np.unravel_index(depth.argmax(), depth.shape)])
        assert max(best_overlaps(found, [number == GRAINS])) > 0.9


def test_what_edges_bound_is_looked_for_in_a_part_of_a_large_image_however_far_apart_points_are(monkeypatch):
    widths, build = [], MergedBasins.from_edges
    monkeypatch.setattr(
        MergedBasins, "from_edges", lambda edges, *given: widths.append(edges.shape[1]) or build(edges, *given)
    )
    cut = partition_without_run(Image(np.random.default_rng(2).normal(100.0, 9.0, (40, 1600))))
    for apart in (1100, 400):
        assert cut.find_candidates([(20, 300), (20, 300 + apart)])
    assert widths == [256 + 401 + 256]


def test_a_grain_is_an_object_where_only_steps_of_gray_bound_it_and_some_are_faint():
    levels = np.random.default_rng(4).permutation(np.linspace(60.0, 200.0, 12))
    found = select_all(picture(levels[GRAINS]), parameters=Parameters(smoothing=1.5))
    overlaps = best_overlaps(found, [number == GRAINS for number in range(12)])
    assert np.count_nonzero(np.array(overlaps) > 0.8) >= 10
    assert not any((one.mask & other.mask).any() for one, other in itertools.combinations(found, 2))


def test_a_leaf_that_fills_half_of_the_image_is_the_likeliest_object_whole_with_its_veins():
    along, across = (ROW - 60) / 52, (COL - 65) / (34 * (1 - ((ROW - 60) / 52) ** 2)).clip(1e-3)
    leaf = (abs(along) < 1) & (abs(across) < 1)
    veins = leaf & (abs(COL - 65) < 1.5)
    soil = 15.0 * scipy.ndimage.gaussian_filter(np.random.default_rng(3).normal(size=leaf.shape), 3) / 0.09
    found = select_all(picture(np.where(leaf, 150.0 - 30.0 * veins, 60.0 + soil)))
    assert compute_iou(found[0].mask, leaf) > 0.9


def test_what_resembles_likely_objects_is_likelier_than_what_does_not():
    alone = estimate_among_siblings(0.4, 0.0, 0.0, 0.0)
    alike, unlike = (estimate_among_siblings(0.4, sign * 2.0, 2.0, 0.0) for sign in (1.0, -1.0))
    assert unlike < alike > alone
    assert estimate_among_siblings(0.4, 2.0, 2.0, 2.0) < alike


def test_leaves_that_lie_over_one_another_are_objects_and_not_the_whole_plant():
    plant, levels = np.zeros(ROW.shape, int), np.full(ROW.shape, 50.0)
    for number, turn in enumerate(np.deg2rad(72.0 * np.arange(5)), 1):
        along = (ROW - 60) * np.sin(turn) + (COL - 65) * np.cos(turn)
        across = (COL - 65) * np.sin(turn) - (ROW - 60) * np.cos(turn)
        leaf = ((along - 28) / 26) ** 2 + (across / 19) ** 2 < 1
        plant[leaf] = number
        levels = np.where(leaf, 130.0 + 14.0 * number + 15.0 * (abs(across) < 1), levels)
    found = select_all(picture(levels))
    overlaps = best_overlaps(found, [plant == number for number in range(1, 6)])
    assert np.count_nonzero(np.array(overlaps) > 0.5) >= 4
    assert max(compute_iou(one.mask, plant > 0) for one in found) < 0.5


def test_an_object_that_is_alone_in_its_image_stays_as_likely_as_it_is():
    disk = (ROW - 60) ** 2 + (COL - 60) ** 2 < 24**2
    (found,) = select_all(picture(np.where(disk, 160.0, 60.0)))
    assert compute_iou(found.mask, disk) > 0.95
    assert found.confidence >= 0.7


def evidence_in(values):
    result = segment(Image(values), uniform_grid(values.shape), PRESETS["automatic"])
    return RegionEvidence(ImageParts.from_partition(Partition.from_result(result)))


def test_what_points_in_regions_mean_is_each_a_candidate_once(crowd):
    disks, _ = crowd
    evidence = evidence_in(picture(40.0 + 120.0 * np.any(disks, axis=0)))
    selected = [one.region for one in predict_candidates(evidence) if not one.bounded]
    assert len(selected) >= 12
    assert max(one.compute_iou(other) for one, other in itertools.combinations(selected, 2)) < 0.8


def test_what_a_point_in_a_ring_means_has_its_hole():
    ring = disk(60, 60, 40) & ~disk(60, 60, 22)
    evidence = evidence_in(picture(40.0 + 120.0 * ring))
    rated, *selected = evidence.predict_candidates(Candidate(Region.from_mask(ring), bounded=True))
    assert rated.region.compute_iou(Region.from_mask(ring)) == 1.0
    assert selected
    assert not any(one.region.contains((60, 60)) for one in selected)


def test_what_the_crop_around_a_region_cuts_is_none_of_what_a_point_in_it_means():
    partition = partition_without_run(Image(picture(40.0 + 120.0 * disk(60, 60, 52))))
    windows = np.s_[8:113, 8:113], np.s_[50:71, 50:71]
    whole, part = (list(partition.predict_near(np.array([60, 60]), window)) for window in windows)
    assert max(compute_iou(one.mask, disk(60, 60, 52)) for one in whole) > 0.9
    assert max((one.mask.sum() for one in part), default=0) < 0.5 * 21**2  # what fills the crop is cut by it
