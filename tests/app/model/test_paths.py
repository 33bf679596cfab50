"""Paths: lengths, distances and fewer corners, against what can be worked out by hand or by looking everywhere."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.numerics import polyline

coordinates = st.integers(-50, 50).map(float)
positions = st.tuples(coordinates, coordinates)
lines = st.lists(positions, min_size=2, max_size=6)


@given(lines, positions)
def test_the_distance_is_that_of_the_nearest_place_on_the_path(line, position) -> None:
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    places = np.concatenate([np.array(a) + share * (np.array(b) - a) for a, b in pairwise(line)])
    nearest = np.hypot(*(places - position).T).min()
    assert polyline.distance(line, position) == pytest.approx(nearest, abs=0.05)


@given(lines)
def test_a_thinned_path_has_the_same_ends_and_stays_within_a_quarter_of_a_pixel(line) -> None:
    thin = polyline.thinned(line)
    assert (thin[0], thin[-1]) == (line[0], line[-1])
    assert set(thin) <= set(line)
    assert all(polyline.distance(thin, corner) <= 0.25 + 1e-9 for corner in line)


def test_a_straight_freehand_line_needs_its_ends_alone() -> None:
    assert polyline.thinned([(float(k), 2.0 * k) for k in range(30)]) == ((0.0, 0.0), (29.0, 58.0))


def test_length_and_area_of_a_rectangle() -> None:
    corners = ((1.0, 1.0), (1.0, 5.0), (4.0, 5.0), (4.0, 1.0))
    assert polyline.length(corners) == 4.0 + 3.0 + 4.0
    assert polyline.area(corners) == 12.0


@given(lines, positions)
def test_a_moved_path_keeps_its_shape(line, by) -> None:
    moved = polyline.moved(line, by)
    assert polyline.length(moved) == pytest.approx(polyline.length(line))
    assert math.dist(moved[0], line[0]) == pytest.approx(math.hypot(*by))


@given(st.lists(st.lists(positions, min_size=1, max_size=40), max_size=5), st.sampled_from([0.01, 0.4, 3.0]))
def test_coarser_paths_have_the_same_ends_and_stay_near(lines, off) -> None:
    coarse = polyline.coarser([np.array(line) for line in lines], off)
    assert len(coarse) == len(lines)
    for line, path in zip(lines, coarse, strict=True):
        kept = [tuple(corner) for corner in path.tolist()]
        assert (kept[0], kept[-1]) == (line[0], line[-1])
        followed = iter(line)
        assert all(corner in followed for corner in kept)
        assert all(polyline.distance(kept, corner) <= 3 * off + 1e-9 for corner in line)


def test_a_smooth_path_is_drawn_with_few_corners() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 801)
    circle = 100.0 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    assert len(polyline.coarser([circle, circle], 0.1)[1]) <= 102
