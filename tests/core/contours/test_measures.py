"""Measures of agreement against curves whose distances are known by geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core import Contour
from cpm_core.contours.distances import compare, distance_to, sampled

from ..scenes import circle_points, outline_distance

CENTER = (40.0, 50.0)


def round_contour(radius, center=CENTER):
    return Contour(circle_points(center, radius, 2000), closed=True)


def line(*corners, closed=False):
    return Contour(np.array(corners, dtype=float), closed=closed)


def test_the_truth_itself_is_perfect():
    truth = [round_contour(20.0), line((0, 0), (0, 30), (10, 30))]
    seen = compare(truth, truth)
    assert (seen.recall, seen.precision, seen.f, seen.closed, seen.wanted, seen.contours) == (1.0, 1.0, 1.0, 1, 1, 2)
    assert seen.distance == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("off", [0.3, 0.9])
def test_a_concentric_circle_is_as_far_away_as_the_radii_differ(off):
    seen = compare([round_contour(20.0 + off)], [round_contour(20.0)])
    assert seen.distance == pytest.approx(off, abs=1e-4)
    assert (seen.recall, seen.precision, seen.closed) == (1.0, 1.0, 1)


def test_beyond_the_tolerance_nothing_agrees():
    far = [round_contour(21.5)]
    seen = compare(far, [round_contour(20.0)])
    assert (seen.recall, seen.precision, seen.f, seen.closed, seen.wanted) == (0.0, 0.0, 0.0, 0, 1)
    assert compare(far, [round_contour(20.0)], tolerance=2.0).f == 1.0


@pytest.mark.parametrize("share", [0.25, 0.6, 1.0])
def test_recall_is_the_share_of_the_boundary_that_was_found(share):
    arc = Contour(circle_points(CENTER, 20.0, 4000)[: int(4000 * share)], closed=False)
    seen = compare([arc], [round_contour(20.0)])
    beyond_the_ends = 2.0 / (2.0 * np.pi * 20.0)
    assert seen.recall == pytest.approx(min(1.0, share + beyond_the_ends), abs=0.005)
    assert (seen.precision, seen.closed) == (1.0, 0)


def test_precision_is_the_share_of_the_contours_that_is_true():
    true, wrong = line((10, 0), (10, 30)), line((30, 0), (30, 70))
    seen = compare([true, wrong], [true])
    assert (seen.recall, seen.precision) == (1.0, pytest.approx(0.3))
    assert seen.f == pytest.approx(2 * 0.3 / 1.3)
    slanting = 0.5 * (40 * np.hypot(20, 40) + 400 * np.arcsinh(2))  # the integral of hypot(20, x) from 0 to 40
    assert seen.distance == pytest.approx((30 * 0 + 30 * 20 + slanting) / 100, rel=1e-4)


def test_only_closed_contours_that_are_the_true_one_count_as_closed():
    truth = [round_contour(20.0), round_contour(8.0), line((0, 0), (0, 50))]
    opened = Contour(truth[0].points, closed=False)
    halves = [
        line((20, 50), *truth[0].points[:1000], closed=True),
        line((60, 50), *truth[0].points[1000:], closed=True),
    ]
    assert [compare(found, truth).closed for found in (truth, [opened], halves, truth[1:])] == [2, 0, 0, 1]
    assert compare(truth, truth).wanted == 2


def test_nothing_found_and_nothing_to_find():
    some = [round_contour(10.0)]
    nothing_found, nothing_true, nothing = compare([], some), compare(some, []), compare([], [])
    assert (nothing_found.recall, nothing_found.precision, nothing_found.wanted) == (0.0, 1.0, 1)
    assert (nothing_true.recall, nothing_true.precision, nothing_true.contours) == (1.0, 0.0, 1)
    assert (nothing.recall, nothing.precision) == (1.0, 1.0)
    assert all(np.isnan(seen.distance) for seen in (nothing_found, nothing_true, nothing))


@pytest.mark.parametrize("tolerance", [0.0, -1.0, float("nan")])
def test_a_tolerance_that_is_none_is_refused(tolerance):
    with pytest.raises(ValueError, match=f"tolerance is {tolerance:g} px but must be above 0"):
        compare([], [], tolerance)


corners = st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=9)


@given(lines=st.lists(st.tuples(corners, st.booleans()), min_size=1, max_size=4), points=corners)
def test_distances_are_those_to_every_side(lines, points):
    """Compared with the least distance to all sides, one by one."""
    contours = [Contour(np.array(vertices), closed) for vertices, closed in lines]
    seen = distance_to(np.array(points), contours)
    np.testing.assert_allclose(seen, outline_distance(np.array(points), [c.path for c in contours]), atol=1e-9)


@given(vertices=corners, closed=st.booleans(), spacing=st.floats(0.2, 5.0))
def test_samples_are_even_and_lie_on_the_line(vertices, closed, spacing):
    contour = Contour(np.array(vertices), closed)
    points = sampled(contour, spacing)
    assert len(points) * spacing >= contour.length
    assert (len(points) - 1) * spacing <= contour.length + spacing
    assert outline_distance(points, [contour.path]).max() < 1e-9
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert (steps <= contour.length / len(points) + 1e-9).all()
