"""The laws of a run."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from cpm_core import Engine, Image, Parameters, circle
from cpm_core.field.interpolation import interpolate_field
from cpm_core.model.equations import STILL_DISTANCE
from cpm_core.numerics import parallel

from ..model.moving import repulsion
from ..scenes import disk, ring

SCENE = disk((64, 60), (31.4, 29.7), 17.0)
START = circle((31.0, 30.0), 8.0)
ARRAYS = ("position", "velocity", "force", "distance", "identity", "crept")


@pytest.fixture(scope="module")
def engine():
    return Engine(SCENE.values, Parameters())


def run(engine, seeds, parameters, most=5000):
    """All states of a run."""
    states = [engine.start(seeds)]
    while not states[-1].stop_reason and len(states) <= most:
        states.append(engine.step(states[-1], parameters))
    return states


@pytest.fixture(scope="module")
def states(engine):
    return run(engine, START, Parameters())


def frozen(state):
    """Bytes of all values of a state."""
    apart = ("particles", "coverage", "far")
    figures = [repr(getattr(state, f.name)) for f in dataclasses.fields(state) if f.name not in apart]
    arrays = [getattr(state.particles, name).tobytes() for name in ARRAYS]
    tuples = [np.asarray(part).tobytes() for whole in (state.coverage[:2], state.mesh or ()) for part in whole]
    return [*figures, *tuples, state.start.tobytes(), *arrays]


def in_order(particles):
    """Particles in the order of their identities: a step may change their order."""
    return particles.select(np.argsort(particles.identity))


def common(one, other):
    """Those particles that two states share, of both, in the same order."""
    both = np.intersect1d(one.particles.identity, other.particles.identity)
    return (in_order(s.particles.keep(np.isin(s.particles.identity, both))) for s in (one, other))


def test_same_input_same_bits(engine, states):
    again = run(Engine(SCENE.values.copy(), Parameters()), START.copy(), Parameters())
    assert len(again) == len(states)
    for one, other in zip(states, again, strict=True):
        assert frozen(one) == frozen(other)
    assert [frozen(s) for s in run(engine, START, Parameters(), 60)] == [frozen(s) for s in states[:61]]


def test_same_bits_on_any_number_of_cores(monkeypatch):
    """A large scene, since a few particles use only one core."""
    scene = ring((260, 250), (129.4, 125.7), 60.0, 110.0)
    parameters = Parameters(scales=1)
    engine = Engine(scene.values, parameters)
    seeds = np.concatenate([circle((129.0, 126.0), radius, 2.0) for radius in range(62, 110, 4)])
    assert len(seeds) > 3 * 600
    runs = []
    for cores in (1, 2, 3):
        monkeypatch.setattr(parallel, "count_cores", lambda cores=cores: cores)
        runs.append([frozen(state) for state in run(engine, seeds, parameters, 25)])
    assert runs[0] == runs[1] == runs[2]


def test_a_run_can_be_continued_from_any_of_its_states(engine, states):
    middle = len(states) // 2
    assert frozen(engine.step(states[middle], Parameters())) == frozen(states[middle + 1])


def test_a_final_state_is_returned_unchanged(engine, states):
    assert engine.step(states[-1], Parameters()) is states[-1]
    assert engine.step(states[5].stop("enough"), Parameters()).step == states[5].step


def test_steps_are_counted_and_scales_go_from_coarse_to_fine(states):
    assert [state.step for state in states] == list(range(len(states)))
    scales = [state.scale for state in states]
    assert scales == sorted(scales, reverse=True)
    assert set(scales) == {2, 1, 0}
    assert scales[0] == 2


def test_no_particle_is_outside_the_image_after_a_step(engine):
    """Including those that start at the border and are pushed out by others."""
    corner = np.random.default_rng(0).uniform(0.0, 6.0, (60, 2))
    seeds = np.concatenate([corner, np.array([63.0, 59.0]) - corner, START])
    deleted = 0
    for state in run(engine, seeds, Parameters(), 120)[1:]:
        high = np.array([64, 60]) - 0.5
        size = 2.0**state.scale  # the outermost pixels of a coarser scale reach a little further
        assert np.all(state.position >= -0.5 - size)
        assert np.all(state.position <= high + size)
        shape = np.array(engine.edge_map(Parameters(), state.scale).shape)
        assert np.all((state.particles.position >= -0.5) & (state.particles.position <= shape - 0.5))
        deleted += state.deleted
    assert deleted > 0


def test_a_run_without_particles_ends_with_a_reason(engine):
    state = engine.start(START)
    empty = state.particles.keep(np.zeros(state.count, bool))
    ended = engine.step(dataclasses.replace(state, particles=empty, start=empty.position, scale=0), Parameters())
    assert ended.count == 0
    assert "left the image" in ended.stop_reason
    assert not ended.converged
    assert engine.result(ended, Parameters()).contours == ()


def test_identities_are_unique_and_never_reused(states):
    last_seen, dead = set(), set()
    for state in states:
        identity = state.particles.identity.tolist()
        now = set(identity)
        assert len(now) == len(identity)
        assert not now & dead
        assert max(now) < state.next_identity
        dead |= last_seen - now
        last_seen = now


def test_no_two_particles_are_too_close(states):
    """At the end, and after every step that has deleted particles."""
    compared = 0
    for before, state in pairwise(states):
        if state.scale == before.scale and (state.deleted or state.stop_reason):
            points = state.particles.position
            apart = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
            np.fill_diagonal(apart, np.inf)
            assert apart.min() >= 0.5 * Parameters().d_min
            compared += 1
    assert compared > 10


def test_sleeping_particles_have_negligible_forces(states):
    """A particle that a step skips would hardly have moved: less than the limit for being at rest."""
    slept = 0
    for before, state in pairwise(states):
        if state.scale == before.scale:
            one, other = common(before, state)
            asleep = (other.position == one.position).all(axis=1) & ~np.isnan(one.distance[:, -1])
            force = np.hypot(*other.force[asleep, 0].T)
            assert np.all(0.5 * Parameters().time_step ** 2 * force < STILL_DISTANCE)
            slept += int(asleep.sum())
    assert slept > 500


def force_in_free_flight(engine, state, parameters):
    """Force of eq. (12) and its slope by eq. (15), for particles at rest and far from any edge."""
    position = state.particles.position
    lorentz = interpolate_field(engine.force_field(parameters, state.scale), position)
    force = parameters.w1 * repulsion(position, parameters)
    force += parameters.w2 * lorentz
    slope = 3.0 * force / (2.0 * parameters.time_step)
    return force, slope


@pytest.mark.parametrize("beta", [0.0, 0.8])
def test_the_first_step_is_eq_12_to_15(beta):
    parameters = Parameters(scales=1, beta=beta, time_step=0.4)
    engine = Engine(SCENE.values, parameters)
    seeds = circle((31.0, 30.0), 8.0, 5.0)
    before = engine.start(seeds)
    after = engine.step(before, parameters)
    force, slope = force_in_free_flight(engine, before, parameters)
    # v' = F + t F' - beta v from rest, by fine steps of the trapezoidal rule
    n = 4000
    h = 0.4 / n
    v, r = np.zeros_like(force), seeds.copy()
    for k in range(n):
        middle = force + (k + 0.5) * h * slope
        new = (v * (1.0 - 0.5 * h * beta) + h * middle) / (1.0 + 0.5 * h * beta)
        v, r = new, r + 0.5 * h * (v + new)
    np.testing.assert_allclose(after.particles.velocity, v, atol=1e-5)
    np.testing.assert_allclose(after.particles.position, r, atol=1e-5)


def test_another_beta_acts_at_the_next_step(engine, states):
    state = states[3]
    plain, heavy = engine.step(state, Parameters()), engine.step(state, Parameters(beta=3.0))
    same = [s.keep(np.isin(s.identity, state.particles.identity)) for s in common(plain, heavy)]
    assert len(same[0]) > 0.9 * state.count
    speed, slowed = (np.linalg.norm(particles.velocity, axis=1) for particles in same)
    assert slowed.mean() < 0.8 * speed.mean()
    np.testing.assert_array_equal(same[0].force, same[1].force)


def test_particles_at_rest_respond_to_other_parameters(states):
    """Twice the spacing thins them out, a large smoothing moves them; a least length does not affect them."""
    engine, resting = Engine(SCENE.values, Parameters()), states[-2]
    assert not resting.stop_reason
    assert resting.moving <= 0.002 * resting.count

    def after(parameters, steps):
        state = resting
        for _ in range(steps):
            state = engine.step(state, parameters)
        return state

    assert after(Parameters(d_min=4.0), 40).count < 0.75 * resting.count
    assert after(Parameters(smoothing=4.0), 3).moving > 0.2 * resting.count
    kept = after(Parameters(min_length=5.0, min_strength=1.0), 1)
    np.testing.assert_array_equal(kept.position, after(Parameters(), 1).position)


@pytest.mark.parametrize("seeds", [np.array([(1.0, np.nan)]), np.array([(np.inf, 1.0)])], ids=str)
def test_positions_that_are_not_finite_cannot_start(engine, seeds):
    with pytest.raises(ValueError, match=r"1 coordinates of the starting particles are not finite"):
        engine.start(seeds)


def test_a_constant_image_is_refused():
    with pytest.raises(ValueError, match=r"image is constant .7 everywhere. and has no edges"):
        Engine(np.full((32, 32), 7.0), Parameters())


def test_a_result_has_the_metadata_of_the_image():
    image = Image(SCENE.values, spacing=(0.5, 0.25), unit="mm", source="a disk")
    engine = Engine(image, Parameters(scales=1))
    result = engine.result(engine.start(START), Parameters(scales=1))
    assert (result.spacing, result.unit, result.source) == ((0.5, 0.25), "mm", "a disk")


def test_contours_of_a_coarser_scale_are_in_px_and_gray_levels_of_the_image(engine, states):
    """A disk keeps its outline, and its edge a strength of the same order: not four times as much."""
    found = {}
    for scale in (2, 1, 0):
        last = [state for state in states if state.scale == scale][-1]
        found[scale] = engine.result(last, Parameters()).contours[0]
    for scale, contour in found.items():
        assert SCENE.distance(contour.points).max() < 0.1 + 0.7 * scale
        assert contour.area == pytest.approx(np.pi * 17.0**2, rel=0.02 + 0.05 * scale)
    assert found[2].strength < found[1].strength < found[0].strength


def test_scale_and_offset_of_the_gray_levels_change_only_the_strength():
    scene = ring((48, 52), (23.6, 26.2), 8.0, 16.0).values
    parameters = Parameters(scales=1)
    results = []
    for image in (scene, 4.0 * scene - 128.0):
        engine = Engine(image, parameters)
        results.append(engine.result(run(engine, circle((23.0, 26.0), 12.0), parameters)[-1], parameters))
    one, other = results
    assert len(one.contours) == len(other.contours) == 2
    for a, b in zip(one.contours, other.contours, strict=True):
        assert b.strength == pytest.approx(4.0 * a.strength, rel=0.02)
        assert b.area == pytest.approx(a.area, rel=0.01)
