"""Objects followed from page to page: laws on made stacks, whose disks are known on every page."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy

import cpm_core as cpm
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.image.image import as_image
from cpm_core.objects import compute_iou
from cpm_core.pages import ObjectFollower, PageFollower

from .drawn import MOVING, SHAPE


def inside(row, col, radius):
    rows, cols = np.indices(SHAPE)
    return np.hypot(rows - row, cols - col) < radius


def page(*disks):
    """A noisy image of bright disks, given as row, column and radius."""
    values = np.where(np.any([inside(*disk) for disk in disks], axis=0), 200.0, 40.0)
    return as_image(values + np.random.default_rng(len(disks)).normal(0.0, 4.0, SHAPE))


@cache
def partition_of(disks):
    """The partition of a page, which several tests have in common."""
    return cpm.partition(page(*disks))


def followed(pages, follower=None):
    """Follow the disks of the first page, and give what is found on each by number, with the events."""
    follower = follower or ObjectFollower()
    partition = partition_of(tuple(pages[0]))
    objects = {number: partition.build_selection(inside(*disk)) for number, disk in enumerate(pages[0], 1)}
    found, events = [objects], []
    for number, disks in enumerate(pages[1:], 2):
        follower.remember_page(partition.values, objects)
        partition = partition_of(tuple(disks))
        here, happened = follower.find_on_page(number, partition)
        objects = {one.number: one.selection for one in here}
        found.append(objects)
        events += [(event.kind, event.page, event.track, event.others) for event in happened]
    return found, events


def numbers(found, pages):
    """Numbers of the objects that are the disks of each page; 0 for a disk without one."""
    return [
        [next((n for n, one in objects.items() if compute_iou(one.mask, inside(*disk)) > 0.85), 0) for disk in disks]
        for objects, disks in zip(found, pages, strict=True)
    ]


@pytest.mark.parametrize("speed", [(0, 0), (2, 3), (4, -8)], ids=["rest", "slow", "nearly a diameter"])
def test_disks_that_move_and_grow_keep_their_numbers(speed):
    pages = [[(18 + speed[0] * t, 44 + speed[1] * t, 7 + t), (44, 20 + 4 * t, 8)] for t in range(4)]
    found, events = followed(pages)
    assert numbers(found, pages) == [[1, 2]] * 4
    assert events == []


def test_disks_keep_their_numbers_where_others_have_been_once_their_speed_is_known():
    """At last they move by more than half a diameter, so that each is as near to where the other one was."""
    pages = [[(30, 16 + col, 8), (30, 34 + col, 8)] for col in (0, 8, 17, 27)]
    found, _ = followed(pages)
    assert numbers(found, pages) == [[1, 2]] * 4


def test_a_disk_that_divides_is_a_split_and_two_that_unite_are_a_merge():
    apart = [[(32, 44, 12)], [(32, 35, 8), (32, 53, 8)], [(32, 32, 8), (32, 56, 8)]]
    found, events = followed(apart)
    assert [sorted(one) for one in numbers(found, apart)] == [[1], [1, 2], [1, 2]]
    assert events == [("splits", 2, 1, (2,))]
    together = [[(32, 35, 8), (32, 53, 8)], [(32, 44, 13)], [(32, 44, 13)]]
    found, events = followed(together)
    (number,) = found[1]
    assert number in (1, 2)
    assert events == [("merges", 2, 3 - number, (number,))]


def test_what_is_gone_is_reported_and_nothing_else_takes_its_number():
    pages = [[(30, 20, 8), (30, 60, 8)], [(30, 20, 8)], [(30, 22, 8), (30, 60, 8)]]
    found, events = followed(pages)
    assert numbers(found, pages) == [[1, 2], [1], [1, 0]]
    assert events == [("ends", 2, 2, ())]


@pytest.mark.parametrize("gone", [1, 2])
def test_what_is_gone_takes_no_equal_neighbor_that_moves(gone):
    """Rods side by side are nearer to each other than they are long, and the one that is left moves by a pixel."""
    rows, cols = np.indices(SHAPE)

    def rod(col):
        return np.hypot((rows - 32) / 15, (cols - col) / 4.5) < 1

    def rods(*places):
        noise = np.random.default_rng(1).normal(0.0, 4.0, SHAPE)
        return cpm.partition(as_image(np.where(np.any([rod(col) for col in places], axis=0), 200.0, 40.0) + noise))

    first, follower = rods(36, 49), ObjectFollower()
    follower.remember_page(first.values, {n: first.build_selection(rod(col)) for n, col in ((1, 36), (2, 49))})
    left, at = 3 - gone, 48 if gone == 1 else 37
    (found,), events = follower.find_on_page(2, rods(at))
    assert found.number == left
    assert compute_iou(found.selection.mask, rod(at)) > 0.85
    assert [(event.kind, event.track) for event in events] == [("ends", gone)]


def test_numbers_that_are_known_are_not_given_again():
    pages = [[(32, 44, 12)], [(32, 35, 8), (32, 53, 8)]]
    found, _ = followed(pages, ObjectFollower(7))
    assert sorted(found[1]) == [1, 8]


def test_accepted_objects_have_the_events_of_their_numbers_and_the_gray_values_of_their_pages():
    pages = [[(32, 44, 12)], [(32, 36, 7), (32, 52, 7)], [(32, 34, 7), (32, 54, 7)]]
    found, events = followed(pages)
    results = {}
    for number, (objects, disks) in enumerate(zip(found, pages, strict=True), 1):
        made = cpm.objects_result(list(objects.values()), page(*disks))
        named = [replace(one, group=sorted(objects)[one.group - 1]) for one in made.contours]
        results[number] = replace(made, contours=tuple(named))
    follower = PageFollower()
    told = [follower.add_page(number, result) for number, result in results.items()]
    assert [(one.kind, one.page, one.track, one.others) for each in told for one in each.events] == events
    assert [[one.number for one in each.contours] for each in told] == [[1], [1, 2], [1, 2]]
    for each, disks in zip(told, pages, strict=True):
        for contour in each.contours:
            mask = rasterize_labels([contour], SHAPE) > 0
            assert contour.gray == pytest.approx(page(*disks).values[mask].mean(), abs=1e-3)
        assert each.result.image is None


def test_a_page_of_another_size_holds_none_of_the_objects():
    follower = ObjectFollower()
    partition = partition_of(((30, 30, 8),))
    follower.remember_page(partition.values, {1: partition.build_selection(inside(30, 30, 8))})
    assert follower.find_on_page(2, cpm.partition(MOVING[0][:50])) == ((), ())


def test_an_object_between_the_centers_of_pixels_is_not_found_again_and_stops_no_other():
    disk = (32.0, 20.0, 9.0)
    partition = partition_of((disk,))
    follower, nothing = ObjectFollower(), partition.build_selection(np.zeros(SHAPE, bool))
    for _ in range(2):
        follower.remember_page(partition.values, {1: partition.select([disk[:2]]), 2: nothing})
    found, _ = follower.find_on_page(2, partition)
    assert [one.number for one in found] == [1]


def test_two_disks_that_come_to_overlap_stay_whole_and_no_pixel_of_one_lies_apart():
    found, _ = followed([[(32, 20 + 3 * step, 11), (36 + step // 2, 56 - 3 * step, 9)] for step in range(5)])
    assert len(found[-1]) == 2
    for one in found[-1].values():
        assert scipy.ndimage.label(one.mask)[1] == 1
