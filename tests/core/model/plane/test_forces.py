"""Forces and energies of particles: what a step applies, and sums over all pairs."""

from itertools import pairwise

import numpy as np
import pytest

from cpm_core import Engine, Parameters, PlacedCharge, circle
from cpm_core.field.convolution import convolved_potential
from cpm_core.field.interpolation import interpolate_field
from cpm_core.model.equations import damping_coefficient, repulsion_left
from cpm_core.model.plane.step import idle_steps_of

from ...scenes import antialiased, disk
from ..moving import repulsion

PARAMETERS = Parameters(scales=2)
SCENE = disk((64, 60), (31.4, 29.7), 17.0)
CHARGES = (PlacedCharge((20.0, 15.0), 0.7), PlacedCharge((50.0, 40.0), -0.4))
NAMES = ("coulomb", "lorentz", "placed", "friction", "damping", "total")
PAIRS = 2e-4
"""Error that single precision leaves in the sum over the pairs."""


@pytest.fixture(scope="module")
def engine():
    return Engine(SCENE.values, PARAMETERS)


@pytest.fixture(scope="module")
def states(engine):
    states = [engine.start(circle((31.0, 30.0), 8.0))]
    while not states[-1].stop_reason:
        states.append(engine.step(states[-1], PARAMETERS, CHARGES))
    return states[:-1]


def after(engine, state, **changes):
    """Particles after a step, in the order of those before it that are still there, and the indices of those."""
    moved = engine.step(state, PARAMETERS, CHARGES).particles
    _, old, new = np.intersect1d(state.particles.identity, moved.identity, return_indices=True)
    return moved.select(new), old


def scales_of(states):
    """Some states of each scale, those aside that end one."""
    return [s for s, t in pairwise(states[2:]) if s.scale == t.scale][::7]


def test_the_forces_are_those_that_a_step_applies(engine, states):
    held = 0
    for state in scales_of(states):
        forces = engine.forces(state, PARAMETERS, CHARGES)
        moved, old = after(engine, state)
        moving = np.any(moved.velocity != 0.0, axis=1)
        undamped = (forces.total - forces.damping)[old]
        np.testing.assert_allclose(undamped[moving], moved.force[moving, 0], atol=1e-12)
        assert not forces.total[old][~moving].any()
        held += int((np.abs(forces.friction).max(axis=1) > 1e-3).sum())
    assert held > 100


def test_the_total_is_the_change_of_the_velocity_in_a_short_step(engine):
    """Without friction, and up to the share of the slope of the force."""
    parameters = Parameters(scales=2, time_step=0.01)
    state = engine.start(circle((31.0, 30.0), 8.0))
    for _ in range(5):
        state = engine.step(state, parameters)
    forces = engine.forces(state, parameters)
    assert np.abs(forces.friction).max() < 1e-6
    moved = engine.step(state, parameters).particles
    change = (moved.velocity - state.particles.velocity) / parameters.time_step
    np.testing.assert_allclose(change, forces.total, atol=0.05)
    assert np.linalg.norm(forces.total, axis=1).min() > 0.5


def test_the_forces_are_those_of_eq_12(engine, states):
    for state in scales_of(states):
        forces = engine.forces(state, PARAMETERS, CHARGES)
        position, velocity = state.particles.position, state.particles.velocity
        scale_field = engine.scale_field(PARAMETERS, state.scale)
        idle = idle_steps_of(state, engine._field_with(scale_field, state.scale, state.charges), PARAMETERS)
        left = np.array([repulsion_left(int(steps)) for steps in idle])[:, None]
        beta = np.array([damping_coefficient(PARAMETERS.beta, int(steps)) for steps in idle])[:, None]
        both = engine.force_field(PARAMETERS, state.scale, CHARGES)
        alone = engine.force_field(PARAMETERS, state.scale)
        w1, w2 = PARAMETERS.w1, PARAMETERS.w2
        np.testing.assert_allclose(forces.coulomb, w1 * left * repulsion(position, PARAMETERS), atol=PAIRS)
        np.testing.assert_allclose(forces.lorentz, w2 * interpolate_field(alone, position), atol=1e-5)
        np.testing.assert_allclose(forces.placed, w2 * interpolate_field(both - alone, position), atol=1e-5)
        at_rest = ~forces.total.any(axis=1)
        np.testing.assert_allclose(forces.damping[~at_rest], (-beta * velocity)[~at_rest], rtol=1e-12)
        parts = sum(getattr(forces, name) for name in NAMES[:-1])
        np.testing.assert_array_equal(forces.total, parts)


@pytest.mark.parametrize("index", [[3], [7, 2, 7], np.arange(10)[::-1], 5])
def test_the_forces_on_some_are_theirs_among_all(engine, states, index):
    for state in scales_of(states):
        some, all_ = (engine.forces(state, PARAMETERS, CHARGES, which) for which in (index, None))
        for name in NAMES:
            want = getattr(all_, name)[np.atleast_1d(index)]
            np.testing.assert_allclose(getattr(some, name), want, atol=1e-12)


def test_the_potential_is_the_sum_over_all_other_pixels():
    f = np.random.default_rng(3).uniform(0.0, 9.0, (13, 18))
    places = np.argwhere(f > 0.0)
    away = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    away[away == 0.0] = np.inf
    want = -(f.ravel() / away).sum(axis=1).reshape(f.shape)
    np.testing.assert_allclose(convolved_potential(f), want, rtol=3e-6)


def test_placed_charges_add_to_the_potential_by_the_mean_slope_of_the_fixed_ones(engine):
    fixed = engine.potential(PARAMETERS)
    scale_field = engine.scale_field(PARAMETERS)
    np.testing.assert_array_equal(fixed, convolved_potential(scale_field.fixed_charges))
    mean = np.hypot(*np.gradient(fixed)).mean()
    both = engine.potential(PARAMETERS, CHARGES) - fixed
    slope = -np.stack(np.gradient(both)) / mean
    force = engine.force_field(PARAMETERS, 0, CHARGES) - engine.force_field(PARAMETERS)
    np.testing.assert_allclose(slope[:, 1:-1, 1:-1], force[:, 1:-1, 1:-1], atol=0.02)
    assert engine.potential(PARAMETERS) is not engine.potential(PARAMETERS)


def test_the_energies_are_the_sums_over_particles_and_near_pairs(engine, states):
    for state in scales_of(states):
        position, velocity = state.particles.position, state.particles.velocity
        got = engine.energies(state, PARAMETERS, CHARGES)
        size = 2.0**state.scale
        assert got.kinetic == pytest.approx(0.5 * ((size * velocity) ** 2).sum(), rel=1e-12)
        scale_field = engine.scale_field(PARAMETERS, state.scale)
        fixed = interpolate_field(scale_field.potential[None], position).sum() / scale_field.slope
        away = np.hypot(*(position[:, None] - position).transpose(2, 0, 1))[np.triu_indices(len(position), 1)]
        reach = PARAMETERS.d_min + PARAMETERS.d_max
        near = np.maximum(away[away < reach], 0.1)
        pairs = 0.5 * PARAMETERS.w1 * PARAMETERS.d_min**2 * (1.0 / near - 1.0 / reach).sum()
        without = engine.energies(state, PARAMETERS)
        assert without.potential == pytest.approx(size**2 * (PARAMETERS.w2 * fixed + pairs), rel=1e-9)
        placed = PARAMETERS.w2 * size * _placed(state.position)
        assert got.potential - without.potential == pytest.approx(placed, rel=1e-6)


def _placed(points):
    """Energy of charges at places of the image, by the potential that a charge of one has."""
    total = 0.0
    for charge in CHARGES:
        d = np.hypot(*(points - charge.position).T) / 16.0
        near = d < 4.0
        unit = 9 * (63 / 64) ** 2 / 64 / 2**0.25 + (63 / 64) ** 3 / 2**1.25
        total -= (charge.strength * 16.0 / unit * (1 - d[near] ** 3 / 64) ** 3 / (1 + d[near] ** 4) ** 0.25).sum()
    return total


def test_a_particle_that_falls_into_a_charge_keeps_its_energy_but_for_the_damping():
    """Far from all edges, where the force is the slope of the potential of the charge."""
    values = antialiased((160, 160), lambda row, col: np.hypot(row - 79.5, col - 79.5) < 78.0)
    parameters = Parameters(scales=1, beta=0.0, time_step=0.05)
    engine = Engine(values, parameters)
    charge = [PlacedCharge((79.5, 79.5), 3.0)]
    state = engine.start(np.array([(79.5, 99.5)]))
    before = engine.energies(state, parameters, charge)
    without = engine.energies(state, parameters).potential
    work = 0.0
    for _ in range(25):
        last, state = state, engine.step(state, parameters, charge)
        forces = [engine.forces(s, parameters, charge).lorentz for s in (last, state)]
        work += float((0.5 * (forces[0] + forces[1]) * (state.position - last.position)).sum())
    now = engine.energies(state, parameters, charge)
    fallen = (before.potential - without) - (now.potential - engine.energies(state, parameters).potential)
    assert now.kinetic > 3.0
    assert now.kinetic == pytest.approx(fallen + work, rel=0.02)
