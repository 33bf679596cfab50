"""The two halves of a step, each by itself: what moves and leaves the image, and deletion and insertion."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import Engine, Parameters, Regions, circle
from cpm_core.field.scale_field import build_scale_field
from cpm_core.model.coverage import idle_steps_at
from cpm_core.model.equations import IDLE_STEPS, STILL_DISTANCE, equilibrium_epsilon
from cpm_core.model.plane import step as plane_step
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
    np.testing.assert_array_equal(after.particles.position, truth[0].position)
    way = np.linalg.norm(after.particles.position - before.particles.position, axis=1)
    np.testing.assert_allclose(moved, way, atol=1e-12)
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
        assert moved[number] == pytest.approx(np.linalg.norm(place - start[i]))


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
        assert after.idle in (0, IDLE_STEPS + 1)
    assert changed == [True, False]


@pytest.fixture
def ranges(monkeypatch):
    """Insertion range of each particle at every step."""
    seen = []

    def noting(contact, present, looking, scale_field, insertion_range, parameters):
        seen.append(insertion_range)
        return find_insertions(contact, present, looking, scale_field, insertion_range, parameters)

    find_insertions = plane_step.find_insertions
    monkeypatch.setattr(plane_step, "find_insertions", noting)
    return seen


def test_annealing_counts_for_each_particle_since_cells_near_it_were_newly_covered(ranges, scale_field):
    before = state_of(cloud(SHAPE, 120, 0), 30)
    half, after = second_half(scale_field, before)
    truth = []
    for place in half.particles.position:
        row, col = np.minimum((place + 0.5) // 4.0, np.array(after.coverage.found.shape) - 1).astype(int)
        newest = after.coverage.found[max(row - 4, 0) : row + 5, max(col - 4, 0) : col + 5].max()
        idle_steps = half.idle if newest < 0 else half.step_of_scale - newest
        truth.append(PARAMETERS.d_max * PARAMETERS.annealing**idle_steps)
    assert len(np.unique(truth)) > 3
    np.testing.assert_allclose(ranges[-1], truth, rtol=1e-12)


def test_where_all_particles_start_together_annealing_is_that_of_the_paper(ranges):
    """In the middle of a disk, before any of them reaches its edge: d_max times a for each step."""
    state_of(circle((27.4, 30.2), 4.0), 6)
    assert len(ranges) == 6
    for k, left in enumerate(ranges):
        np.testing.assert_allclose(left, PARAMETERS.d_max * PARAMETERS.annealing**k, rtol=1e-12)


@pytest.mark.parametrize(("scale", "limit"), [(0, 8.0), (1, 4.0)])
def test_a_particle_that_has_crept_farther_than_the_range_is_deleted(scale_field, scale, limit):
    """The way is in pixels of the scale."""
    before = replace(state_of(cloud(SHAPE, 60, 1)), scale=scale)
    before.particles.crept[:] = np.linspace(0.0, 2.0 * limit, 60)
    limited = replace(scale_field, area=np.zeros(SHAPE, bool))
    half, moved = move_particles(before, idle(before), limited, replace(PARAMETERS, reach=8.0))
    after = insert_and_delete(half, moved, False, limited, replace(PARAMETERS, reach=8.0))
    free = insert_and_delete(half, moved, False, scale_field, PARAMETERS)
    beyond = half.particles.identity[half.particles.crept > limit]
    assert 20 < len(beyond) < 40
    assert not np.isin(beyond, after.particles.identity).any()
    assert np.isin(beyond, free.particles.identity).sum() > 0.9 * len(beyond)
