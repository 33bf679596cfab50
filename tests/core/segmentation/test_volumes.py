"""Runs in volumes: what they find, and the laws that hold in the plane as well."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.field.volume_field import build_volume_field
from cpm_core.parameters import PLANE_PARAMETERS

VOLUME = cpm.PRESETS["volume"]
CENTER = (15.2, 16.1, 14.7)


def ball(spacing=(1.0, 1.0, 1.0), radius=9.0, side=31.0):
    """A ball sampled with voxels of these sides, in a cube of this side."""
    axes = [np.arange(round(side / s) + 1) * s - c for s, c in zip(spacing, CENTER, strict=True)]
    away = np.sqrt(sum(a**2 for a in np.meshgrid(*axes, indexing="ij")))
    return 20.0 + 200.0 * np.clip(0.5 - (away - radius) / max(spacing), 0.0, 1.0)


def off(result, spacing=(1.0, 1.0, 1.0), radius=9.0):
    """Distance of the particles from the surface of the ball."""
    return np.linalg.norm(result.particles * spacing - CENTER, axis=1) - radius


@cache
def engine():
    return cpm.Engine(ball(), VOLUME)


@cache
def states():
    found = [engine().start(cpm.sphere(CENTER, 4.0, 60))]
    while not found[-1].stop_reason:
        found.append(engine().step(found[-1], VOLUME))
    return found


def frozen(state):
    return [array.tobytes() for array in state.list_arrays()]


def test_a_ball_is_covered_from_inside_and_the_particles_lie_on_it():
    result = engine().result(states()[-1], VOLUME)
    assert result.converged
    assert np.abs(off(result)).max() < 0.3
    sphere = CENTER + 9.0 * (cpm.sphere((0.0, 0.0, 0.0), 1.0, 2000))
    assert scipy.spatial.KDTree(result.particles).query(sphere)[0].max() < VOLUME.d_min
    assert result.surface is not None
    assert len(result.surface.vertices) - len(result.surface.faces) // 2 == 2


def test_a_step_depends_on_the_state_alone_and_changes_nothing():
    for before, after in ((states()[1], states()[2]), (states()[-2], states()[-1])):
        held = frozen(before)
        assert frozen(engine().step(before, VOLUME)) == frozen(after)
        assert frozen(before) == held


def test_a_particle_on_a_surface_sleeps_when_nothing_new_has_been_found_near_it_for_long():
    slept = 0
    for before, after in pairwise(states()[:-1]):
        particles = before.particles
        asleep = particles.on_surface & (before.step_of_scale - particles.reactivated_at >= 12)
        place = dict(zip(after.particles.identity.tolist(), after.particles.position, strict=True))
        for i in np.flatnonzero(asleep):
            kept = place.get(int(before.particles.identity[i]))
            assert kept is None or (kept == before.particles.position[i]).all()
            slept += kept is not None
    assert slept > 100


@settings(max_examples=5, deadline=None)
@given(st.permutations([1.0, 1.3, 2.4]) | st.tuples(*[st.sampled_from([1.0, 1.25, 1.6, 2.0])] * 3))
def test_voxels_of_unequal_sides_show_the_same_object_as_cubes(spacing):
    spacing = tuple(side / min(spacing) for side in spacing)
    image = cpm.Image(ball(spacing), spacing=tuple(0.3 * s for s in spacing), unit="mm")
    result = cpm.segment(image, cpm.sphere(CENTER, 4.0, 60) / spacing, VOLUME)
    cubes = engine().result(states()[-1], VOLUME)
    assert result.converged
    assert np.quantile(np.abs(off(result, spacing)), 0.98) < 0.3 * max(spacing)
    assert np.abs(off(result, spacing)).max() < 0.5 * max(spacing)
    assert abs(off(result, spacing).mean() - off(cubes).mean()) < 0.15
    assert 0.8 < len(result.particles) / len(cubes.particles) < 1.25


@pytest.mark.parametrize("name", PLANE_PARAMETERS)
def test_parameters_for_images_only_are_refused_in_a_volume(name):
    value = "vessels" if name == "edges" else 0.1
    with pytest.raises(ValueError, match=f"^{name} is .* but has no meaning in a volume: leave it at .*\\.$"):
        cpm.Engine(ball(), replace(VOLUME, **{name: value}))


def test_annealing_shrinks_the_insertion_range_at_every_step_and_ends_the_insertion():
    counts = []
    for annealing in (0.0, 0.8, 1.0):
        law = replace(VOLUME, annealing=annealing)
        state = engine().start(cpm.sphere(CENTER, 4.0, 60))
        while not state.stop_reason:
            before, state = state, engine().step(state, law)
            if state.reseedings == before.reseedings:
                assert state.annealed == pytest.approx(before.annealed * annealing)
        counts.append(state.count)
    assert 1.15 * counts[0] < counts[1] <= counts[2] + 5
    state = engine().step(replace(states()[-1], stop_reason=""), replace(VOLUME, annealing=0.5))
    assert state.annealed == 0.5


def test_noise_decides_on_the_smoothing_and_the_floor():
    clean = build_volume_field(ball(), (1.0, 1.0, 1.0), "auto", 0.1)
    noise = np.random.default_rng(0).normal(0.0, 40.0, ball().shape)
    noisy = build_volume_field(ball() + noise, (1.0, 1.0, 1.0), "auto", 0.1)
    assert (clean.smoothing, clean.noisy, noisy.noisy) == (0.7, False, True)
    assert noisy.smoothing > clean.smoothing
    flat = build_volume_field(noise, (1.0, 1.0, 1.0), 1.0, 0.0)
    assert (flat.edge_map > flat.floor).mean() < 0.01 or flat.floor == pytest.approx(0.35 * flat.strongest)


def test_the_field_of_a_volume_pulls_to_the_edge_and_its_potential_is_lowest_there():
    force, potential = engine().force_field(VOLUME), engine().potential(VOLUME)
    assert force.shape == (3, *ball().shape)
    assert np.linalg.norm(force, axis=0).max() <= 1.0 + 1e-6
    grid = np.moveaxis(np.indices(ball().shape), 0, -1) - CENTER
    away = np.linalg.norm(grid, axis=-1)
    outward = np.einsum("i...,...i->...", force, grid) / np.maximum(away, 1e-9)
    assert (outward[(away > 3.0) & (away < 8.0)] > 0.0).mean() > 0.99
    assert (outward[(away > 10.0) & (away < 14.0)] < 0.0).mean() > 0.99
    assert abs(away.ravel()[np.argmin(potential)] - 9.0) < 1.5


def test_no_particle_is_launched_or_pulled_out_of_the_volume():
    for seed in range(6):
        volume = np.where(np.random.default_rng(seed).normal(size=(8, 8, 8)) > 0, 200.0, 0.0)
        run = cpm.Engine(volume, replace(VOLUME, smoothing=1.0))
        state = run.start(cpm.sphere((4.0, 4.0, 4.0), 4.0, 60))
        while not state.stop_reason:
            state = run.step(state, replace(VOLUME, smoothing=1.0))
            assert ((state.particles.position >= 0.0) & (state.particles.position <= 7.0)).all()


def test_a_run_that_is_stopped_again_and_again_goes_on_until_it_comes_to_rest():
    state, ends = engine().start(cpm.sphere(CENTER, 4.0, 60)), 0
    while not state.converged:
        state = engine().step(state.resume() if state.stop_reason else state, VOLUME)
        if state.step % 10 == 0 and not state.converged:
            state, ends = state.stop("stopped by hand"), ends + 1
    assert 1 < ends < 20
    assert np.abs(off(engine().result(state, VOLUME))).max() < 0.3
