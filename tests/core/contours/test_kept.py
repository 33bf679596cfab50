"""Kept contours stay whatever filters and later runs leave of them, and numbers of contours are never shared."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.contour import Contour, numbers_of
from cpm_core.contours.measurements import measure
from cpm_core.contours.review import Mark, anchor, apply, outline_of, with_kept
from tests.core.contours.test_review import line, result_of, ring


def kept(contours: list[Contour], index: int, name: str = "") -> Mark:
    return Mark(anchor(contours, index), "kept", name, outline=outline_of(contours[index]))


@settings(max_examples=30, deadline=None)
@given(st.sets(st.integers(0, 4)), st.sets(st.integers(0, 4)))
def test_a_kept_contour_is_there_once_whatever_a_filter_leaves_out(chosen, left_out) -> None:
    rings = [replace(ring(30, 30 + 30 * index, 8.0 + index), number=index + 1) for index in range(5)]
    marks = [kept(rings, index) for index in sorted(chosen)]
    rest = [ring for index, ring in enumerate(rings) if index not in left_out]
    found = with_kept(result_of(*rest), marks).contours
    assert {one.number for one in found} == {index + 1 for index in (set(range(5)) - left_out) | chosen}
    assert len(found) == len({one.number for one in found})


def test_a_kept_contour_that_is_found_again_is_the_one_of_the_new_run() -> None:
    again = ring(50.3, 49.8, 20.2, 47)
    result = result_of(again)
    assert with_kept(result, [kept([ring(50, 50, 20.0)], 0)]) is result


def test_parts_of_a_kept_contour_give_way_to_the_whole_of_it_and_others_stay() -> None:
    whole, beside = line((10, 10), (10, 110)), line((14, 10), (14, 110))
    mark = kept([whole, beside], 0, "vein")
    left, right = line((10, 10), (10, 40)), line((10.2, 60), (10.2, 110))
    found = with_kept(result_of(left, beside, right), [mark]).contours
    assert [one.length for one in found] == pytest.approx([100.0, 100.0])
    assert found[0] is beside
    np.testing.assert_allclose(found[1].points, whole.points)
    assert apply(with_kept(result_of(left, beside, right), [mark]), [mark]).contours[1].name == "vein"


def test_contours_that_are_not_kept_are_not_brought_back() -> None:
    one = ring(50, 50, 20.0)
    for verdict in ("", "rejected"):
        mark = replace(kept([one], 0), verdict=verdict)
        assert with_kept(result_of(), [mark]).contours == ()
    assert len(with_kept(result_of(), [kept([one], 0)]).contours) == 1


def test_a_contour_that_comes_back_has_a_number_that_no_other_one_has() -> None:
    old = replace(ring(50, 50, 20.0), number=1)
    found = with_kept(result_of(replace(ring(120, 120, 20.0), number=1)), [kept([old], 0)]).contours
    assert sorted(row.number for row in measure(found)) == [1, 2]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(0, 6), max_size=8))
def test_numbers_are_their_own_or_the_next_free_ones(given_numbers) -> None:
    own = [number if number not in given_numbers[:index] else 0 for index, number in enumerate(given_numbers)]
    numbers = numbers_of([replace(ring(9, 9, 3.0), number=number) for number in own])
    assert len(set(numbers)) == len(numbers)
    assert all(wanted in (number, 0) for number, wanted in zip(numbers, own, strict=True))
    assert max(numbers, default=0) <= max([len(own), *own])
    if not any(own):
        assert list(numbers) == list(range(1, len(own) + 1))


def test_what_a_contour_lies_in_is_told_by_the_number_of_that_one() -> None:
    inner, outer = replace(ring(50, 50, 8.0), number=3), replace(ring(50, 50, 30.0), number=9)
    assert [(row.number, row.inside) for row in measure([inner, outer])] == [(3, 9), (9, 0)]
