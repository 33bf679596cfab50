"""An area that is painted with a brush, beside the same done pixel by pixel."""

import itertools
import math

import numpy as np
import pytest
import scipy
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from cpm_core.numerics import polyline
from cpm_core.objects.segmented.areas import paint_boundary

SHAPE = (64, 64)
PIXELS = np.indices(SHAPE).reshape(2, -1).T.astype(float)
STAR = tuple(
    (32 + r * math.sin(a), 32 + r * math.cos(a)) for a, r in ((0.2 * math.pi * k, 24 - 13 * (k % 2)) for k in range(10))
)
SQUARE = ((26.0, 26.0), (26.0, 38.0), (38.0, 38.0), (38.0, 26.0))
PLACES = st.tuples(st.floats(-3, 66), st.floats(-3, 66)).map(lambda at: (round(at[0], 3), round(at[1], 3)))


def enclosed(boundary):
    """Which pixels an odd number of curves encloses."""
    found = np.zeros(len(PIXELS), bool)
    for curve in boundary:
        found ^= polyline.points_inside(curve, PIXELS)
    return found


def off(boundary):
    """Distance of each pixel from the curves."""
    return np.min([polyline.distances_to_path((*curve, curve[0]), PIXELS) for curve in boundary], axis=0)


def alone(mask):
    """Which pixels have no neighbor that is inside like them, or outside like them: remainders may be left out."""
    alike = sum(scipy.ndimage.convolve((mask == kind).reshape(SHAPE).astype(int), np.ones((3, 3), int)).ravel()
                * (mask == kind) for kind in (False, True))  # fmt: skip
    return alike == 1


@given(st.lists(PLACES, min_size=1, max_size=8), st.floats(1.0, 12.0), st.booleans(), st.booleans())
@settings(max_examples=12)
@example([(6.781, 48.5), (35.75, 0.0)], 2.0, False, False)  # cuts off a tip that is smaller than a pixel
def test_the_boundary_encloses_the_area_and_what_the_disk_has_gone_over_or_the_area_without_it(
    path, radius, adds, hole
):
    boundary = (STAR, SQUARE) if hole else (STAR,)
    away = polyline.distances_to_path(path, PIXELS)
    expected = enclosed(boundary) | (away <= radius) if adds else enclosed(boundary) & (away > radius)
    at_once = paint_boundary(boundary, path, radius, adds, SHAPE)
    by_steps = paint_boundary(boundary, path[:1], radius, adds, SHAPE)
    for step in itertools.pairwise(path):
        by_steps = paint_boundary(by_steps, step, radius, adds, SHAPE)
    for area, tolerance in ((at_once, 0.1), (by_steps, 0.1)):
        clear = (np.abs(away - radius) > tolerance) & (off(boundary) > tolerance)
        assert not ((enclosed(area) != expected) & clear & ~alone(expected)).any()


@given(st.lists(PLACES, min_size=1, max_size=5), st.floats(1.0, 8.0), st.booleans())
@settings(max_examples=15)
def test_far_from_the_brush_the_boundary_has_the_vertices_that_it_had(path, radius, adds):
    def rounded(corners):
        return {tuple(np.round(corner, 3).tolist()) for corner in corners}

    after = [corner for curve in paint_boundary((STAR, SQUARE), path, radius, adds, SHAPE) for corner in curve]
    far = [corner for corner in (*STAR, *SQUARE) if polyline.distance_to_path(path, corner) > radius + 3.0]
    assume(far)
    assert rounded(far) <= rounded(after)


def test_a_brush_that_touches_nothing_changes_nothing_and_limits_keep_it_out():
    assert paint_boundary((STAR,), [(-40.0, -40.0)], 3.0, False, SHAPE) == (STAR,)
    assert paint_boundary((STAR,), [(-40.0, -40.0)], 3.0, True, SHAPE) == (STAR,)
    (inner,) = paint_boundary((), [(32.0, 32.0)], 2.0, True, SHAPE)
    outer = paint_boundary((), [(32.0, 32.0)], 6.0, True, SHAPE, [(inner,)])
    assert len(outer) == 2
    assert not (enclosed(outer) & enclosed((inner,))).any()
    assert paint_boundary((), [(32.0, 32.0)], 1.0, True, SHAPE, [(inner,)]) == ()


def test_a_disk_has_its_area_and_is_round_to_a_hundredth_of_a_pixel():
    (curve,) = paint_boundary((), [(30.3, 31.7)], 10.0, True, SHAPE)
    assert polyline.enclosed_area(curve) == pytest.approx(100 * math.pi, rel=0.003)
    assert np.abs(np.hypot(*(np.array(curve) - (30.3, 31.7)).T) - 10.0).max() < 0.015


def test_nothing_is_left_where_all_is_taken_away():
    assert paint_boundary((SQUARE,), [(32.0, 32.0)], 12.0, False, SHAPE) == ()


def test_what_is_painted_ends_at_the_border_of_the_image():
    (curve,) = paint_boundary((), [(1.0, 62.0)], 5.0, True, SHAPE)
    low, high = np.min(curve, axis=0), np.max(curve, axis=0)
    assert low[0] == pytest.approx(-0.5)
    assert high[1] == pytest.approx(63.5)
