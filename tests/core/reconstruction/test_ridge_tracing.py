"""Tracing ridges: on edges known exactly, through slits and around tips, to the border, to junctions."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cpm_core import Engine, Parameters, circle, segment, uniform_grid
from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import SPLINE_MARGIN, build_scale_field
from cpm_core.reconstruction.curve.ridge import interpolate_spline
from cpm_core.reconstruction.curve.ridge_tracing import trace_ridges
from cpm_core.reconstruction.curve.subpixel import refine_to_ridge

from ..scenes import antialiased, circle_points, disk, outline_distance, polygon


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(4, 9), st.integers(4, 9))
def test_the_compiled_spline_is_that_of_scipy(seed, rows, cols):
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(size=(rows, cols))
    places = rng.uniform((-4.0, -4.0), (rows + 3.0, cols + 3.0), (40, 2))
    expected = ndimage.map_coordinates(coefficients, places.T, order=3, prefilter=False, mode="nearest")
    continued = np.pad(coefficients, SPLINE_MARGIN, mode="edge")
    np.testing.assert_allclose([interpolate_spline(continued, row, col) for row, col in places], expected, atol=1e-12)


def traced(scale_field, points, d_min=2.0):
    """Contours of traced points, after a check that the points are the first vertices."""
    vertices, edges = trace_ridges(points, scale_field, d_min)
    np.testing.assert_allclose(vertices[: len(points)], points, atol=0.11)
    assert edges.min() >= 0
    assert edges.max() < len(vertices)
    return Graph(vertices, edges).extract_contours()


@settings(max_examples=25, deadline=None)
@given(st.floats(2.5, 30.0), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.integers(0, 10**6), st.floats(0.2, 1.0))
def test_a_few_points_on_a_disk_give_its_whole_outline(radius, row, col, seed, density):
    """For few and unevenly spaced points, as long as no two neighbors are twenty pixels apart.

    Smoothing moves the ridge inwards; its scatter is that of a pixel's antialiasing. Sides may deviate by 0.03 px.
    """
    center = (36.0 + row, 36.0 + col)
    scale_field = build_scale_field(disk((73, 73), center, radius).values, 1.0, 0.0)
    rng = np.random.default_rng(seed)
    most = 2.0 * np.pi * radius / 2.0
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, 1 + int(density * most)))
    gaps = np.diff([*angle, angle[0] + 2.0 * np.pi]) * radius
    angle = angle[(gaps > 1.1) | (len(angle) == 1)]
    angle = np.concatenate([angle, np.arange(0.0, 2.0 * np.pi, 18.0 / radius)]) if gaps.max() > 18.0 else angle
    points, found = refine_to_ridge(circle_points(center, radius, 1)[0] * 0.0 + _on(center, radius, angle), scale_field)
    assert found.all()
    kept = [n for n in range(len(points)) if n == 0 or np.linalg.norm(points[:n] - points[n], axis=1).min() > 1.0]
    (contour,) = traced(scale_field, points[kept])
    assert contour.closed
    away = np.hypot(*(contour.points - center).T)
    expected = radius - (1.0 + 1.0 / 12.0 + 1.0 / 3.0) / (2.0 * radius)
    assert abs(away.mean() - expected) < 0.02 + 0.8 / radius**2
    assert away.max() - away.min() < 0.12


def _on(center, radius, angle):
    return np.stack([center[0] + radius * np.sin(angle), center[1] + radius * np.cos(angle)], axis=1)


def test_a_trace_ends_where_the_edge_ends():
    """A step that is there on the left only: within a pixel or so of the position where it stops."""
    row, col = np.indices((60, 100))
    image = np.where(col < 50, 255.0 * (row >= 30), 127.5)
    scale_field = build_scale_field(image, 1.0, 0.0)
    points = np.stack([np.full(15, 29.5), np.linspace(14.0, 42.0, 15)], axis=1)
    contours = traced(scale_field, points)
    assert max(c.points[np.abs(c.points[:, 0] - 29.5) < 0.5, 1].max() for c in contours) < 51.5


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.9, 1.2, np.pi / 2])
def test_an_edge_across_the_image_is_found_up_to_the_border(angle):
    row, col = np.indices((60, 80))
    across = (col - 40.2) * np.cos(angle) + (row - 30.3) * np.sin(angle)
    result = segment(255.0 * np.clip(across + 0.5, 0.0, 1.0), circle((30.0, 40.0), 8.0))
    (contour,) = result.contours
    assert not contour.closed
    for end in contour.points[[0, -1]]:
        assert min(*end, *((59.0, 79.0) - end)) == pytest.approx(0.0, abs=1e-9)


SLITS = {
    "slit of one": [(20, 20), (60, 20), (60, 43), (31, 43), (31, 44), (60, 44), (60, 70), (20, 70)],
    "slit of two": [(20, 20), (60, 20), (60, 42), (31, 42), (31, 44), (60, 44), (60, 70), (20, 70)],
    "slit of three": [(20, 20), (60, 20), (60, 41), (31, 41), (31, 44), (60, 44), (60, 70), (20, 70)],
    "limb of one": [(40, 20), (70, 20), (70, 70), (40, 70), (40, 44), (12, 44), (12, 43), (40, 43)],
    "limb of two": [(40, 20), (70, 20), (70, 70), (40, 70), (40, 45), (12, 45), (12, 43), (40, 43)],
    "limb of three": [(40, 20), (70, 20), (70, 70), (40, 70), (40, 46), (12, 46), (12, 43), (40, 43)],
    "bent limb": [(40, 20), (70, 20), (70, 70), (40, 70), (40, 64), (16, 64), (16, 30), (18, 30), (18, 62), (40, 62)],
    "sharp tip": [(20, 15), (45, 75), (70, 15), (45, 18)],
    "sharper tips": [(43, 8), (48, 45), (43, 82), (38, 45)],
    "sharp notch": [(20, 20), (70, 20), (70, 70), (46, 70), (44, 26), (42, 70), (20, 70)],
}
"""Corners of objects with what is thinner than the spacing of particles."""


@pytest.mark.parametrize("shift", [0.5, 0.875])
@pytest.mark.parametrize("name", SLITS)
def test_slits_limbs_and_tips_are_part_of_one_closed_contour(name, shift):
    """The outline is found except for the tips, which smoothing rounds, and nothing else is found.

    What is one pixel wide is narrower than the smoothing, and may come off as a contour by itself, or as a line where
    particles on one side leave no room for others on the other side.
    """
    scene = polygon((90, 90), np.array(SLITS[name], dtype=float) - shift)
    result = segment(scene.values, circle((50.0, 40.0), 8.0))
    assert all(contour.closed for contour in result.contours) or "of one" in name
    assert len(result.contours) <= (3 if "of one" in name else 1)
    assert result.converged
    missed = outline_distance(scene.boundary, [contour.path for contour in result.contours])
    assert (missed < 1.5).mean() > (0.92 if "of one" in name else 0.95)
    assert missed.max() < (9.0 if "tip" in name or "notch" in name else 2.5)
    assert scene.distance(np.concatenate([contour.points for contour in result.contours])).max() < 1.5


def sectors(*grays):
    """A square image of gray sectors around its center, given as (angle at which it begins, gray level)."""

    def inside(row, col, begin, end):
        angle = np.arctan2(row - 49.7, col - 49.4) % (2.0 * np.pi)
        return (angle >= begin) & (angle < end)

    image = np.zeros((100, 100))
    for (begin, gray), (end, _) in zip(grays, [*grays[1:], (2.0 * np.pi, 0)], strict=True):
        share = (antialiased((100, 100), lambda row, col, b=begin, e=end: inside(row, col, b, e)) - 40.0) / 160.0
        image += gray * share
    return image


@pytest.mark.parametrize(
    "grays",
    [
        [(0.0, 40.0), (2.0, 120.0), (4.2, 220.0)],
        [(0.0, 40.0), (np.pi / 2, 120.0), (np.pi, 220.0)],
    ],
    ids=["Y", "T"],
)
def test_edges_that_meet_make_one_junction(grays):
    contours = segment(sectors(*grays), uniform_grid((100, 100), spacing=8.0)).contours
    assert len(contours) == len(grays)
    meeting = [c.points[[0, -1]][list(c.junctions)] for c in contours]
    assert all(len(places) == 1 for places in meeting)
    places = np.concatenate(meeting)
    np.testing.assert_array_equal(places, np.broadcast_to(places[0], places.shape))
    assert np.linalg.norm(places[0] - (49.7, 49.4)) < 2.0


def test_the_sides_of_a_contour_follow_the_ridge():
    """Every position on its sides, including corners, is within 0.05 px of the maximum of the edge map across it."""
    scene = polygon((70, 70), np.array([(15, 12), (54, 12), (54, 33), (33, 33), (33, 55), (15, 55)]) + 0.3)
    engine = Engine(scene.values)
    state = engine.start(circle((30.0, 20.0), 7.0))
    while not state.stop_reason:
        state = engine.step(state, Parameters())
    (contour,) = engine.result(state, Parameters()).contours
    assert contour.closed
    sides = np.concatenate(
        [a + (b - a) * np.linspace(0.0, 1.0, 9)[:, None] for a, b in itertools.pairwise(contour.path)]
    )
    place, found = refine_to_ridge(sides, engine.scale_field(Parameters()))
    assert found.all()
    assert np.linalg.norm(place - sides, axis=1).max() < 0.05
