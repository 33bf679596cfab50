"""Following of objects from page to page: the laws of tracks, by disks whose places are known."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

import cpm_core as cpm
from cpm_core.contours.contour import Contour
from cpm_core.pages import PageFollower, StackResult
from cpm_core.pages.tracks import Tracker
from cpm_core.shapes import Polygon

from .drawn import MOVING, SHAPE, SPLITTING


def tracks_of(pages):
    return [sorted(contour.number for contour in page.contours) for page in pages]


def events_of(pages):
    return [(event.kind, event.page, event.track, event.others) for page in pages for event in page.events]


def test_a_disk_that_moves_and_grows_is_one_track_with_its_area_on_every_page():
    pages = list(cpm.follow_pages(MOVING, cpm.circle((32, 22), 5.0)))
    assert tracks_of(pages) == [[1]] * 5
    assert events_of(pages) == []
    for step, found in enumerate(pages):
        (contour,) = found.contours
        assert contour.closed
        assert contour.area == pytest.approx(np.pi * (9 + step) ** 2, rel=0.02)
        assert cpm.measure(found.contours)[0].contrast > 0.8


def test_without_following_each_page_is_the_run_that_it_would_be_alone():
    seeds = cpm.circle((32, 30), 12.0)
    for found, values in zip(cpm.follow_pages(MOVING[:2], seeds, fresh=True), MOVING[:2], strict=True):
        (alone,) = cpm.segment(values, seeds).contours
        (contour,) = found.contours
        np.testing.assert_array_equal(contour.points, np.round(alone.points, 4))


def test_a_disk_that_splits_gives_its_track_to_one_part_and_the_other_tells_where_it_comes_from():
    pages = list(cpm.follow_pages(SPLITTING, cpm.circle((32, 44), 5.0)))
    assert tracks_of(pages) == [[1], [1], [1], [1, 2], [1, 2]]
    assert events_of(pages) == [("splits", 4, 1, (2,))]
    assert pages[3].events[0].sentence == "Page 4: track 2 splits off track 1."
    assert [track.origin for track in StackResult("", 5, tuple(pages)).tracks] == [0, 1]


def test_a_page_that_cannot_be_used_is_a_sentence_and_the_tracks_go_on_after_it():
    bad = np.where(np.arange(SHAPE[1]) == 3, np.inf, MOVING[2])
    pages = list(cpm.follow_pages([MOVING[0], np.full(SHAPE, 7.0), bad, MOVING[1]], cpm.circle((32, 22), 5.0)))
    assert [page.result is None for page in pages] == [False, True, True, False]
    assert "constant" in pages[1].error
    assert "infinite" in pages[2].error
    assert tracks_of(pages) == [[1], [], [], [1]]


def test_pages_are_followed_in_the_order_that_is_asked_for():
    backwards = list(cpm.follow_pages(MOVING, cpm.circle((32, 50), 5.0), numbers=[5, 4, 3]))
    assert [page.number for page in backwards] == [5, 4, 3]
    assert tracks_of(backwards) == [[1], [1], [1]]


def test_the_next_page_starts_from_shapes_along_the_contours_of_the_last_one_that_has_any():
    follower = PageFollower()
    first = follower.add_page(1, cpm.segment(MOVING[0], cpm.circle((32, 22), 5.0)))
    follower.add_page(2, replace(first.result, contours=()))
    (start,) = follower.next_starts
    assert isinstance(start, Polygon)
    assert Contour(np.array(start.points), True).area == pytest.approx(first.contours[0].area, rel=0.05)


def box(top, left, height, width, closed=True):
    corners = np.array([[top, left], [top, left + width], [top + height, left + width], [top + height, left]], float)
    return Contour(corners, closed)


@pytest.mark.parametrize(
    ("before", "now", "numbers", "kinds"),
    [
        ([box(10, 10, 20, 20)], [box(14, 14, 20, 20), box(40, 40, 9, 9)], [1, 2], ["begins"]),
        ([box(10, 10, 40, 40), box(20, 20, 20, 20)], [box(11, 11, 40, 40)], [1], ["ends"]),
        ([box(20, 20, 20, 20), box(10, 10, 40, 40)], [box(10, 10, 40, 40), box(20, 20, 20, 20)], [2, 1], []),
        ([box(10, 10, 20, 20)], [box(12, 10, 20, 20, closed=False)], [1], []),
        ([box(10, 10, 20, 20)], [box(40, 50, 20, 20)], [2], ["ends", "begins"]),
        ([box(40, 66, 20, 20)], [box(10, 10, 20, 20)], [2], ["leaves", "begins"]),
        ([box(10, 10, 20, 20)], [box(14, 14, 20, 20), box(40, 66, 20, 20)], [1, 2], ["enters"]),
        ([box(10, 10, 30, 50)], [box(10, 10, 30, 14), box(10, 28, 30, 14), box(10, 46, 30, 14)], [1, 2, 3], ["splits"]),
        ([box(10, 10, 30, 14), box(10, 28, 30, 32)], [box(10, 10, 30, 50)], [2], ["merges"]),
    ],
    ids=["begins", "a hole ends", "nested", "opens", "jumps", "leaves", "enters", "three parts", "merges"],
)
def test_tracks_follow_by_overlap(before, now, numbers, kinds):
    tracker = Tracker()
    tracker.assign_tracks(1, before, SHAPE)
    contours, events = tracker.assign_tracks(2, now, SHAPE)
    assert [contour.number for contour in contours] == numbers
    assert [event.kind for event in events] == kinds


def test_the_strength_of_contours_on_pages_is_measured_as_that_of_objects_whatever_a_run_was_smoothed_by():
    row, col = np.indices((64, 64))
    values = scipy.ndimage.gaussian_filter(40.0 + 120.0 * (np.hypot(row - 32, col - 32) < 14), 1.0)
    strengths = []
    for objects in (False, True):
        for preset in ("shape", "fluorescence"):
            (page,) = cpm.follow_pages(
                [cpm.Image(values)], cpm.circle((32, 32), 18), cpm.PRESETS[preset], objects=objects
            )
            strengths += [contour.strength for contour in page.contours]
    assert len(strengths) == 4
    np.testing.assert_allclose(strengths, strengths[0], rtol=0.02)
