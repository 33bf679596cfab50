"""Paths: lengths, distances and fewer corners, against what can be worked out by hand or by looking everywhere."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core.numerics import polyline

coordinates = st.integers(-50, 50).map(float)
positions = st.tuples(coordinates, coordinates)
lines = st.lists(positions, min_size=2, max_size=6)


@settings(deadline=None)  # the first call may compile
@given(lines, positions)
def test_the_distance_is_that_of_the_nearest_place_on_the_path(line, position) -> None:
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    places = np.concatenate([np.array(a) + share * (np.array(b) - a) for a, b in pairwise(line)])
    nearest = np.hypot(*(places - position).T).min()
    assert polyline.distance_to_path(line, position) == pytest.approx(nearest, abs=0.05)


@settings(deadline=None)  # the first call may compile
@given(lines)
def test_a_thinned_path_has_the_same_ends_and_stays_within_a_quarter_of_a_pixel(line) -> None:
    thin = polyline.simplify_path(line)
    assert (thin[0], thin[-1]) == (line[0], line[-1])
    assert set(thin) <= set(line)
    assert all(polyline.distance_to_path(thin, corner) <= 0.25 + 1e-9 for corner in line)


@settings(deadline=None)  # the first call may compile
@given(st.lists(st.lists(positions, min_size=1, max_size=40), max_size=5), st.sampled_from([0.01, 0.4, 3.0]))
def test_coarser_paths_have_the_same_ends_and_stay_near(lines, off) -> None:
    coarse = polyline.drop_flat_corners([np.array(line) for line in lines], off)
    assert len(coarse) == len(lines)
    for line, path in zip(lines, coarse, strict=True):
        kept = [tuple(corner) for corner in path.tolist()]
        assert (kept[0], kept[-1]) == (line[0], line[-1])
        followed = iter(line)
        assert all(corner in followed for corner in kept)
        assert all(polyline.distance_to_path(kept, corner) <= 3 * off + 1e-9 for corner in line)


def crossings(corners, place):
    """How often a ray from a place to the right crosses the sides of a polygon, with its direction."""
    turns = 0
    for (r0, c0), (r1, c1) in pairwise((*corners, corners[0])):
        if (r0 <= place[0]) != (r1 <= place[0]) and c0 + (place[0] - r0) * (c1 - c0) / (r1 - r0) > place[1]:
            turns += 1 if r1 > r0 else -1
    return turns


@settings(deadline=None)  # the first call may compile
@given(st.lists(positions, min_size=3, max_size=8), positions)
def test_a_polygon_contains_what_it_winds_around(corners, shift) -> None:
    place = (shift[0] + 0.337, shift[1] + 0.219)  # on no side, whose corners are integers
    assume(polyline.distance_to_path((*corners, corners[0]), place) > 1e-6)
    assert polyline.points_inside(corners, np.array([place]))[0] == (crossings(corners, place) != 0)


@settings(deadline=None)  # the first call may compile
@given(lines, st.floats(0.2, 5.0))
def test_a_resampled_path_keeps_its_ends_and_has_one_vertex_between_at_least(line, spacing) -> None:
    path = polyline.resample_path(np.array(line), spacing)
    assert (tuple(path[0]), tuple(path[-1])) == (line[0], line[-1])
    assert len(path) >= 3
    assert polyline.distances_to_path(line, path).max() < 1e-9
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= spacing + 1e-9


@given(st.lists(st.lists(positions, min_size=1, max_size=6), min_size=1, max_size=5), st.integers(1, 5))
def test_the_middles_of_many_paths_are_those_of_each(paths, count) -> None:
    each = [np.array(path) for path in paths]
    np.testing.assert_allclose(
        polyline.midpoints_of_paths(each, count), [polyline.path_midpoints(path, count) for path in each], atol=1e-9
    )
