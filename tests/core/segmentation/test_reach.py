"""How far a run goes beyond the area of its start, and how damping, weights, annealing and reach decide on it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

from cpm_core.contours.contour import sample_contours
from cpm_core.image.regions import Regions
from cpm_core.model.equations import creeping_range
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.parameters import PRESETS, UNLIMITED_REACH
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import segment
from tests.core import scenes

SHAPE = PRESETS["shape"]
ROW, COL = np.indices((96, 160))
LEFT, RIGHT, RADIUS = (48.0, 40.0), (48.0, 120.0), 22.0
START = circle(LEFT, 10.0)


def disk(center, radius, level):
    return level * np.clip(radius + 0.5 - np.hypot(ROW - center[0], COL - center[1]), 0.0, 1.0)


def apart(right=200.0):
    return disk(LEFT, RADIUS, 200.0) + disk(RIGHT, RADIUS, right)


def crossed():
    """A gray disk on a background of two levels, whose border meets it in junctions."""
    background = np.where(ROW < 48, 0.0, 90.0)
    inside = np.clip(RADIUS + 0.5 - np.hypot(ROW - LEFT[0], COL - LEFT[1]), 0.0, 1.0)
    return background * (1.0 - inside) + 220.0 * inside


def length(result):
    return sum(contour.length for contour in result.contours)


def run(engine, state, parameters):
    """All states of a run from one."""
    states = [state]
    while not states[-1].stop_reason:
        states.append(engine.step(states[-1], parameters))
    return states


def covered(contours, center, radius):
    """Fraction of a circle that contours follow within 1.5 px."""
    found = sample_contours(contours)
    return (cKDTree(found).query(circle(center, radius, 0.5))[0] < 1.5).mean() if len(found) else 0.0


def farthest(parameters):
    """Distance beyond the disk to which a run in it finds the border that meets it."""
    contours = segment(crossed(), START, replace(parameters, weakest_edge=0.0)).contours
    assert covered(contours, LEFT, RADIUS) > 0.95
    return sample_contours(contours)[:, 1].max() - (LEFT[1] + RADIUS)


@pytest.mark.parametrize("start", [LEFT, RIGHT])
def test_a_start_in_one_of_two_objects_finds_that_one_only(start):
    other = RIGHT if start == LEFT else LEFT
    result = segment(apart(), circle(start, 10.0), SHAPE)
    assert [contour.closed for contour in result.contours] == [True]
    assert covered(result.contours, start, RADIUS) == 1.0
    assert covered(result.contours, other, RADIUS) == 0.0


def test_a_front_creeps_along_a_border_that_meets_the_object_as_far_as_reach_says():
    ends = [farthest(replace(SHAPE, reach=reach)) for reach in (0.0, 30.0, 60.0)]
    assert ends[0] < 8.0
    np.testing.assert_allclose(ends[1:], [30.0, 60.0], atol=8.0)
    assert farthest(replace(SHAPE, reach=UNLIMITED_REACH)) > 80.0


@pytest.mark.parametrize(
    ("name", "values"), [("annealing", (0.95, 0.99, 0.995)), ("w1", (0.5, 1.6, 1.68)), ("beta", (1.6, 0.8, 0.6))]
)
def test_each_slider_moves_the_end_of_a_front_in_one_direction(name, values):
    ends = [farthest(replace(SHAPE, reach=20.0, **{name: value})) for value in values]
    assert all(before <= after + 1.0 for before, after in pairwise(ends))
    assert ends[-1] > ends[0] + 15.0


def test_no_particle_of_a_run_has_crept_beyond_the_range_and_in_the_area_none_has_crept():
    parameters = replace(SHAPE, reach=30.0, weakest_edge=0.0)
    engine = Engine(crossed(), parameters)
    states = run(engine, engine.start(START), parameters)
    area, crept = engine.start_area(states[0].start, parameters), []
    for before, state in pairwise(states):
        place = np.rint(state.position).astype(int).clip(0, np.array(area.shape) - 1)
        limit = creeping_range(parameters) * 0.5**state.scale
        if state.deleted or state.stop_reason:
            assert state.particles.crept.max() <= limit + parameters.d_min
        if state.scale == 0 and state.step_of_scale:
            # a particle that has just been born of one inside and one outside has the mean of both
            old = state.particles.identity < before.next_identity
            assert not state.particles.crept[area[tuple(place.T)] & old].any()
            crept.append(state.particles.crept.max())
    assert max(crept) > 20.0


def test_more_damping_finds_no_more():
    """A disk within a ring of another level."""
    values = disk(LEFT, 34.0, 100.0) + disk(LEFT, 16.0, 100.0)
    found = [length(segment(values, circle(LEFT, 6.0), replace(SHAPE, beta=beta))) for beta in (0.1, 0.4, 0.8, 2.0)]
    assert all(before >= after - 2.0 for before, after in pairwise(found))


@pytest.mark.parametrize("center", [(45.0, 25.0), (30.0, 48.0), (48.0, 10.0), (90.0, 48.0)])
def test_a_u_is_recovered_from_inside_across_and_outside_of_it(center):
    scene = scenes.u_shape()
    result = segment(scene.values, circle(center, 8.0), SHAPE)
    assert [contour.closed for contour in result.contours] == [True]
    assert cKDTree(sample_contours(result.contours)).query(scene.boundary)[0].max() < 1.5


def test_both_rims_of_a_ring_are_found_from_within_it():
    values = disk(LEFT, 34.0, 200.0) - disk(LEFT, 14.0, 200.0)
    result = segment(values, circle((48.0, 64.0), 5.0), SHAPE)
    np.testing.assert_allclose(sorted(c.area for c in result.contours), [np.pi * 14.5**2, np.pi * 34.5**2], rtol=0.1)


@pytest.mark.parametrize("reach", [0.0, SHAPE.reach])
def test_a_start_from_everywhere_is_not_limited(reach):
    values = apart(right=120.0)
    seeds = uniform_grid(values.shape)
    limited, free = (segment(values, seeds, replace(SHAPE, reach=r)) for r in (reach, UNLIMITED_REACH))
    np.testing.assert_array_equal(limited.particles, free.particles)


def test_a_barrier_bounds_what_a_start_lies_in():
    values = disk(LEFT, 34.0, 200.0)
    regions = Regions(barriers=(((4.0, 46.0), (92.0, 46.0)),))
    result = segment(values, circle((48.0, 26.0), 8.0), SHAPE, regions=regions)
    assert result.contours
    assert sample_contours(result.contours)[:, 1].max() < 47.0


def test_another_reach_acts_at_the_next_step_and_wakes_a_run_at_rest():
    small, large = (replace(SHAPE, reach=reach, weakest_edge=0.0) for reach in (0.0, 60.0))
    engine = Engine(crossed(), small)
    last = run(engine, engine.start(START), small)[-1]
    after = run(engine, engine.step(last.resume(), large), large)[-1]
    assert length(engine.result(after, large)) > length(engine.result(last, small)) + 60.0
    back = run(engine, engine.step(after.resume(), small), small)[-1]
    assert length(engine.result(back, small)) < length(engine.result(last, small)) + 15.0
