"""What a start reaches, and how reach, weakest edge, damping, weights and annealing decide on it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from cpm_core.segmentation.reach.reach_map import build_reach_map, creeping_distance
from scipy.spatial import cKDTree

from cpm_core.contours.contour import sample_contours
from cpm_core.field.scale_field import build_scale_field
from cpm_core.image.regions import Regions
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.parameters import PRESETS, UNLIMITED_REACH, Parameters
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import segment
from cpm_core.segmentation.reach.drawn_area import drawn_area, typical_radius
from tests.core import scenes

SHAPE = PRESETS["shape"]
LOCAL = replace(SHAPE, weakest_edge=0.0)
ROW, COL = np.indices((96, 160))
LEFT, RIGHT, RADIUS = (48.0, 40.0), (48.0, 120.0), 22.0
START = circle(LEFT, 10.0)


def disk(center, radius, level):
    return level * np.clip(radius + 0.5 - np.hypot(ROW - center[0], COL - center[1]), 0.0, 1.0)


def joined(right=200.0):
    """Two disks that a bright band joins."""
    band = 200.0 * ((np.abs(ROW - 48.0) < 4.0) & (COL > 40.0) & (COL < 120.0))
    return np.maximum(np.maximum(disk(LEFT, RADIUS, 200.0), disk(RIGHT, RADIUS, right)), band)


def apart(right=200.0):
    return disk(LEFT, RADIUS, 200.0) + disk(RIGHT, RADIUS, right)


def crossed():
    """A gray disk on a background of two levels, whose border meets it in junctions."""
    background = np.where(ROW < 48, 0.0, 90.0)
    inside = np.clip(RADIUS + 0.5 - np.hypot(ROW - LEFT[0], COL - LEFT[1]), 0.0, 1.0)
    return background * (1.0 - inside) + 220.0 * inside


def length(result):
    return sum(contour.length for contour in result.contours)


def closed_map(shape):
    return np.zeros(shape, bool)


def map_of(values, start=START, parameters=LOCAL):
    return build_reach_map(build_scale_field(values, 1.0, 0.0), start, closed_map(values.shape), parameters)


def covered(contours, center, radius):
    """Fraction of a circle that contours follow within 1.5 px."""
    found = sample_contours(contours)
    return (cKDTree(found).query(circle(center, radius, 0.5))[0] < 1.5).mean() if len(found) else 0.0


@pytest.mark.parametrize("start", [LEFT, RIGHT])
def test_a_start_in_one_of_two_objects_finds_that_one_only(start):
    other = RIGHT if start == LEFT else LEFT
    result = segment(apart(), circle(start, 10.0), SHAPE)
    assert [contour.closed for contour in result.contours] == [True]
    assert covered(result.contours, start, RADIUS) == 1.0
    assert covered(result.contours, other, RADIUS) == 0.0
    assert result.contours[0].reached == "flight"


def halves(left, right):
    """A rectangle of two levels whose common border is column 80."""
    inside = (np.abs(ROW - 48) < 24) & (np.abs(COL - 80) < 36)
    return np.where(inside, np.where(COL < 80, left, right), 0.0)


def ways_between(values, start):
    """Ways to the edges between the halves."""
    found = map_of(values, start)
    return {found.way_of(np.array([[row, 79.0], [row, 80.0]])) for row in np.arange(38.0, 59.0)}


def test_separate_starts_in_two_things_that_touch_also_reach_the_border_between_them():
    starts = np.concatenate([circle((48.0, 62.0), 8.0), circle((48.0, 98.0), 8.0)])
    assert ways_between(halves(100.0, 200.0), starts) == {"flight"}


@pytest.mark.parametrize(
    "start",
    [circle((48.0, 80.0), 16.0), np.concatenate([circle((48.0, 62.0), 8.0), circle((48.0, 98.0), 8.0)])],
    ids=["one", "two"],
)
def test_a_border_that_is_weak_beside_the_outline_parts_neither_one_start_nor_two(start):
    assert "flight" not in ways_between(halves(170.0, 200.0), start)


def test_a_start_in_the_open_takes_nothing_from_one_in_an_object():
    both = np.concatenate([START, circle((20.0, 80.0), 6.0)])
    values = disk(LEFT, RADIUS, 200.0)
    assert np.array_equal(map_of(values, both).way, map_of(values).way)


def test_without_a_limit_a_border_that_meets_the_object_is_found_too():
    near = segment(crossed(), START, replace(LOCAL, reach=0.0))
    far = segment(crossed(), START, replace(LOCAL, reach=UNLIMITED_REACH))
    assert covered(near.contours, LEFT, RADIUS) > 0.95
    assert sample_contours(near.contours)[:, 1].max() < 70.0
    assert sample_contours(far.contours)[:, 1].max() > 150.0
    assert {contour.reached for contour in far.contours} == {"flight", "junction"}


def test_reach_is_a_length_along_the_edge_beyond_the_junction():
    reached = [
        segment(crossed(), START, replace(SHAPE, reach=reach, weakest_edge=0.0)).contours
        for reach in (20.0, 40.0, 60.0)
    ]
    ends = [sample_contours(contours)[:, 1].max() - (LEFT[1] + RADIUS) for contours in reached]
    np.testing.assert_allclose(ends, [20.0, 40.0, 60.0], atol=8.0)


def test_a_larger_budget_reaches_all_that_a_smaller_one_does_and_more():
    found = map_of(crossed())
    masks = [found.ridge_within(budget) for budget in (0.0, 10.0, 30.0, 80.0)]
    assert all((after >= before).all() and after.sum() > before.sum() for before, after in pairwise(masks))


@pytest.mark.parametrize(
    ("name", "values"), [("reach", (0.0, 5.0, 50.0, 299.0, 300.0)), ("annealing", (0.5, 0.9, 0.99, 0.999, 1.0)),
                         ("w1", (0.0, 0.5, 1.6, 1.74))]
)  # fmt: skip
def test_fronts_creep_farther_with_more_reach_push_and_annealing(name, values):
    budgets = [creeping_distance(replace(SHAPE, **{name: value})) for value in values]
    assert all(before < after for before, after in pairwise(budgets))


def test_less_damping_carries_particles_across_a_weak_edge():
    """A disk within a ring of another level: at rest on the inner edge with much damping, beyond it with little."""
    values = disk(LEFT, 34.0, 100.0) + disk(LEFT, 16.0, 100.0)
    start = circle(LEFT, 6.0)
    calm, fast = (segment(values, start, replace(SHAPE, beta=beta, weakest_edge=0.0)) for beta in (2.0, 0.25))
    assert covered(calm.contours, LEFT, 16.0) == 1.0
    assert covered(calm.contours, LEFT, 34.0) == 0.0
    assert covered(fast.contours, LEFT, 34.0) > 0.9


def test_edges_weaker_than_those_first_met_are_left_out():
    values = joined(right=60.0)
    found = {weakest: map_of(values, parameters=replace(SHAPE, weakest_edge=weakest)) for weakest in (0.0, 0.6)}
    weak = np.zeros(values.shape, bool)
    weak[tuple(np.rint(circle(RIGHT, RADIUS + 0.5)).astype(int).T)] = True
    assert (found[0.0].way[weak] > 0).mean() > 0.8
    assert (found[0.6].way[weak] > 0).mean() < 0.3


def test_the_hole_of_a_ring_is_reached_on_flight():
    values = disk(LEFT, 34.0, 200.0) - disk(LEFT, 14.0, 200.0)
    result = segment(values, circle((48.0, 64.0), 5.0), SHAPE)
    np.testing.assert_allclose(sorted(c.area for c in result.contours), [np.pi * 14.5**2, np.pi * 34.5**2], rtol=0.1)
    assert {contour.reached for contour in result.contours} == {"flight"}


@pytest.mark.parametrize("center", [(45.0, 25.0), (30.0, 48.0), (48.0, 10.0), (90.0, 48.0)])
def test_a_u_is_recovered_from_inside_across_and_outside_of_it(center):
    scene = scenes.u_shape()
    result = segment(scene.values, circle(center, 8.0), SHAPE)
    assert [contour.closed for contour in result.contours] == [True]
    assert cKDTree(sample_contours(result.contours)).query(scene.boundary)[0].max() < 1.5


@pytest.mark.parametrize("parameters", [SHAPE, replace(SHAPE, reach=0.0), LOCAL])
def test_a_start_from_everywhere_is_not_limited(parameters):
    values = apart(right=120.0)
    seeds = uniform_grid(values.shape)
    assert map_of(values, seeds, parameters) is None
    limited, free = (
        segment(values, seeds, p) for p in (parameters, replace(parameters, reach=300.0, weakest_edge=0.0))
    )
    np.testing.assert_array_equal(limited.particles, free.particles)


def test_without_limits_a_run_is_the_run_in_the_whole_field():
    engine = Engine(apart(), Parameters())
    state = engine.start(START)
    assert engine._field_of(state, Parameters()) is engine.scale_field(Parameters(), state.scale)


def test_a_barrier_bounds_what_a_start_lies_in():
    values = disk(LEFT, 34.0, 200.0)
    regions = Regions(barriers=(((4.0, 46.0), (92.0, 46.0)),))
    result = segment(values, circle((48.0, 26.0), 8.0), SHAPE, regions=regions)
    assert result.contours
    assert sample_contours(result.contours)[:, 1].max() < 47.0


def test_another_reach_acts_at_the_next_step_and_wakes_a_run_at_rest():
    small, large = (replace(SHAPE, reach=reach, weakest_edge=0.0) for reach in (0.0, 60.0))
    engine = Engine(crossed(), small)
    state = engine.start(START)
    while not state.stop_reason:
        state = engine.step(state, small)
    before = length(engine.result(state, small))
    state = engine.step(state.resume(), large)
    while not state.stop_reason:
        state = engine.step(state, large)
    assert length(engine.result(state, large)) > before + 60.0


def test_the_area_of_a_start_is_what_it_encloses():
    area = drawn_area(circle((30.0, 40.0), 12.0), (64, 96))
    row, col = np.indices(area.shape)
    away = np.hypot(row - 30.0, col - 40.0)
    assert area[away < 11.0].all()
    assert not area[away > 13.5].any()
    assert typical_radius(area) == pytest.approx(12.0, abs=1.5)
