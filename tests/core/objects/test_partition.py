"""Objects chosen by clicks in scenes whose boundaries are known."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import PRESETS, Image, Regions, circle, partition, segment

from ..scenes import antialiased, disk, ring

SHAPE = (96, 96)


def overlap(mask, truth):
    return np.count_nonzero(mask & truth) / np.count_nonzero(mask | truth)


def truth_of(scene):
    return scene.values > 120.0


@pytest.fixture(scope="module")
def disk_scene():
    return disk(SHAPE, (47.3, 46.6), 24.4)


@pytest.fixture(scope="module")
def disk_partition(disk_scene):
    return partition(disk_scene.values)


def test_a_click_in_a_disk_gives_the_disk(disk_scene, disk_partition):
    chosen = disk_partition.select([(47, 47)])
    assert overlap(chosen.mask, truth_of(disk_scene)) > 0.98
    assert len(chosen.contours) == 1
    assert chosen.contours[0].closed
    assert disk_scene.distance(chosen.contours[0].points).max() < 1.5
    assert chosen.gaps == ()
    assert chosen.confidence == pytest.approx(1.0)
    assert chosen.remark == ""


def test_every_pixel_has_a_face_and_no_face_lies_on_both_sides_of_the_contour(disk_scene, disk_partition):
    labels, truth = disk_partition.labels, truth_of(disk_scene)
    assert labels.shape == SHAPE == disk_partition.shape
    assert labels.min() == 0
    away = disk_scene.distance(np.indices(SHAPE).reshape(2, -1).T.astype(float)).reshape(SHAPE)
    assert not set(labels[truth & (away > 1.5)]) & set(labels[~truth & (away > 1.5)])


def test_the_circle_of_a_start_counts_as_clicks(disk_scene):
    seeds = circle((47, 47), 8.0)
    chosen = partition(segment(disk_scene.values, seeds, PRESETS["shape"])).select(seeds)
    assert overlap(chosen.mask, truth_of(disk_scene)) > 0.98


def test_a_hole_that_is_said_to_be_outside_stays_one():
    scene = ring(SHAPE, (47.3, 46.6), 10.0, 30.0)
    chosen = partition(scene.values).select([(47, 67)], [(47, 47)])
    assert overlap(chosen.mask, truth_of(scene)) > 0.96
    assert len(chosen.contours) == 2


def test_a_place_outside_the_image_counts_as_the_nearest_one_in_it_and_is_told():
    values = antialiased(SHAPE, lambda row, col: row - 0.0 * col < 40.0)
    chosen = partition(values).select([(-9.0, 40.0)], [(90, 40)])
    assert overlap(chosen.mask, values > 120.0) > 0.97
    assert "outside the image" in chosen.remark


def test_nothing_inside_gives_nothing_and_a_word(disk_partition):
    chosen = disk_partition.select([], [(3, 3)])
    assert not chosen.mask.any()
    assert chosen.contours == ()
    assert chosen.remark


def test_places_of_another_shape_are_refused(disk_partition):
    with pytest.raises(ValueError, match="must be \\(N, 2\\)"):
        disk_partition.select([(1.0, 2.0, 3.0)])


def test_nothing_outside_the_regions_of_interest_is_selected(disk_scene):
    regions = Regions(interest=(((-1, -1), (-1, 60.5), (97, 60.5), (97, -1)),))
    result = segment(disk_scene.values, circle((47, 47), 8.0), regions=regions)
    chosen = partition(result).select([(47, 47)])
    within = np.indices(SHAPE)[1] < 60.5
    assert overlap(chosen.mask, truth_of(disk_scene) & within) > 0.97


def test_a_result_without_an_image_is_refused(disk_scene):
    result = segment(Image(disk_scene.values), circle((47, 47), 8.0))
    with pytest.raises(ValueError, match="does not know its image"):
        partition(replace(result, image=None))
