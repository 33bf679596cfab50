"""Ground, against a dictionary of visited cells."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.particles.coverage import no_coverage, renewed
from cpm_core.particles.coverage.plane import cover, idle_at

SHAPE = (50, 38)
SIDE = 4.0
ACROSS = 9

positions = st.lists(st.tuples(st.floats(-0.5, 49.5), st.floats(-0.5, 37.5)), max_size=8).map(
    lambda points: np.array(points, dtype=float).reshape(-1, 2)
)
visitors = st.tuples(positions, st.integers(0, 255)).map(
    lambda visit: (visit[0], np.array([visit[1] >> i & 1 == 0 for i in range(len(visit[0]))], dtype=bool))
)
"""Particles, and which of them sit on an edge."""

tours = st.lists(visitors, min_size=1, max_size=6)


def cell(point):
    return int((point[0] + 0.5) // SIDE), int((point[1] + 0.5) // SIDE)


def tour(visits):
    """Both ways: arrays and dictionary, after particles at `visits` in one step after the other."""
    coverage, first, latest = no_coverage(SHAPE), {}, []
    for step, (points, on_edge) in enumerate(visits, start=1):
        coverage, new = cover(coverage, points, on_edge, step)
        fresh = {cell(p) for p in points[on_edge]} - set(first)
        first.update(dict.fromkeys(fresh, step))
        latest.append((new, len(fresh)))
    return coverage, first, latest


@settings(max_examples=60, deadline=None)
@given(tours)
def test_first_visits_are_kept_and_counted_once(visits):
    coverage, first, latest = tour(visits)
    assert all(found == truth for found, truth in latest)
    assert {tuple(map(int, c)): int(coverage.found[tuple(c)]) for c in np.argwhere(coverage.found >= 0)} == first
    assert coverage.size == len(first)


@settings(max_examples=60, deadline=None)
@given(tours, positions)
def test_idle_steps_count_from_the_newest_ground_around(visits, points):
    coverage, first, _ = tour(visits)
    now, far = 20, 99
    assert idle_at(coverage, points, now, far).tolist() == idle_truth(first, points, now, far)


def idle_truth(first, points, now, far):
    truth = []
    for p in points:
        row, col = cell(p)
        near = [s for (r, c), s in first.items() if max(abs(r - row), abs(c - col)) <= ACROSS // 2]
        truth.append(now - max(near) if near else far)
    return truth


@settings(max_examples=60, deadline=None)
@given(tours, tours, positions)
def test_renewed_ground_counts_as_just_found_and_is_explored_further(visits, later, points):
    coverage, first, _ = tour(visits)
    coverage, first = renewed(coverage, 10), dict.fromkeys(first, 10)
    assert idle_at(coverage, points, 10, 99).tolist() == idle_truth(first, points, 10, 99)
    for step, (places, on_edge) in enumerate(later, start=11):
        coverage, new = cover(coverage, places, on_edge, step)
        fresh = {cell(p) for p in places[on_edge]} - set(first)
        first.update(dict.fromkeys(fresh, step))
        assert new == len(fresh)
    assert idle_at(coverage, points, 30, 99).tolist() == idle_truth(first, points, 30, 99)


def test_old_ground_is_no_news_and_leaves_the_ground_as_it_is():
    points, both = np.array([(10.0, 10.0), (30.0, 20.0)]), np.ones(2, bool)
    coverage, new = cover(no_coverage(SHAPE), points, both, 3)
    assert new == 2
    again, none = cover(coverage, points, both, 8)
    assert none == 0
    assert again is coverage


def test_who_sits_on_no_edge_finds_no_ground():
    points = np.array([(10.0, 10.0), (30.0, 20.0)])
    coverage, new = cover(no_coverage(SHAPE), points, np.array([False, True]), 3)
    assert new == coverage.size == 1
    assert idle_at(coverage, points, 5, 99).tolist() == [99, 2]


def test_exploring_and_renewing_do_not_change_their_input():
    before, one = no_coverage(SHAPE), np.ones(1, bool)
    after, _ = cover(before, np.array([(10.0, 10.0)]), one, 3)
    assert (before.found == -1).all()
    assert (before.latest == -1).all()
    kept = after.found.copy(), after.latest.copy()
    cover(after, np.array([(40.0, 10.0)]), one, 4)
    renewed(after, 7)
    np.testing.assert_array_equal((after.found, after.latest), kept)


def test_every_place_on_the_image_has_a_cell():
    corners = np.array([(-0.5, -0.5), (49.5, 37.5), (-0.5, 37.5), (49.5, -0.5)])
    _, new = cover(no_coverage(SHAPE), corners, np.ones(4, bool), 1)
    assert new == 4
