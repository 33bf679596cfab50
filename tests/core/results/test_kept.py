"""Kept contours stay whatever filters and later runs leave of them, and numbers of contours are never shared."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.contour import Contour
from cpm_core.contours.review import Mark, capture_outline, find_anchors
from cpm_core.results.review import apply_marks, restore_kept_contours
from tests.core.results.test_review import line, result_of, ring


def kept(contours: list[Contour], index: int, name: str = "") -> Mark:
    return Mark(find_anchors(contours, [index])[0], "kept", name, outline=capture_outline(contours[index]))


@settings(max_examples=30, deadline=None)
@given(st.sets(st.integers(0, 4)), st.sets(st.integers(0, 4)))
def test_a_kept_contour_is_there_once_whatever_a_filter_leaves_out(chosen, left_out) -> None:
    rings = [replace(ring(30, 30 + 30 * index, 8.0 + index), number=index + 1) for index in range(5)]
    marks = [kept(rings, index) for index in sorted(chosen)]
    rest = [ring for index, ring in enumerate(rings) if index not in left_out]
    found = restore_kept_contours(result_of(*rest), marks).contours
    assert {one.number for one in found} == {index + 1 for index in (set(range(5)) - left_out) | chosen}
    assert len(found) == len({one.number for one in found})


def test_parts_of_a_kept_contour_give_way_to_the_whole_of_it_and_others_stay() -> None:
    whole, beside = line((10, 10), (10, 110)), line((14, 10), (14, 110))
    mark = kept([whole, beside], 0, "vein")
    left, right = line((10, 10), (10, 40)), line((10.2, 60), (10.2, 110))
    found = restore_kept_contours(result_of(left, beside, right), [mark]).contours
    assert [one.length for one in found] == pytest.approx([100.0, 100.0])
    assert found[0] is beside
    np.testing.assert_allclose(found[1].points, whole.points)
    assert apply_marks(restore_kept_contours(result_of(left, beside, right), [mark]), [mark]).contours[1].name == "vein"


def test_contours_that_are_not_kept_are_not_brought_back() -> None:
    one = ring(50, 50, 20.0)
    for verdict in ("", "rejected"):
        mark = replace(kept([one], 0), verdict=verdict)
        assert restore_kept_contours(result_of(), [mark]).contours == ()
    assert len(restore_kept_contours(result_of(), [kept([one], 0)]).contours) == 1
