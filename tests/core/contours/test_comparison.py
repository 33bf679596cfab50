"""Comparison with the ground truth: circles and squares, whose overlap and distances are known from geometry."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Contour, compare
from cpm_core.contours.ground_truth import truth_from_contours, truth_from_mask
from cpm_core.contours.rasterize import rasterize_mask
from cpm_core.methods.method import trace_boundary

from ..scenes import circle_points

SHAPE = (120, 140)
CENTER = (60.0, 65.0)


def disk(radius, center=CENTER):
    return Contour(circle_points(center, radius, 1000), closed=True)


def test_the_truth_agrees_with_itself():
    contours = [disk(30.0), disk(10.0)]
    seen = compare(contours, truth_from_contours(contours, SHAPE))
    assert (seen.dice, seen.jaccard, seen.recall, seen.precision, seen.f) == (1.0, 1.0, 1.0, 1.0, 1.0)
    assert max(seen.hausdorff, seen.hausdorff95, seen.mean_boundary_distance) < 1e-9
    assert seen.missing.shape == (0, 2)
    assert [len(distances) for distances in seen.distances] == [1000, 1000]


@settings(max_examples=10, deadline=None)
@given(st.floats(8.0, 25.0), st.floats(0.5, 20.0))
def test_circles_about_one_center(inner, wider):
    outer = inner + wider
    seen = compare([disk(inner)], truth_from_contours([disk(outer)], SHAPE), tolerance=1.0)
    assert seen.hausdorff == pytest.approx(wider, abs=1e-3)
    assert seen.hausdorff95 == pytest.approx(wider, abs=1e-3)
    assert seen.mean_boundary_distance == pytest.approx(wider, abs=1e-3)
    assert seen.distances[0] == pytest.approx(wider, abs=1e-3)
    assert seen.dice == pytest.approx(2 * inner**2 / (inner**2 + outer**2), abs=0.03)
    near = wider <= 1.0 - 1e-3
    assert near or wider <= 1.0 + 1e-3 or (seen.recall, seen.precision) == (0.0, 0.0)
    assert not near or (seen.recall, seen.precision) == (1.0, 1.0)


def test_a_contour_in_another_is_a_hole_by_default():
    ring, core = [disk(30.0), disk(20.0)], disk(10.0)
    mask = rasterize_mask([ring[0]], SHAPE) & ~rasterize_mask([ring[1]], SHAPE) | rasterize_mask([core], SHAPE)
    truth = truth_from_mask(mask)
    assert compare([*ring, core], truth).dice == 1.0
    assert compare([core, *ring], truth).dice == 1.0
    assert (
        compare([*ring, core], truth, holes=False).jaccard
        == truth.labels.sum() / rasterize_mask([ring[0]], SHAPE).sum()
    )
    nested = truth_from_contours(ring, SHAPE, holes=False)
    assert compare(ring, nested, holes=False).dice == 1.0
    assert nested.labels.max() == 2


def test_the_border_of_the_image_is_no_boundary_of_an_object_that_it_cuts():
    row, col = np.indices(SHAPE)
    truth = truth_from_mask(np.hypot(row - 60, col + 5) < 40)
    whole = trace_boundary(truth.labels > 0, 0.5)
    seen = compare(whole, truth)
    assert (seen.dice, seen.f) == (1.0, 1.0)
    assert max(seen.hausdorff, seen.mean_boundary_distance) < 1.0
    quarter = np.hypot(row, col) < 40
    rounded = trace_boundary(quarter & (row + col > 1), 0.5)  # methods that smooth a region lose its corner
    assert compare(rounded, truth_from_mask(quarter)).hausdorff < 1.0
    from_contours = truth_from_contours(whole, SHAPE)
    open_line = max((line for line in truth.contours), key=lambda line: line.length)
    assert compare([open_line], from_contours).recall == 1.0
    elsewhere = trace_boundary((truth.labels > 0) | (col > 120), 0.5)
    assert compare(elsewhere, truth).precision < 0.5, "where no object of the truth reaches it, it is wrong"
