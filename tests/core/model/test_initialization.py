"""Initialization: where particles start."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core import (
    Parameters,
    circle,
    divergence_centers,
    edge_map,
    gradient_threshold,
    segment,
    stroke,
    uniform_grid,
)

from ..scenes import DARK, disk, outline_distance, ring, square


@settings(max_examples=20, deadline=None)
@given(st.floats(-50, 300), st.floats(-50, 300), st.floats(0.1, 200.0), st.floats(0.5, 10.0))
def test_circle_has_the_radius_and_an_even_spacing(row, col, radius, spacing):
    points = circle((row, col), radius, spacing)
    np.testing.assert_allclose(np.hypot(points[:, 0] - row, points[:, 1] - col), radius, rtol=1e-9, atol=1e-9)
    sides = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    np.testing.assert_allclose(sides, sides[0], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(points.mean(axis=0), (row, col), rtol=1e-9, atol=1e-9 * (radius + 1.0))
    count = 2.0 * np.pi * radius / spacing
    assert len(points) == max(5, round(count))


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_circle_without_a_size_is_refused(value):
    with pytest.raises(ValueError, match=r"radius is .* must be above 0"):
        circle((5.0, 5.0), value)
    with pytest.raises(ValueError, match=r"spacing is .* must be above 0"):
        circle((5.0, 5.0), 3.0, value)


COORDINATE = st.floats(-100.0, 300.0, allow_subnormal=False)
CORNERS = st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=7)


def length_of(path):
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@settings(max_examples=24, deadline=None)
@given(CORNERS, st.floats(0.3, 20.0), st.integers(2, 5))
def test_stroke_is_evenly_spaced_along_its_line(corners, spacing, parts):
    """Cut at every particle, the line falls into pieces of one length, which is the spacing as nearly as it goes."""
    points = stroke(corners, spacing)
    total = length_of(np.array(corners))
    pieces = len(points) - 1
    assert pieces == (max(1, round(total / spacing)) if total else 0)
    assume(total > 0.0)
    walked, start = [0.0], np.array(corners[0])
    nodes = np.concatenate([[start], *(np.linspace(a, b, 400 * parts)[1:] for a, b in pairwise(np.array(corners)))])
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))]
    for piece in range(1, pieces):
        at = piece * total / pieces
        near = nodes[np.abs(along - at) <= total / 400.0]
        walked.append(float(np.linalg.norm(near - points[piece], axis=1).min()))
    assert max(walked) <= total / 400.0


def test_stroke_of_one_point_or_no_length_is_one_particle():
    np.testing.assert_array_equal(stroke([(3.0, 4.0)]), [(3.0, 4.0)])
    np.testing.assert_array_equal(stroke([(3.0, 4.0)] * 3), [(3.0, 4.0)])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([], r"shape \(0,\) but must be \(K, D\)"),
        (np.zeros((2, 2, 2)), r"shape \(2, 2, 2\) but must be \(K, D\)"),
        ([(1.0, np.nan), (2.0, np.inf)], "2 coordinates of the stroke are not finite"),
    ],
    ids=str,
)
def test_stroke_of_no_line_is_refused(points, message):
    with pytest.raises(ValueError, match=message):
        stroke(points)


@settings(max_examples=20, deadline=None)
@given(st.tuples(st.integers(1, 70), st.integers(1, 70)), st.floats(0.6, 30.0))
def test_uniform_grid_is_inside_symmetric_and_evenly_spaced(shape, spacing):
    points = uniform_grid(shape, spacing)
    extent = np.array(shape) - 1.0
    assert np.all((points >= -1e-9) & (points <= extent + 1e-9))
    opposite = extent - points
    assert sorted(np.round(points, 6).tolist()) == sorted((np.round(opposite, 6) + 0.0).tolist())
    for axis, n in enumerate(shape):
        lines = np.unique(np.round(points[:, axis], 9))
        np.testing.assert_allclose(np.diff(lines), spacing, atol=1e-6)
        assert n - 1.0 - (lines[-1] - lines[0]) < spacing + 1e-6  # no room for another line
    assert len(points) == np.prod([len(np.unique(np.round(points[:, axis], 9))) for axis in range(2)])


@pytest.mark.parametrize("fraction", [0.0, 0.1, 0.5, 1.0])
def test_gradient_threshold_takes_the_pixels_of_the_strong_edges(fraction):
    image = disk((40, 50), (20.0, 22.0), 11.0).values
    points = gradient_threshold(image, fraction, smoothing=1.5)
    mask = np.zeros(image.shape, bool)
    mask[tuple(points.astype(int).T)] = True
    f = edge_map(image, 1.5)
    np.testing.assert_array_equal(mask, f > fraction * f.max())
    assert len(points) == mask.sum()


def three_objects():
    """A disk, a square and a ring, in different gray levels."""
    shape = (120, 130)
    objects = (
        disk(shape, (35.3, 38.6), 20.0),
        square(shape, (70.25, 12.75), 30.0),
        ring(shape, (80.4, 90.7), 10.0, 24.0),
    )
    values = np.full(shape, DARK)
    for scene, share in zip(objects, (1.0, 0.5, 0.75), strict=True):
        values = np.maximum(values, DARK + share * (scene.values - DARK))
    return values, np.concatenate([scene.boundary for scene in objects])


def test_particles_from_the_centers_of_divergence_reach_every_edge():
    """At a right angle smoothing by sigma moves the steepest place of an edge inwards by 0.72 sigma: 1.9 px."""
    values, boundary = three_objects()
    seeds = divergence_centers(values)
    assert len(seeds) < 0.25 * len(uniform_grid(values.shape))
    contours = segment(values, seeds, Parameters(w1=0.6, w2=0.7, beta=0.4)).contours
    assert [contour.closed for contour in contours] == [True] * 4
    assert outline_distance(boundary, [contour.path for contour in contours]).max() < 2.0


def test_a_disk_has_a_center_of_divergence_in_its_middle_and_none_beside_its_edge():
    scene = disk((80, 76), (38.7, 36.2), 22.0)
    centers = divergence_centers(scene.values)
    assert np.hypot(*(centers - (38.7, 36.2)).T).min() < 1.5
    assert scene.distance(centers).min() > 5.0


@pytest.mark.parametrize("spacing", [2.0, 4.0, 9.5])
def test_centers_of_divergence_keep_their_distance(spacing):
    noisy = three_objects()[0] + np.random.default_rng(0).normal(0.0, 30.0, (120, 130))
    centers = divergence_centers(noisy, spacing=spacing)
    centers = centers[((centers > 0) & (centers < (119, 129))).all(axis=1)]  # the border has its own spacing
    apart = np.abs(centers[:, None] - centers).max(axis=2)
    np.fill_diagonal(apart, np.inf)
    assert len(centers) > 5
    assert apart.min() > int(spacing)


def test_an_edge_that_runs_out_of_the_image_is_reached_from_the_border():
    """A wide arc from side to side, with nothing on either side for a field to diverge."""
    scene = disk((70, 80), (35.3, -360.4), 405.0)
    seeds = divergence_centers(scene.values)
    assert len(seeds) > 0
    assert np.all(((seeds == 0) | (seeds == (69, 79))).any(axis=1))
    (contour,) = segment(scene.values, seeds).contours
    assert not contour.closed
    assert scene.distance(contour.points).max() < 0.2
    assert np.ptp(contour.points[:, 0]) > 65.0
