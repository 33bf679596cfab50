"""Interventions in a run: particles that join or are erased, and regions that move."""

from itertools import pairwise

import numpy as np
import pytest

from cpm_core import Engine, Parameters, Regions, circle

from ..scenes import antialiased, disk

ONE_SCALE = Parameters(scales=1)
TWO = antialiased(
    (96, 192), lambda row, col: (np.hypot(row - 47.4, col - 45.3) < 25) | (np.hypot(row - 47.4, col - 145.3) < 25)
)
LEFT, RIGHT = circle((47.4, 45.3), 15.0), circle((47.4, 145.3), 15.0)
BAR = antialiased((48, 200), lambda row, col: row + 0.0 * col < 24.3)
"""One horizontal edge from the left border to the right."""

SEEDS = np.array([(24.0, 10.0), (24.0, 12.0), (24.0, 14.0)])


def run(engine, state, parameters, most=3000):
    for _ in range(most):
        if state.stop_reason:
            break
        state = engine.step(state, parameters)
    return state


def walked(engine, state, parameters, steps):
    states = [state]
    for _ in range(steps):
        states.append(engine.step(states[-1], parameters))
    return states


@pytest.fixture(scope="module")
def engine():
    return Engine(TWO, ONE_SCALE)


@pytest.fixture(scope="module")
def left(engine):
    state = run(engine, engine.start(LEFT), ONE_SCALE)
    assert state.converged
    assert state.position[:, 1].max() < 75.0
    return state


def test_particles_that_join_a_run_at_rest_find_their_edges(engine, left):
    state = engine.add_particles(left, np.concatenate([RIGHT, [(-5.0, 10.0), (40.0, 500.0)]]))
    assert state.stop_reason == ""
    assert not state.converged
    assert state.count == left.count + len(RIGHT)
    np.testing.assert_allclose(state.position[left.count :], RIGHT)
    assert not state.particles.velocity[left.count :].any()
    assert len(np.unique(state.particles.identity)) == state.count
    assert state.next_identity > state.particles.identity.max()
    last = run(engine, state, ONE_SCALE)
    assert last.converged
    contours = engine.result(last, ONE_SCALE).contours
    assert [contour.closed for contour in contours] == [True, True]


def test_particles_that_join_at_a_coarse_scale_are_seeds_of_the_finer_ones():
    parameters = Parameters(scales=3)
    engine = Engine(TWO, parameters)
    state = walked(engine, engine.start(LEFT), parameters, 3)[-1]
    assert state.scale == 2
    joined = engine.add_particles(state, RIGHT)
    np.testing.assert_allclose(joined.position[state.count :], RIGHT)
    np.testing.assert_array_equal(joined.start, np.concatenate([LEFT, RIGHT]))
    assert len(engine.result(run(engine, joined, parameters), parameters).contours) == 2


def test_erased_particles_are_gone_and_the_others_are_unchanged(engine, left):
    upper = left.position[:, 0] < 40.0
    erased = engine.erase_particles(left, upper)
    assert erased.count == int((~upper).sum())
    for name in ("position", "velocity", "force", "distance", "identity", "crept"):
        np.testing.assert_array_equal(getattr(erased.particles, name), getattr(left.particles, name)[~upper])
    np.testing.assert_array_equal(erased.start, left.start)
    assert erased.converged
    assert left.count == len(upper)
    [contour] = engine.result(erased, ONE_SCALE).contours
    assert not contour.closed
    again = run(engine, erased.resume(), ONE_SCALE)
    assert again.converged
    assert again.count == erased.count
    assert not engine.result(again, ONE_SCALE).contours[0].closed
    assert engine.erase_particles(left, np.zeros(left.count, bool)) is left


def test_erased_particles_do_not_begin_again_at_a_finer_scale():
    parameters = Parameters(scales=2)
    engine = Engine(TWO, parameters)
    state = walked(engine, engine.start([*LEFT, *RIGHT]), parameters, 5)[-1]
    assert state.scale == 1
    erased = engine.erase_particles(state, lambda points: points[:, 1] > 96.0)
    assert run(engine, erased, parameters).position[:, 1].max() < 96.0


def test_a_run_whose_particles_are_all_erased_ends_and_continues_with_new_ones(engine, left):
    empty = engine.erase_particles(left, np.ones(left.count, bool))
    assert empty.count == 0
    assert "erased" in empty.stop_reason
    assert not empty.converged
    assert engine.step(empty, ONE_SCALE) is empty
    assert run(engine, engine.add_particles(empty, LEFT), ONE_SCALE).converged
    resumed = engine.step(empty.resume(), ONE_SCALE)
    assert resumed.count == 0
    assert resumed.stop_reason


def test_a_barrier_before_a_front_holds_it_until_it_is_removed():
    engine = Engine(BAR, ONE_SCALE)
    states = walked(engine, engine.start(SEEDS), ONE_SCALE, 20)
    front = states[-1].position[:, 1].max()
    assert front < 120.0
    barrier_col = front + 15.0
    barred = engine.with_regions(Regions(barriers=(((-5.0, barrier_col), (60.0, barrier_col + 0.7)),)))
    held = walked(barred, states[-1], ONE_SCALE, 120)
    assert max(state.position[:, 1].max() for state in held) < barrier_col + 0.7
    assert held[-1].position[:, 1].max() > barrier_col - 3.0
    free = walked(barred.with_regions(None), held[-1].resume(), ONE_SCALE, 200)
    assert free[-1].position[:, 1].max() > 190.0


def test_particles_under_a_barrier_neither_stick_to_it_nor_cross_it(engine, left):
    generator = np.random.default_rng(1)
    points = np.stack([generator.uniform(30.0, 65.0, 200), generator.uniform(25.0, 65.0, 200)], axis=1)
    line = ((20.0, 45.0), (75.0, 45.0))
    points[:40, 1] = 45.0 + generator.choice([-1e-5, 1e-5, -1e-3, 1e-3], 40)
    points[40:45, 1] = 45.0
    begun = engine.step(engine.add_particles(left, points), ONE_SCALE)
    barred = engine.with_regions(Regions(barriers=(line,)))
    states = walked(barred, begun, ONE_SCALE, 60)
    for one, other in pairwise(states):
        _, before, after = np.intersect1d(one.particles.identity, other.particles.identity, return_indices=True)
        start, end = one.position[before], other.position[after]
        at_barrier = (start[:, 0] > 20.0) & (start[:, 0] < 75.0) & (end[:, 0] > 20.0) & (end[:, 0] < 75.0)
        assert not (at_barrier & ((start[:, 1] - 45.0) * (end[:, 1] - 45.0) < 0.0)).any()
    last = run(barred, states[-1], ONE_SCALE)
    assert last.converged
    assert (np.abs(np.hypot(*(last.position - (47.4, 45.3)).T) - 25.0) < 2.0).all()


@pytest.mark.parametrize("barriers", [(), (((3.0, 3.0), (90.0, 70.0), (20.0, 60.5)),)])
@pytest.mark.parametrize("interest", [(), (((5, 5), (5, 80), (85, 80), (85, 5)), ((50, 50), (95, 50), (95, 95)))])
def test_an_engine_with_other_regions_equals_one_made_for_them(interest, barriers):
    scene = disk((96, 96), (47.4, 47.3), 30.0)
    parameters = Parameters(scales=2)
    regions = Regions(interest, barriers)
    made = Engine(scene.values, parameters, regions)
    former = Regions((((5, 5), (5, 70), (85, 80)),), (((50.0, 50.0), (60.0, 60.0)),))
    for other in (Engine(scene.values, parameters), Engine(scene.values, parameters, former)):
        for smoothing in (1.0, 2.0):
            asked = Parameters(scales=2, smoothing=smoothing)
            moved = other.with_regions(regions)
            for scale in range(2):
                one, two = made.scale_field(asked, scale), moved.scale_field(asked, scale)
                for name in ("packed", "gradient", "edge_map"):
                    np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
                assert (one.floor, one.strongest) == (two.floor, two.strongest)
                np.testing.assert_array_equal(one.fixed_charges, two.fixed_charges)
                np.testing.assert_array_equal(one.barrier_map.segments, two.barrier_map.segments)
                np.testing.assert_array_equal(one.barrier_map.clearance, two.barrier_map.clearance)
