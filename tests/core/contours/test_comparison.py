"""Comparison with the ground truth: circles and squares, whose overlap and distances are known from geometry."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Contour, compare
from cpm_core.contours.ground_truth import truth_of_contours, truth_of_mask
from cpm_core.contours.rasterize import inside
from cpm_core.objects.methods.method import boundary

from ..scenes import circle_points

SHAPE = (120, 140)
CENTER = (60.0, 65.0)


def disk(radius, center=CENTER):
    return Contour(circle_points(center, radius, 1000), closed=True)


def square(top, left, side):
    bottom, right = top + side, left + side
    return Contour(np.array([(top, left), (top, right), (bottom, right), (bottom, left)], dtype=float), closed=True)


def lens(radius, shift):
    """Area that two circles of one radius share."""
    return 2 * radius**2 * math.acos(shift / (2 * radius)) - 0.5 * shift * math.sqrt(4 * radius**2 - shift**2)


def test_the_truth_agrees_with_itself():
    contours = [disk(30.0), disk(10.0)]
    seen = compare(contours, truth_of_contours(contours, SHAPE))
    assert (seen.dice, seen.jaccard, seen.recall, seen.precision, seen.f) == (1.0, 1.0, 1.0, 1.0, 1.0)
    assert max(seen.hausdorff, seen.hausdorff95, seen.mean_boundary_distance) < 1e-9
    assert seen.missing.shape == (0, 2)
    assert not seen.extra_area.any()
    assert not seen.missing_area.any()
    assert [len(distances) for distances in seen.distances] == [1000, 1000]


@pytest.mark.parametrize("shift", [0.5, 3.0, 12.0])
def test_a_shifted_circle(shift):
    radius, (row, col) = 30.0, CENTER
    seen = compare([disk(radius, (row, col + shift))], truth_of_contours([disk(radius)], SHAPE), tolerance=2.0)
    share = lens(radius, shift) / (math.pi * radius**2)
    assert seen.dice == pytest.approx(share, abs=0.005)
    assert seen.jaccard == pytest.approx(share / (2 - share), abs=0.01)
    assert seen.hausdorff == pytest.approx(shift, abs=1e-3)
    angle = 2 * np.pi * np.arange(20000) / 20000
    away = np.abs(np.hypot(radius * np.cos(angle) + shift, radius * np.sin(angle)) - radius)
    assert seen.mean_boundary_distance == pytest.approx(away.mean(), abs=2e-3)
    assert seen.hausdorff95 == pytest.approx(np.percentile(away, 95), abs=2e-3)
    assert seen.recall == pytest.approx((away <= 2.0).mean(), abs=2e-3)
    assert seen.precision == pytest.approx((away <= 2.0).mean(), abs=2e-3)


@settings(max_examples=10, deadline=None)
@given(st.floats(8.0, 25.0), st.floats(0.5, 20.0))
def test_circles_about_one_center(inner, wider):
    outer = inner + wider
    seen = compare([disk(inner)], truth_of_contours([disk(outer)], SHAPE), tolerance=1.0)
    assert seen.hausdorff == pytest.approx(wider, abs=1e-3)
    assert seen.hausdorff95 == pytest.approx(wider, abs=1e-3)
    assert seen.mean_boundary_distance == pytest.approx(wider, abs=1e-3)
    assert seen.distances[0] == pytest.approx(wider, abs=1e-3)
    assert seen.dice == pytest.approx(2 * inner**2 / (inner**2 + outer**2), abs=0.03)
    near = wider <= 1.0 - 1e-3
    assert near or wider <= 1.0 + 1e-3 or (seen.recall, seen.precision) == (0.0, 0.0)
    assert not near or (seen.recall, seen.precision) == (1.0, 1.0)
    away = np.hypot(np.arange(SHAPE[0])[:, None] - CENTER[0], np.arange(SHAPE[1]) - CENTER[1])
    between, beside = (away > inner) & (away < outer), np.minimum(abs(away - inner), abs(away - outer)) < 0.01
    assert np.array_equal(seen.missing_area[~beside], between[~beside])
    assert not seen.extra_area.any()


@pytest.mark.parametrize("shift", [0, 1, 5, 20])
def test_squares_that_lie_on_pixels_are_counted_exactly(shift):
    mask = np.zeros(SHAPE, np.uint8)
    mask[30:50, 40:60] = 255
    seen = compare([square(29.5, 39.5 + shift, 20)], truth_of_mask(mask), tolerance=0.5)
    common = 20 * (20 - shift)
    assert seen.dice == common / 400
    assert seen.jaccard == common / (800 - common)
    assert int(seen.extra_area.sum()) == int(seen.missing_area.sum()) == 400 - common
    assert seen.extra_area[30:50, 60 : 60 + shift].all()
    assert seen.missing_area[30:50, 40 : 40 + shift].all()
    # the boundary of a mask cuts the corners of pixels, by half a pixel at the corners of the square
    assert seen.hausdorff == pytest.approx(shift if shift else math.sqrt(0.125), abs=0.36)


def test_missing_and_wrong_parts_are_located():
    left, right = disk(15.0, (60.0, 30.0)), disk(15.0, (60.0, 100.0))
    wrong = Contour(np.array([(5.0, 5.0), (5.0, 35.0)]), closed=False)
    seen = compare([left, wrong], truth_of_contours([left, right], SHAPE))
    lengths = (left.length, right.length, wrong.length)
    assert seen.recall == pytest.approx(0.5, abs=1e-3)
    assert seen.precision == pytest.approx(lengths[0] / (lengths[0] + lengths[2]), abs=1e-3)
    assert np.abs(np.linalg.norm(seen.missing - (60.0, 100.0), axis=1) - 15.0).max() < 1e-3
    assert len(seen.missing) == pytest.approx(4 * lengths[1], rel=0.01)
    assert seen.distances[0].max() < 1e-9
    assert seen.distances[1] == pytest.approx(np.hypot([55.0, 55.0], [25.0, 5.0]) - 15.0, abs=1e-3)
    assert np.array_equal(seen.missing_area, inside([right], SHAPE))


def test_a_contour_in_another_is_a_hole_by_default():
    ring, core = [disk(30.0), disk(20.0)], disk(10.0)
    mask = inside([ring[0]], SHAPE) & ~inside([ring[1]], SHAPE) | inside([core], SHAPE)
    truth = truth_of_mask(mask)
    assert compare([*ring, core], truth).dice == 1.0
    assert compare([core, *ring], truth).dice == 1.0
    filled = compare([*ring, core], truth, holes=False)
    assert np.array_equal(filled.extra_area, inside([ring[1]], SHAPE) & ~inside([core], SHAPE))
    nested = truth_of_contours(ring, SHAPE, holes=False)
    assert compare(ring, nested, holes=False).dice == 1.0
    assert nested.labels.max() == 2


def test_each_object_is_matched_with_the_contour_that_covers_it_best():
    labels = np.zeros(SHAPE, np.uint8)
    labels[10:30, 10:30], labels[10:30, 30:50], labels[60:80, 60:80] = 50, 100, 150
    found = [
        square(9.5, 29.5, 20),
        Contour(CENTER + np.zeros((3, 2)), False),
        square(9.5, 9.5, 10),
        disk(5.0, (100, 20)),
    ]
    first, second, third = compare(found, truth_of_mask(labels)).matches
    assert (first.label, first.contour, first.dice) == (1, 2, 2 * 100 / (100 + 400))
    assert (second.label, second.contour, second.dice) == (2, 0, 1.0)
    assert (third.label, third.contour, third.dice) == (3, None, 0.0)


def test_the_objects_of_one_class_are_its_connected_parts():
    mask = np.zeros(SHAPE, bool)
    mask[10:30, 10:30] = mask[50:70, 50:70] = True
    matches = compare([square(49.5, 49.5, 20)], truth_of_mask(mask)).matches
    assert [(match.contour, match.dice) for match in matches] == [(None, 0.0), (0, 1.0)]


def test_without_contours_the_distance_is_infinite_and_the_precision_zero():
    seen = compare([], truth_of_contours([disk(20.0)], SHAPE))
    assert (seen.dice, seen.jaccard, seen.recall, seen.f) == (0.0, 0.0, 0.0, 0.0)
    assert math.isinf(seen.hausdorff)
    assert math.isinf(seen.hausdorff95)
    assert math.isinf(seen.mean_boundary_distance)
    assert seen.precision == 1.0
    assert seen.distances == ()
    assert [match.contour for match in seen.matches] == [None]


def test_the_border_of_the_image_is_no_boundary_of_an_object_that_it_cuts():
    row, col = np.indices(SHAPE)
    truth = truth_of_mask(np.hypot(row - 60, col + 5) < 40)
    whole = boundary(truth.labels > 0, 0.5)[0]
    seen = compare(whole, truth)
    assert (seen.dice, seen.f) == (1.0, 1.0)
    assert max(seen.hausdorff, seen.mean_boundary_distance) < 1.0
    quarter = np.hypot(row, col) < 40
    rounded = boundary(quarter & (row + col > 1), 0.5)[0]  # methods that smooth a region lose its corner
    assert compare(rounded, truth_of_mask(quarter)).hausdorff < 1.0
    from_contours = truth_of_contours(whole, SHAPE)
    open_line = max((line for line in truth.contours), key=lambda line: line.length)
    assert compare([open_line], from_contours).recall == 1.0
    elsewhere = boundary((truth.labels > 0) | (col > 120), 0.5)[0]
    assert compare(elsewhere, truth).precision < 0.5, "where no object of the truth reaches it, it is wrong"


def test_open_contours_have_boundaries_and_no_inside():
    line = Contour(np.array([(20.0, 20.0), (20.0, 80.0)]), closed=False)
    beside = Contour(line.points + np.array([3.0, 0.0]), closed=False)
    seen = compare([beside], truth_of_contours([line], SHAPE))
    assert (seen.hausdorff, seen.mean_boundary_distance) == (pytest.approx(3.0), pytest.approx(3.0))
    assert (seen.dice, seen.jaccard) == (1.0, 1.0)  # both enclose nothing
    assert seen.matches == ()


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan, math.inf])
def test_an_invalid_tolerance_is_refused(tolerance):
    with pytest.raises(ValueError, match=r"tolerance is .* but must be a number of px above 0"):
        compare([disk(5.0)], truth_of_contours([disk(5.0)], SHAPE), tolerance)
