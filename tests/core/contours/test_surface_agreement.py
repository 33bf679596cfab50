"""Comparison of surfaces with the ground truth of a volume: balls and boxes, whose overlap and distances are known."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Surface, VolumeTruth, compare_surface
from cpm_core.contours.surface_agreement import TriangleSamples

SHAPE = (30, 32, 34)


def ball(center, radius, shape=SHAPE, sides=(1.0, 1.0, 1.0)):
    away = (np.moveaxis(np.indices(shape), 0, -1) - center) * sides
    return np.linalg.norm(away, axis=-1) <= radius


def box(first, last, shape=SHAPE):
    found = np.zeros(shape, bool)
    found[tuple(slice(a, b) for a, b in zip(first, last, strict=True))] = True
    return found


def brute(points, corners):
    """Distance of points from triangles that are filled with many points."""
    share = np.array([(i, j) for i in range(41) for j in range(41 - i)]) / 40.0
    weights = np.column_stack([1.0 - share.sum(axis=1), share])
    filled = np.einsum("nk,tkx->tnx", weights, corners).reshape(-1, 3)
    return np.linalg.norm(points[:, None] - filled, axis=2).min(axis=1)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_distances_are_those_to_the_nearest_place_on_the_triangles(seed):
    random = np.random.default_rng(seed)
    corners = random.uniform(0, 1, (30, 1, 3)) + random.uniform(-0.05, 0.05, (30, 3, 3))
    points = random.uniform(-1, 2, (20, 3))
    found, filled = TriangleSamples(corners).distances_to(points), brute(points, corners)
    assert (found <= filled + 1e-9).all()
    assert (filled - found <= 0.03).all()


def test_a_truth_agrees_with_its_own_surface():
    truth = VolumeTruth(ball((15, 15, 16), 8) | box((2, 2, 2), (6, 7, 8)))
    seen = compare_surface(truth.surface, truth)
    assert (seen.dice, seen.jaccard, seen.f) == (1.0, 1.0, 1.0)
    assert max(seen.hausdorff, seen.mean_boundary_distance) < 1e-6
    assert (seen.objects.found, seen.objects.missed, seen.objects.extra) == (2, 0, 0)


def test_a_shifted_ball_has_the_overlap_and_the_distances_of_geometry():
    radius, shift, sides = 8.0, 3, (1.5, 1.0, 1.0)
    one = VolumeTruth(ball((14, 15, 14), radius, sides=sides), sides, "mm")
    assert one.surface.volume > 0.0  # its triangles look outwards
    other = VolumeTruth(ball((14, 15, 14 + shift), radius, sides=sides), sides)
    seen = compare_surface(other.surface, one)
    common = math.pi * (2 * radius - shift) ** 2 * (4 * radius + shift) / 12.0
    assert seen.dice == pytest.approx(common / (4 / 3 * math.pi * radius**3), abs=0.02)
    assert seen.hausdorff == pytest.approx(shift, abs=0.3)
    # a ball's surface is shift |cos| away, on average half the shift, and 95 % of it within .95 of the shift
    assert seen.mean_boundary_distance == pytest.approx(shift / 2, abs=0.15)
    assert seen.hausdorff95 == pytest.approx(0.95 * shift, abs=0.2)
    assert seen.precision == pytest.approx(2 / 3, abs=0.08)
    assert seen.unit == "mm"
    finer = compare_surface(other.surface, one, 0.5)
    assert finer.precision == pytest.approx(1 / 6, abs=0.05)


def test_a_box_is_as_far_as_its_faces_have_moved_in_units_of_length():
    sides = (2.0, 0.5, 1.0)
    truth = VolumeTruth(box((5, 5, 5), (20, 20, 20)), sides)
    seen = compare_surface(VolumeTruth(box((5, 5, 5), (22, 20, 20)), sides).surface, truth, 1.0)
    assert seen.hausdorff == pytest.approx(4.0, abs=0.3)
    assert seen.wrong.max() == pytest.approx(4.0, abs=0.3)
    assert (seen.precision < 1.0, seen.recall < 1.0) == (True, True)


def test_an_object_that_the_border_cuts_is_not_wrong_there():
    truth = VolumeTruth(ball((0, 15, 16), 8))
    padded = np.pad(truth.labels, 4)
    closed = VolumeTruth(padded).surface
    found = Surface(closed.vertices - 4.0, closed.faces)
    seen = compare_surface(found, truth)
    assert found.closed
    assert (seen.dice, seen.precision, seen.recall) == (1.0, 1.0, 1.0)
    assert seen.hausdorff < 1.0


def test_an_open_surface_has_distances_and_no_overlap():
    truth = VolumeTruth(ball((15, 15, 16), 6))
    half = Surface(truth.surface.vertices, truth.surface.faces[: len(truth.surface.faces) // 2])
    seen = compare_surface(half, truth)
    assert math.isnan(seen.dice)
    assert seen.precision == 1.0
    assert 0.3 < seen.recall < 1.0
