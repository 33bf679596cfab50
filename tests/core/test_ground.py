"""Ground, against a dictionary of visited cells."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.ground import explore, idle_steps, unvisited

SHAPE = (50, 38)
SIDE = 4.0
ACROSS = 9

positions = st.lists(st.tuples(st.floats(-0.5, 49.5), st.floats(-0.5, 37.5)), max_size=8).map(
    lambda points: np.array(points, dtype=float).reshape(-1, 2)
)
tours = st.lists(positions, min_size=1, max_size=6)


def cell(point):
    return int((point[0] + 0.5) // SIDE), int((point[1] + 0.5) // SIDE)


def tour(visits):
    """Both ways: arrays and dictionary, after particles at `visits` in one step after the other."""
    ground, first, news = unvisited(SHAPE), {}, []
    for step, points in enumerate(visits, start=1):
        ground, new = explore(ground, points, step)
        fresh = {cell(p) for p in points} - set(first)
        first.update(dict.fromkeys(fresh, step))
        news.append((new, len(fresh)))
    return ground, first, news


@settings(max_examples=60, deadline=None)
@given(tours)
def test_first_visits_are_kept_and_counted_once(visits):
    ground, first, news = tour(visits)
    assert all(found == truth for found, truth in news)
    assert {tuple(map(int, c)): int(ground[tuple(c)]) for c in np.argwhere(ground >= 0)} == first


@settings(max_examples=60, deadline=None)
@given(tours, positions)
def test_idle_steps_count_from_the_newest_ground_around(visits, points):
    ground, first, _ = tour(visits)
    now, far = 20, 99
    truth = []
    for p in points:
        row, col = cell(p)
        near = [s for (r, c), s in first.items() if max(abs(r - row), abs(c - col)) <= ACROSS // 2]
        truth.append(now - max(near) if near else far)
    assert idle_steps(ground, points, now, far).tolist() == truth


def test_old_ground_is_no_news_and_leaves_the_array_alone():
    points = np.array([(10.0, 10.0), (30.0, 20.0)])
    ground, new = explore(unvisited(SHAPE), points, 3)
    assert new == 2
    again, none = explore(ground, points, 8)
    assert none == 0
    assert again is ground


def test_exploring_does_not_change_its_input():
    before = unvisited(SHAPE)
    explore(before, np.array([(10.0, 10.0)]), 3)
    assert (before == -1).all()


def test_every_place_on_the_image_has_a_cell():
    corners = np.array([(-0.5, -0.5), (49.5, 37.5), (-0.5, 37.5), (49.5, -0.5)])
    _, new = explore(unvisited(SHAPE), corners, 1)
    assert new == 4
