"""Ground, against a dictionary of visited cells."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.particles.coverage import explore, idle_at, renewed, unvisited

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
    ground, first, news = unvisited(SHAPE), {}, []
    for step, (points, seated) in enumerate(visits, start=1):
        ground, new = explore(ground, points, seated, step)
        fresh = {cell(p) for p in points[seated]} - set(first)
        first.update(dict.fromkeys(fresh, step))
        news.append((new, len(fresh)))
    return ground, first, news


@settings(max_examples=60, deadline=None)
@given(tours)
def test_first_visits_are_kept_and_counted_once(visits):
    ground, first, news = tour(visits)
    assert all(found == truth for found, truth in news)
    assert {tuple(map(int, c)): int(ground.found[tuple(c)]) for c in np.argwhere(ground.found >= 0)} == first
    assert ground.size == len(first)


@settings(max_examples=60, deadline=None)
@given(tours, positions)
def test_idle_steps_count_from_the_newest_ground_around(visits, points):
    ground, first, _ = tour(visits)
    now, far = 20, 99
    assert idle_at(ground, points, now, far).tolist() == idle_truth(first, points, now, far)


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
    ground, first, _ = tour(visits)
    ground, first = renewed(ground, 10), dict.fromkeys(first, 10)
    assert idle_at(ground, points, 10, 99).tolist() == idle_truth(first, points, 10, 99)
    for step, (places, seated) in enumerate(later, start=11):
        ground, new = explore(ground, places, seated, step)
        fresh = {cell(p) for p in places[seated]} - set(first)
        first.update(dict.fromkeys(fresh, step))
        assert new == len(fresh)
    assert idle_at(ground, points, 30, 99).tolist() == idle_truth(first, points, 30, 99)


def test_old_ground_is_no_news_and_leaves_the_ground_as_it_is():
    points, both = np.array([(10.0, 10.0), (30.0, 20.0)]), np.ones(2, bool)
    ground, new = explore(unvisited(SHAPE), points, both, 3)
    assert new == 2
    again, none = explore(ground, points, both, 8)
    assert none == 0
    assert again is ground


def test_who_sits_on_no_edge_finds_no_ground():
    points = np.array([(10.0, 10.0), (30.0, 20.0)])
    ground, new = explore(unvisited(SHAPE), points, np.array([False, True]), 3)
    assert new == ground.size == 1
    assert idle_at(ground, points, 5, 99).tolist() == [99, 2]


def test_exploring_and_renewing_do_not_change_their_input():
    before, one = unvisited(SHAPE), np.ones(1, bool)
    after, _ = explore(before, np.array([(10.0, 10.0)]), one, 3)
    assert (before.found == -1).all()
    assert (before.news == -1).all()
    kept = after.found.copy(), after.news.copy()
    explore(after, np.array([(40.0, 10.0)]), one, 4)
    renewed(after, 7)
    np.testing.assert_array_equal((after.found, after.news), kept)


def test_every_place_on_the_image_has_a_cell():
    corners = np.array([(-0.5, -0.5), (49.5, 37.5), (-0.5, 37.5), (49.5, -0.5)])
    _, new = explore(unvisited(SHAPE), corners, np.ones(4, bool), 1)
    assert new == 4
