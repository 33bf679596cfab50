"""The model as published: each line of algorithm 1 against brute force or a truth that is known, in plane and space."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

import cpm_core as cpm
from cpm_core.cli import main
from cpm_core.formats.sessions.particle_state import state_from_json, state_to_json
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.image.pyramid import to_scale
from cpm_core.model.state import Particles
from cpm_core.published import Published, dynamics
from cpm_core.published.lorentz_force import FIELDS, NORMALIZATIONS, fixed_charges, minima_charges

AXES = pytest.mark.parametrize("axes", [2, 3])
DISK, START = cpm.example("disk"), cpm.circle((32, 32), 8)


def particles_at(places):
    return Particles.at_rest(np.array(places, float))


@AXES
def test_the_field_is_the_sum_of_eq_8(axes):
    e = -np.random.default_rng(0).uniform(0.0, 9.0, (7, 6, 5)[:axes])
    places = np.argwhere(np.ones(e.shape, bool)).astype(float)
    apart = places[:, None] - places[None]
    size = np.linalg.norm(apart, axis=2)
    size[size == 0.0] = np.inf
    truth = (e.ravel()[None, :, None] * apart / size[..., None] ** 3).sum(axis=1)
    np.testing.assert_allclose(FIELDS["exact"](e).reshape(axes, -1).T, truth, atol=1e-11)


@AXES
def test_the_coulomb_force_is_that_of_the_nearest_tenth(axes):
    r = np.random.default_rng(1).uniform(0.0, 30.0, (41, axes))
    truth = np.zeros(r.shape)
    for i, place in enumerate(r):
        away = place - r
        distance = np.linalg.norm(away, axis=1)
        for j in np.argsort(distance)[1:5]:
            truth[i] += away[j] / distance[j] ** 3
    np.testing.assert_allclose(dynamics.coulomb_sums(r), truth, rtol=1e-12)
    np.testing.assert_allclose(dynamics.coulomb_sums(r[:2]), cpm.coulomb_force(r[:2]), rtol=1e-12)


@AXES
def test_the_slope_of_the_acceleration_is_exact_for_a_parabola_and_a_step_is_its_taylor_series(axes):
    dt, at = 0.5, 3.0
    one, two, three = np.arange(1.0, 1.0 + 3 * axes).reshape(3, axes)
    a = [one + two * t + three * t**2 for t in (at, at - dt, at - 2.0 * dt)]
    slope = two + 2.0 * three * at
    r, v = np.ones(axes), np.full(axes, 2.0)
    p = replace(particles_at([r]), velocity=v[None], force=np.array([[a[1], a[2]]]))
    after = dynamics.update(p, a[0][None], 0.0, dt)
    np.testing.assert_allclose(after.position[0], r + dt * v + dt**2 / 2 * a[0] + dt**3 / 6 * slope)
    np.testing.assert_allclose(after.velocity[0], v + dt * a[0] + dt**2 / 2 * slope)


def test_a_free_particle_keeps_its_velocity_and_damping_is_part_of_the_force():
    p = replace(particles_at([(5.0, 5.0)]), velocity=np.array([[1.0, -2.0]]))
    assert dynamics.update(p, np.zeros((1, 2)), 0.0, 0.5).position.tolist() == [[5.5, 4.0]]
    damped = dynamics.update(p, np.zeros((1, 2)), 0.8, 0.5)
    assert damped.force[0, 0].tolist() == [-0.8, 1.6]


def test_eq_23_is_the_alternating_sum_of_all_distances_and_unknown_while_a_particle_is_young():
    distance = np.array([[5.0, 4.0, 3.0, 1.0], [2.0, 2.5, 2.0, 2.0]])
    assert dynamics.convergence(distance) == pytest.approx(abs((-5 + 4 - 3 + 1) + (-2 + 2.5 - 2 + 2)) / 2)
    distance[1, 3] = np.nan
    assert np.isnan(dynamics.convergence(distance))


@AXES
def test_births_are_midpoints_with_mean_velocity_and_acceleration(axes):
    along = np.eye(axes)[0]
    p = particles_at([0.0 * along, 3.0 * along, 3.5 * along, 9.0 * along])
    p = replace(p, velocity=np.arange(4.0)[:, None] * along, force=np.arange(8.0 * axes).reshape(4, 2, axes))
    total = np.arange(4.0 * axes).reshape(4, axes)
    after, force, born, deleted = dynamics.insert_and_delete(p, total, 2.0, 3.0, 4)
    assert (born, deleted) == (1, 1)  # between the first two; the third is too near to the second
    assert after.identity.tolist() == [0, 1, 3, 4]
    assert after.position[3].tolist() == (1.5 * along).tolist()
    assert after.velocity[3].tolist() == (0.5 * along).tolist()
    np.testing.assert_array_equal(after.force[3], 0.5 * (p.force[0] + p.force[1]))
    np.testing.assert_array_equal(force[3], 0.5 * (total[0] + total[1]))
    assert dynamics.insert_and_delete(p, total, 2.0, 0.9, 4)[2] == 0


def test_the_range_of_insertion_falls_geometrically_and_begins_again_at_each_scale():
    method, parameters = Published(DISK), cpm.Parameters(annealing=0.9)
    state = method.start(START)
    for count in range(1, 6):
        state = method.step(state, parameters)
        assert state.annealed == pytest.approx(0.9**count)
    later = state.begin_scale(1, state.particles.position)
    assert (later.annealed, later.scale) == (1.0, 1)


def test_the_start_of_a_scale_is_the_solution_of_the_coarser_one_alone():
    method, parameters = Published(DISK), cpm.Parameters()
    states = [method.start(START)]
    while states[-1].scale == 2:
        states.append(method.step(states[-1], parameters))
    places = to_scale(states[-1].position, 1, DISK.shape)
    np.testing.assert_allclose(states[-1].particles.position, places)
    assert not states[-1].particles.velocity.any()


def test_a_volume_of_equal_planes_moves_particles_as_the_image_does():
    """The same lines: without a third coordinate of the force, the step in space is that in the plane."""
    r = np.random.default_rng(2).uniform(0.0, 20.0, (30, 2))
    flat, deep = r, np.insert(r, 0, 4.0, axis=1)
    ends = [
        dynamics.advance(particles_at(places), 0.1 * places, 1.6, 1.75, 0.8, 0.5, 2.0, 3.0, NORMALIZATIONS["unit"], 30)[
            0
        ]
        for places in (flat, deep * [0.0, 1.0, 1.0])
    ]
    np.testing.assert_allclose(ends[1].position[:, 1:], ends[0].position)
    np.testing.assert_allclose(ends[1].position[:, 0], 0.0)


def test_minima_have_95_percent_of_their_neighborhood_above_them():
    values = np.random.default_rng(3).uniform(0.0, 1.0, (2, 12, 11))
    size = np.pad(np.hypot(*values), 2, mode="edge")
    for row, col in np.ndindex(12, 11):
        around = size[row : row + 5, col : col + 5]
        assert minima_charges(values)[row, col] == -float((around >= around[2, 2]).sum() >= 0.95 * 25)


def test_the_skeleton_of_a_bar_is_along_its_middle_from_both_starts():
    values = np.zeros((40, 90))
    values[14:27, 10:80] = 255.0
    method = Published(values, cpm.Parameters(scales=1), skeleton=True)
    e = -method.edge_map(cpm.Parameters(scales=1))
    rows = np.nonzero(e[:, 30:60])[0]
    inside = rows[(rows > 15) & (rows < 25)]
    assert len(inside)
    assert (np.abs(inside - 20) <= 1).all()
    for seeds in (cpm.gradient_threshold(values), cpm.uniform_grid(values.shape)):
        state = method.start(seeds)
        for _ in range(60):
            state = method.step(state, cpm.Parameters(scales=1))
        assert state.count > 20


def test_what_leaves_the_image_is_removed_and_a_run_without_particles_ends():
    values = np.zeros((16, 16))
    values[:, :3] = 255.0
    method = Published(values, cpm.Parameters(scales=1))
    state = method.start([(8.0, 14.0)])
    state = replace(state, particles=replace(state.particles, velocity=np.array([[0.0, 90.0]])))
    after = method.step(state, cpm.Parameters(scales=1))
    assert (after.count, after.stop_reason) == (0, "all particles left the image")


def test_two_runs_a_state_from_a_file_and_an_iterator_agree_to_the_bit():
    parameters = cpm.Parameters(scales=2)
    method = Published(DISK, parameters)
    state = method.start(START)
    run = cpm.evolve(DISK, START, parameters, method="published")
    for moment in run:
        if moment.step == 25:
            break
        state = method.step(state, parameters)
    read = state_from_json(json.loads(json.dumps(state_to_json(state))), DISK.shape, 2)
    assert (read.step, read.annealed) == (state.step, state.annealed)
    ends = [method.step(one, parameters).position for one in (read, state)]
    assert ends[0].tobytes() == ends[1].tobytes() == method.step(moment.state, parameters).position.tobytes()
    limited = cpm.segment(DISK, START, parameters, max_steps=25, method=Published)
    assert limited.particles.tobytes() == moment.position.tobytes()
    assert limited.provenance.method == "published"


def test_the_command_line_runs_it_and_its_session_says_so(tmp_path: Path, capsys):
    path, kept = tmp_path / "disk.png", tmp_path / "disk.cpm"
    PIL.Image.fromarray(DISK.values.astype(np.uint8)).save(path)
    order = ["run", str(path), "--circle", "32,32,8", "--method", "published", "--max-steps", "20", "--json"]
    assert main([*order, "--save-session", str(kept)]) == 0
    told = json.loads(capsys.readouterr().out)
    expected = cpm.segment(cpm.load_image(path), START, max_steps=20, method="published")
    assert told["particles"] == len(expected.particles)
    assert told["provenance"]["method"] == "published"
    assert load_session(kept).mode == "published"


def test_a_method_or_preset_that_is_not_there_is_named():
    with pytest.raises(ValueError, match='method is "crust" but must be a class, or one of cpm, published'):
        cpm.segment(DISK, START, method="crust")
    with pytest.raises(ValueError, match='parameters is "sharp" but must be Parameters, or one of shape, '):
        cpm.segment(DISK, START, "sharp")
    assert cpm.evolve(DISK, START, "automatic").parameters == cpm.PRESETS["automatic"]


def test_charges_are_minus_the_size_of_the_gradient():
    ramp = np.tile(np.arange(40.0) * 3.0, (30, 1))
    np.testing.assert_allclose(fixed_charges(ramp, 1.0)[:, 8:-8], -3.0, rtol=1e-9)
