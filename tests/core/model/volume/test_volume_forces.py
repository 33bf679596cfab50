"""Forces and energies of particles in volumes: what a step applies, and sums over all pairs by brute force."""

from functools import cache

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.field.convolution import convolved_potential
from cpm_core.field.interpolation import interpolate_field
from cpm_core.model.equations import damping_coefficient, repulsion_left
from cpm_core.model.volume import step as time_step
from cpm_core.model.volume.births import VolumeBirths

VOLUME = cpm.PRESETS["volume"]
SPACING = (1.0, 1.0, 1.5)
CENTER = np.array([15.3, 14.2, 16.1]) / SPACING
CHARGES = (cpm.PlacedCharge((8.0, 15.0, 12.0), 0.4), cpm.PlacedCharge((25.0, 20.0, 5.0), -0.6))


@cache
def engine():
    grid = np.moveaxis(np.indices((31, 30, 21)), 0, -1)
    away = np.linalg.norm((grid - CENTER) * SPACING, axis=-1)
    return cpm.Engine(cpm.Image(200.0 * np.clip(0.5 - (away - 9.0) / 1.5, 0.0, 1.0), spacing=SPACING), VOLUME)


@cache
def states(charges=CHARGES):
    found = [engine().start(cpm.sphere(tuple(CENTER), 4.0, 60, voxel_size=SPACING))]
    while not found[-1].stop_reason:
        found.append(engine().step(found[-1], VOLUME, charges))
    return found


def repulsion(state, left):
    """The Coulomb force of every particle over all pairs, one by one."""
    place, particles = state.particles.position, state.particles
    total = np.zeros_like(place)
    for i in range(len(place)):
        away = place[i] - place
        distance = np.linalg.norm(away, axis=1)
        other_sheet = particles.on_surface[i] & particles.on_surface & (particles.normal @ particles.normal[i] <= 0.0)
        near = (distance < 2.2 * VOLUME.d_min) & (np.arange(len(place)) != i) & ~other_sheet
        if near.any():
            sum_ = (away[near] / np.maximum(distance[near, None], 1e-2) ** 4).sum(axis=0)
            nearest = np.sort(np.append(distance[near], 4.0 * VOLUME.d_min))[:2]
            spacing = max(nearest.mean(), 1e-2)
            scale = 0.5 * spacing**3 * min(1.0, spacing / VOLUME.d_min)
            total[i] = left[i] * scale * sum_ / max(1.0, scale * np.linalg.norm(sum_))
    return VOLUME.w1 * total


def test_the_forces_are_those_of_eq_12():
    for state in states()[3:-2:6]:
        forces = engine().forces(state, VOLUME, CHARGES)
        particles, position = state.particles, state.particles.position
        idle = np.maximum(state.step_of_scale - particles.reactivated_at, 0)
        coulomb = repulsion(state, [repulsion_left(int(steps)) for steps in idle])
        on_edge = ~np.isclose(forces.coulomb, coulomb, atol=1e-6).all(axis=1)
        field = engine().scale_field(VOLUME)
        slope = np.stack(
            [
                np.array(
                    [np.asarray(interpolate_field(field.smoothed[None], (position + s) / SPACING)) for s in (d, -d)]
                )[..., 0]
                for d in np.eye(3)
            ]
        )
        normal = (slope[:, 0] - slope[:, 1]).T
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        along = coulomb - np.einsum("ni,ni->n", coulomb, normal)[:, None] * normal
        np.testing.assert_allclose(forces.coulomb[on_edge], along[on_edge], atol=1e-4)
        beta = np.array([damping_coefficient(VOLUME.beta, int(steps)) for steps in idle])[:, None]
        awake = forces.total.any(axis=1)
        np.testing.assert_allclose(forces.damping[awake], (-beta * state.particles.velocity)[awake])
        assert np.linalg.norm(forces.lorentz, axis=1).max() <= VOLUME.w2 * (1.0 + 1e-6)
        np.testing.assert_allclose(
            forces.total, forces.coulomb + forces.lorentz + forces.placed + forces.friction + forces.damping
        )
        both = engine().force_field(VOLUME, charges=CHARGES) - engine().force_field(VOLUME)
        placed = VOLUME.w2 * interpolate_field(both, position / SPACING)
        np.testing.assert_allclose(forces.placed, placed, atol=0.01)


def test_the_forces_are_those_that_a_step_applies():
    held = 0
    for state in states()[2:-1:4]:
        forces = engine().forces(state, VOLUME, CHARGES)
        after = engine().step(state, VOLUME, CHARGES)
        if after.stop_reason:  # at the end particles are put on the ridge
            continue
        moved = after.particles
        _, old, new = np.intersect1d(state.particles.identity, moved.identity, return_indices=True)
        asleep = (moved.position[new] == state.particles.position[old]).all(axis=1)
        undamped = (forces.total - forces.damping)[old]
        np.testing.assert_allclose(undamped[~asleep], moved.force[new][~asleep, 0], atol=1e-9)
        assert not forces.total[old][asleep & (forces.damping[old] == 0.0).all(axis=1)].any()
        held += int((np.abs(forces.friction).max(axis=1) > 1e-3).sum())
    assert held > 50


def test_the_forces_on_some_are_theirs_among_all():
    state = states()[9]
    every = engine().forces(state, VOLUME, CHARGES)
    for index in ([3], [7, 2, 7], 5):
        some = engine().forces(state, VOLUME, CHARGES, index)
        np.testing.assert_allclose(some.total, every.total[np.atleast_1d(index)])


def test_the_energy_is_the_sum_over_all_pairs_and_charges():
    for state in states()[2::7]:
        energies = engine().energies(state, VOLUME, CHARGES)
        place, particles = state.particles.position, state.particles
        reach = 2.2 * VOLUME.d_min
        distance = np.maximum(np.linalg.norm(place[:, None] - place, axis=2), 1e-2)
        sheets = (particles.on_surface[:, None] & particles.on_surface) & (particles.normal @ particles.normal.T <= 0.0)
        acts = np.tril((distance < reach) & ~sheets, -1)
        pairs = 0.5 * (distance[acts] ** -2 - reach**-2).sum()
        field = engine().scale_field(VOLUME)
        fixed = interpolate_field(engine().potential(VOLUME, CHARGES)[None], place / SPACING).sum() / field.slope
        wanted = 0.5 * VOLUME.w1 * VOLUME.d_min**3 * pairs + VOLUME.w2 * fixed
        assert energies.potential == pytest.approx(wanted, rel=2e-3)
        assert energies.kinetic == pytest.approx(0.5 * (state.particles.velocity**2).sum())


@pytest.mark.parametrize("exponent", [None, 1.0, 2.0, 3.5])
def test_the_potential_has_the_field_as_its_slope_between_edges(exponent):
    """Without a normalization: the potential and the field of the same charges."""
    f = np.random.default_rng(3).uniform(0.0, 9.0, (7, 8, 9))
    places = np.argwhere(f >= 0.0)
    away = np.linalg.norm(places[:, None] - places, axis=-1)
    away[away == 0.0] = np.inf
    if exponent != 1.0:
        power = 2.0 if exponent is None else exponent - 1.0
        wanted = -(f.ravel() / power / away**power).sum(axis=1).reshape(f.shape)
        np.testing.assert_allclose(convolved_potential(f, exponent=exponent), wanted, rtol=3e-6)
    single = np.zeros((21, 21, 21))
    single[10, 10, 10] = 1.0
    field = cpm.electric_field(single, exponent=exponent)
    potential = convolved_potential(single, exponent=exponent)
    assert potential.max() <= 1e-6
    slope = -np.stack(np.gradient(potential))
    far = np.linalg.norm(np.indices(single.shape) - 10.0, axis=0) > 5.0
    far[[0, -1]] = far[:, [0, -1]] = far[:, :, [0, -1]] = False
    np.testing.assert_allclose(slope[:, far], field[:, far], atol=0.1 * np.abs(field[:, far]).max())


def test_the_energy_of_particles_that_stay_the_same_falls_until_they_settle(monkeypatch):
    """On the ridge of a curved edge the potential is a little higher than beside it, as the module tells."""
    nothing = VolumeBirths(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    monkeypatch.setattr(time_step, "find_surface_insertions", lambda *_: nothing)
    state = engine().start(cpm.sphere(tuple(CENTER), 4.0, 20, voxel_size=SPACING))
    energies, seated = [], []
    while state.step < 70:
        state = time_step.step_particles(state, engine().scale_field(VOLUME), VOLUME)
        found = engine().energies(state, VOLUME)
        energies.append((found.kinetic + found.potential) / state.count)
        seated.append(state.particles.on_surface.mean())
    on_the_way = np.flatnonzero(np.array(seated) > 0.0)[0]
    assert on_the_way > 5
    assert (np.diff(energies[:on_the_way]) < 1e-9).all()
    fallen = energies[0] - min(energies)
    assert seated[-1] == 1.0
    assert energies[-1] - min(energies) < 0.15 * fallen
    assert energies[-1] == energies[-2]
