"""Agreement of boundaries against curves whose distances are known by geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core import Contour, compare
from cpm_core.contours.agreement import compare_boundaries, distances_to_contours
from cpm_core.contours.ground_truth import truth_from_mask
from docs.gallery.runs import recovered

from ..scenes import circle_points, outline_distance

CENTER = (40.0, 50.0)


def round_contour(radius, center=CENTER):
    return Contour(circle_points(center, radius, 2000), closed=True)


def line(*corners, closed=False):
    return Contour(np.array(corners, dtype=float), closed=closed)


def test_the_truth_agrees_perfectly_with_itself():
    truth = [round_contour(20.0), line((0, 0), (0, 30), (10, 30))]
    seen = compare_boundaries(truth, truth)
    assert (seen.recall, seen.precision, seen.f) == (1.0, 1.0, 1.0)
    assert max(seen.mean_boundary_distance, seen.hausdorff, seen.hausdorff95) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("off", [0.3, 0.9])
def test_a_concentric_circle_is_as_far_away_as_the_radii_differ(off):
    found, truth = [round_contour(20.0 + off)], [round_contour(20.0)]
    seen = compare_boundaries(found, truth, 1.0)
    assert (seen.mean_boundary_distance, seen.hausdorff) == (pytest.approx(off, abs=1e-4), pytest.approx(off, abs=1e-4))
    assert (seen.recall, seen.precision) == (1.0, 1.0)


@pytest.mark.parametrize("share", [0.25, 0.6, 1.0])
def test_recall_is_the_fraction_of_the_boundary_that_was_found(share):
    arc = Contour(circle_points(CENTER, 20.0, 4000)[: int(4000 * share)], closed=False)
    seen = compare_boundaries([arc], [round_contour(20.0)], 1.0)
    beyond_the_ends = 2.0 / (2.0 * np.pi * 20.0)
    assert seen.recall == pytest.approx(min(1.0, share + beyond_the_ends), abs=0.005)
    assert seen.precision == 1.0


def test_precision_is_the_fraction_of_the_contours_that_is_true():
    true, wrong = line((10, 0), (10, 30)), line((30, 0), (30, 70))
    seen = compare_boundaries([true, wrong], [true], 1.0)
    assert (seen.recall, seen.precision) == (1.0, pytest.approx(0.3))
    assert seen.f == pytest.approx(2 * 0.3 / 1.3)
    slanting = 0.5 * (40 * np.hypot(20, 40) + 400 * np.arcsinh(2))  # the integral of hypot(20, x) from 0 to 40
    assert seen.mean_boundary_distance == pytest.approx((30 * 0 + 30 * 20 + slanting + 30 * 0) / 130, rel=1e-4)
    assert seen.hausdorff == pytest.approx(np.hypot(20, 40))


def test_only_closed_contours_that_match_count_as_recovered():
    truth = [round_contour(20.0), round_contour(8.0), line((0, 0), (0, 50))]
    opened = Contour(truth[0].points, closed=False)
    halves = [
        line((20, 50), *truth[0].points[:1000], closed=True),
        line((60, 50), *truth[0].points[1000:], closed=True),
    ]
    assert [recovered(found, truth, 1.0) for found in (truth, [opened], halves, truth[1:])] == [2, 0, 0, 1]


corners = st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=9)


@given(lines=st.lists(st.tuples(corners, st.booleans()), min_size=1, max_size=4), points=corners)
def test_distances_are_those_to_every_side(lines, points):
    """Compared with the least distance to all sides, one by one."""
    contours = [Contour(np.array(vertices), closed) for vertices, closed in lines]
    seen = distances_to_contours(np.array(points), contours)
    np.testing.assert_allclose(seen, outline_distance(np.array(points), [c.path for c in contours]), atol=1e-9)


def test_objects_are_counted_as_found_missed_extra_and_merged():
    labels = np.zeros((40, 80), np.int32)
    for number, col in enumerate((4, 20, 32, 60), start=1):
        labels[10:20, col : col + 10] = number

    def box(left, right, top=9.5, bottom=19.5):
        return Contour(np.array([[top, left], [top, right], [bottom, right], [bottom, left]]), True, 1.0)

    truth = truth_from_mask(labels)
    counts = compare([box(3.5, 13.5), box(19.5, 41.5), box(50.5, 55.5, 30.5, 35.5)], truth).objects
    assert (counts.found, counts.missed, counts.extra, counts.merged) == (1, 3, 2, 1)
    assert counts.average_precision == pytest.approx(1 / 6)
    assert compare(truth.contours, truth).objects.average_precision == 1.0
