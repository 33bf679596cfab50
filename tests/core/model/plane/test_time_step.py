"""The two halves of a step, each by itself: what moves and leaves the image, and deletion and insertion."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import Engine, Parameters, Regions
from cpm_core.field.scale_field import build_scale_field
from cpm_core.model.coverage import idle_steps_at
from cpm_core.model.equations import IDLE_STEPS, STILL_DISTANCE, equilibrium_epsilon
from cpm_core.model.plane.motion import current_mesh_force, move_in_plane
from cpm_core.model.plane.step import insert_and_delete, move_particles

from ...scenes import disk
from ..moving import cloud

PARAMETERS = Parameters(scales=1)
SCENE = disk((56, 60), (27.4, 30.2), 15.0)
SHAPE = SCENE.values.shape


@pytest.fixture(scope="module")
def scale_field():
    return build_scale_field(SCENE.values, 1.0, 0.0)


def state_of(points, steps=0):
    """A run from some points, after some steps."""
    engine = Engine(SCENE.values, PARAMETERS)
    state = engine.start(points)
    for _ in range(steps):
        state = engine.step(state, PARAMETERS)
    return state


def idle(state):
    return idle_steps_at(state.coverage, state.particles.position, state.step_of_scale, state.idle)


def test_the_first_half_moves_all_particles_and_measures_it(scale_field):
    before = state_of(cloud(SHAPE, 120, 0), 30)
    after, moved = move_particles(before, idle(before), scale_field, PARAMETERS)
    mesh = current_mesh_force(before, idle(before), scale_field, PARAMETERS)
    truth = move_in_plane(before.particles, idle(before), mesh, scale_field, PARAMETERS)
    np.testing.assert_array_equal(after.particles.position, truth.particles.position)
    way = np.linalg.norm(after.particles.position - before.particles.position, axis=1)
    np.testing.assert_allclose(moved.motion, way, atol=1e-12)
    assert after.displacement == pytest.approx(way.mean())
    assert after.moving == (way > STILL_DISTANCE).sum() > 0
    assert after.epsilon == equilibrium_epsilon(after.particles.distance)
    assert (after.step, after.step_of_scale) == (before.step + 1, before.step_of_scale + 1)
    assert (after.born, after.deleted) == (0, 0)


def test_the_first_half_lets_no_particle_through_a_barrier():
    barred = build_scale_field(SCENE.values, 1.0, 0.0, Regions(barriers=(((20.2, -5.0), (20.2, 65.0)),)))
    before = state_of(cloud(SHAPE, 60, 2))
    before.particles.velocity[:, 0] = 30.0
    after, moved = move_particles(before, idle(before), barred, PARAMETERS)
    start = dict(zip(before.particles.identity.tolist(), before.particles.position, strict=True))
    for number, (i, place) in enumerate(zip(after.particles.identity, after.particles.position, strict=True)):
        assert (start[i][0] < 20.2) == (place[0] < 20.2)
        assert moved.motion[number] == pytest.approx(np.linalg.norm(place - start[i]))


def second_half(scale_field, before, **changes):
    half, moved = move_particles(before, idle(before), scale_field, PARAMETERS)
    half = replace(half, **changes)
    return half, insert_and_delete(half, moved, False, scale_field, PARAMETERS)


def test_late_in_a_run_the_second_half_waits_every_other_step(scale_field):
    before = state_of(cloud(SHAPE, 300, 4), 25)
    changed = []
    for step in (100, 101):
        half, after = second_half(scale_field, before, idle=IDLE_STEPS, step=step)
        changed.append(after.particles is not half.particles)
        assert after.annealed == half.annealed * PARAMETERS.annealing
        assert after.idle in (0, IDLE_STEPS + 1)
    assert changed == [True, False]
