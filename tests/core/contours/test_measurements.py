"""The table of contours: nesting against brute force, lengths and areas against geometry."""

import matplotlib.path
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Contour
from cpm_core.contours.measurements import containment, measure
from cpm_core.field.region_contrast import MeanContrast

from ..scenes import circle_points


def ring(row, col, radius, count=60):
    return Contour(circle_points((row, col), radius, count), closed=True)


def line(*corners):
    return Contour(np.array(corners, dtype=float), closed=False)


def brute_force(contours):
    """Index of the smallest closed contour that contains every vertex of each, by another library."""
    found = []
    for one in contours:
        around = [
            (other.area, k)
            for k, other in enumerate(contours)
            if other is not one
            and other.closed
            and other.area > one.area
            and matplotlib.path.Path(other.path).contains_points(one.points).all()
        ]
        found.append(min(around)[1] if around else None)
    return tuple(found)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 25))
def test_nesting_is_that_of_brute_force(seed, count):
    """Disjoint or nested circles, as contours are, some of them opened."""
    random = np.random.default_rng(seed)
    disks, contours = [], []
    for _ in range(count):
        center, radius = random.uniform(0, 200, 2), 10 ** random.uniform(0.5, 2)
        apart = [np.linalg.norm(center - other) for other, _ in disks]
        if all(d > radius + r + 3 or d < abs(radius - r) - 3 for d, (_, r) in zip(apart, disks, strict=True)):
            disks.append((center, radius))
            points = circle_points(tuple(center), radius, int(random.integers(12, 90)))
            contours.append(Contour(points, closed=bool(random.uniform() < 0.8)))
    assert containment(contours) == brute_force(contours)


def test_a_row_agrees_with_geometry():
    square = np.array([(10, 10), (10, 30), (30, 30), (30, 10)], dtype=float)
    contours = [
        Contour(square, closed=True, strength=7.0, name="cell", color="#e69f00"),
        Contour(np.array([(12.0, 12.0), (15.0, 16.0)]), closed=False, strength=3.0, junctions=(True, False)),
        ring(20, 22, 3),
    ]
    first, second, third = measure(contours, spacing=(0.5, 0.25))
    assert (first.number, first.label, first.name, first.color, first.closed) == (1, 1, "cell", "#e69f00", True)
    assert (first.length, first.area, first.strength, first.junctions) == (80.0, 400.0, 7.0, 0)
    assert first.length_in_units == pytest.approx(2 * 20 * 0.5 + 2 * 20 * 0.25)
    assert first.area_in_units == pytest.approx(400 * 0.125)
    assert (second.label, second.closed, second.junctions, second.length, second.area) == (0, False, 1, 5.0, 0.0)
    assert second.length_in_units == pytest.approx(np.hypot(3 * 0.5, 4 * 0.25))
    assert [row.inside for row in (first, second, third)] == [0, 1, 1]
    assert third.label == 2


def test_contrast_is_measured_where_there_is_an_image_and_only_on_request():
    values = np.where(np.arange(40) < 20, 0.0, 100.0) * np.ones((40, 1))
    points = np.stack([np.arange(10.0, 30.0), np.full(20, 19.5)], axis=1)
    sides = MeanContrast(values, points, np.tile([0.0, 1.0], (20, 1)), 1.0)
    seen = Contour(points, closed=False, measure_contrast=sides)
    assert measure([seen])[0].contrast == pytest.approx(1.0, abs=0.1)
    assert measure([seen], contrast=False)[0].contrast is None
    assert measure([line((1, 1), (5, 5))])[0].contrast is None
