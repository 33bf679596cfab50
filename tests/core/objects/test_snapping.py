"""Boundaries that are moved to contours near them."""

import numpy as np
import pytest

from cpm_core import circle
from cpm_core.objects.boundaries.crossings import find_crossings
from cpm_core.objects.boundaries.snapping import MAX_BOUNDARY_SHIFT, snap_to_contours

ROW, COL = np.indices((64, 64))


def disk(radius):
    return np.hypot(ROW - 31.2, COL - 30.7) < radius


def ring(radius):
    points = circle(center=(31.2, 30.7), radius=radius, spacing=0.5)
    return np.concatenate([points, points[:1]])


@pytest.mark.parametrize("off", [-2.0, -1.0, 0.0, 1.0, 2.0])
def test_a_boundary_near_a_contour_becomes_that_contour(off):
    assert np.array_equal(snap_to_contours(disk(18.0 + off), find_crossings([ring(18.0)], ROW.shape), 2.5), disk(18.0))


@pytest.mark.parametrize("off", [-1.0, 1.0])
def test_only_where_the_contour_is_it_moves(off):
    path = ring(18.0)
    halves = np.split(path, np.flatnonzero(np.diff(path[:, 0] > 31.0)) + 1)
    found = snap_to_contours(
        disk(18.0 + off), find_crossings([half for half in halves if half[0, 0] > 31.0], ROW.shape), 2.5
    )
    there, elsewhere = ROW > 34, ROW < 28
    assert np.array_equal(found[there], disk(18.0)[there])
    assert np.array_equal(found[elsewhere], disk(18.0 + off)[elsewhere])


@pytest.mark.parametrize("lines", [[], [ring(18.0 - 2 * MAX_BOUNDARY_SHIFT)], [ring(18.0 + 2 * MAX_BOUNDARY_SHIFT)]])
def test_far_from_any_contour_it_stays(lines):
    assert np.array_equal(snap_to_contours(disk(18.0), find_crossings(lines, ROW.shape), 2.5), disk(18.0))
