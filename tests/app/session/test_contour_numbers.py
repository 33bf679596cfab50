"""Numbers of contours: a number stays with its contour through filters, steps and runs, and none is given twice."""

from __future__ import annotations

from dataclasses import replace

import pytest
from cpm_app.session.exchange.contour_tracking import ContourTracker
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.contour import Contour
from cpm_core.contours.review import Mark, capture_outline, find_anchors
from tests.core.results.test_review import line, result_of, ring

pytestmark = pytest.mark.shared_window

RINGS = [ring(30 + 40 * (i // 3), 30 + 40 * (i % 3), 6.0 + i) for i in range(9)]


@settings(max_examples=40, deadline=None)
@given(st.lists(st.sets(st.integers(0, 8)), max_size=6), st.floats(-0.7, 0.7))
def test_a_number_belongs_to_one_place_whatever_comes_and_goes(shown, off) -> None:
    tracker = ContourTracker()
    known: dict[int, int] = {}
    for count, present in enumerate(shown):
        contours = [moved(RINGS[index], off if count % 2 else -off) for index in present]
        for index, number in zip(present, tracker.assign_numbers(contours, lasting=True), strict=True):
            assert known.setdefault(index, number) == number
    assert len(set(known.values())) == len(known)
    assert sorted(known.values()) == list(range(1, len(known) + 1))


def moved(contour: Contour, by: float) -> Contour:
    return replace(contour, points=contour.points + by)


def test_a_contour_that_a_filter_cuts_apart_has_its_number_again_when_it_is_whole_again() -> None:
    tracker = ContourTracker()
    whole, left, right = line((10, 10), (10, 110)), line((10, 10), (10, 50)), line((10, 58), (10, 110))
    assert tracker.assign_numbers([whole], lasting=True) == (1,)
    assert 2 in tracker.assign_numbers([left, right], lasting=True)
    assert tracker.assign_numbers([whole], lasting=True) == (1,)


def test_a_kept_contour_that_a_run_lacks_is_shown_with_its_number_and_a_key_of_its_own() -> None:
    tracker = ContourTracker()
    first = tracker.track_contours(result_of(*RINGS[:3]), thorough=True)
    contours = first.result.contours
    marks = [Mark(find_anchors(contours, [1])[0], "kept", outline=capture_outline(contours[1]))]
    again = tracker.track_contours(result_of(RINGS[2], RINGS[0]), thorough=True).with_kept_contours(marks)
    assert [row.number for row in again.measures] == [3, 1, 2]
    assert len(set(again.keys)) == 3
    whole = tracker.track_contours(result_of(*RINGS[:3]), thorough=True)
    assert whole.with_kept_contours(marks) is whole
