"""Segments: distances and crossings against exact arithmetic."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core.numerics.segments import (
    SegmentTree,
    first_crossing,
    segments_meet,
)

places = st.tuples(st.integers(-9, 9), st.integers(-9, 9))
segments = st.tuples(places, places).filter(lambda ends: ends[0] != ends[1])


def turn(one, other):
    """Zero for parallel segments."""
    (p, q), (a, b) = one, other
    return (q[0] - p[0]) * (b[1] - a[1]) - (q[1] - p[1]) * (b[0] - a[0])


def common(one, other):
    """Whether two segments have a place in common, by fractions: the equations of both are solved."""
    (p, q), (a, b) = one, other
    d, e, f = (q[0] - p[0], q[1] - p[1]), (b[0] - a[0], b[1] - a[1]), (a[0] - p[0], a[1] - p[1])
    if turned := turn(one, other):
        t, u = Fraction(f[0] * e[1] - f[1] * e[0], turned), Fraction(f[0] * d[1] - f[1] * d[0], turned)
        return 0 <= t <= 1 and 0 <= u <= 1
    if f[0] * d[1] - f[1] * d[0]:
        return False
    axis = 0 if d[0] else 1
    return max(min(p[axis], q[axis]), min(a[axis], b[axis])) <= min(max(p[axis], q[axis]), max(a[axis], b[axis]))


@settings(deadline=None)  # the first call compiles
@given(segments, segments)
def test_segments_meet_where_they_have_a_place_in_common(one, other):
    flat = np.array(one, dtype=float).ravel()
    assert segments_meet(flat, *np.array(other, dtype=float)) == common(one, other)


@given(st.lists(places, min_size=2, max_size=5, unique=True), st.lists(segments, max_size=5))
def test_the_first_crossing_of_a_path_is_found(path, others):
    """Where the two are not parallel, which needs no more care."""
    steps = list(pairwise(path))
    assume(all(turn(step, other) for step in steps for other in others))
    found = [(n, s) for n, step in enumerate(steps) for s, other in enumerate(others) if common(step, other)]
    flat = np.array(others, dtype=float).reshape(-1, 4)
    assert first_crossing(np.array(path, dtype=float), flat) == (found[0] if found else (-1, -1))


@pytest.mark.parametrize("count", [1, 3, 400])
def test_the_tree_finds_the_distance_from_the_nearest_segment(count):
    rng = np.random.default_rng(count)
    begin, end = rng.uniform(0.0, 50.0, (2, count, 2))
    points = rng.uniform(-5.0, 55.0, (60, 2))
    share = np.linspace(0.0, 1.0, 2001)[:, None, None]
    every = begin + share * (end - begin)
    brute = np.array([np.hypot(*(every - point).reshape(-1, 2).T).min() for point in points])
    np.testing.assert_allclose(SegmentTree(begin, end).distances_to(points), brute, atol=0.03)
