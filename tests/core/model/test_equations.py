"""The motion of the particles, against analytic solutions of the equation of motion."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from cpm_core.model import equations
from cpm_core.model.equations import (
    coulomb_scale,
    creeping_range,
    damped_series,
    damping_coefficient,
    is_stuck,
    repulsion_left,
)
from cpm_core.parameters import PRESETS, UNLIMITED_REACH, Parameters


class Moving:
    """Particles, of which every coordinate moves by itself, with the force `history`: the last force and the one
    before."""

    def __init__(self, position, velocity=None, history=None):
        self.position = np.asarray(position, dtype=float)
        self.velocity = np.zeros_like(self.position) if velocity is None else np.asarray(velocity, dtype=float)
        self.last, self.before = np.zeros((2, *self.position.shape)) if history is None else np.asarray(history, float)

    def advanced(self, force, beta, dt):
        """The particles after a step."""
        series = damped_series(beta * dt)
        place, velocity = self.position.copy(), self.velocity.copy()
        for n in np.ndindex(place.shape):
            place[n], velocity[n] = equations.advance_coordinate(
                self.position[n], self.velocity[n], force[n], self.last[n], self.before[n], dt, series
            )
        return Moving(place, velocity, [force, self.last])


def normalized(force, spacing, d_min):
    """Normalized Coulomb force of every row, of any dimension; `spacing` of each, or of all."""
    force = np.atleast_2d(np.asarray(force, dtype=float))
    sizes, spacings = np.linalg.norm(force, axis=1), np.broadcast_to(spacing, len(force))
    return np.array([f * coulomb_scale(size, s, d_min) for f, size, s in zip(force, sizes, spacings, strict=True)])


def oscillator_error(beta, k, dt, duration, start):
    """Error at the end of damped oscillations ``r'' = -k r - beta r'`` that start on the analytic solution.

    `start` holds the positions (first row) and velocities (second row) of some oscillators.
    """
    matrix = np.array([(0.0, 1.0), (-k, -beta)])

    def analytic(t):
        return expm(matrix * t) @ np.array(start)

    now = Moving(start[:1], start[1:], [-k * analytic(-dt)[:1], -k * analytic(-2.0 * dt)[:1]])
    for _ in range(round(duration / dt)):
        now = now.advanced(-k * now.position, beta, dt)
    return np.abs(np.concatenate([now.position, now.velocity]) - analytic(duration)).max()


@pytest.mark.parametrize("beta", [0.0, 0.3, 0.8, 2.0, 4.0])
def test_integrator_is_of_second_order_on_the_damped_oscillator(beta):
    """Observed orders from halving the step, for k = 2 over four units of time.

    Between steps of 0.0125 and 0.00625: 2.00 for every beta, but 1.98 at beta = 4. Between 0.05 and 0.025: 2.00, 2.03,
    2.02, 1.98 and 1.87 for beta = 0, 0.3, 0.8, 2 and 4. Errors at a step of 0.025 are 6e-4 without damping and 8e-6 at
    beta = 4.
    """
    errors = np.array([oscillator_error(beta, 2.0, 0.05 / 2**n, 4.0, [(1.0, 0.4), (0.5, -1.0)]) for n in range(4)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders[-1] == pytest.approx(2.0, abs=0.1)
    assert np.all(orders > 1.75)
    assert errors[1] < 1e-3


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.05, 1.0))
def test_without_damping_a_step_is_eq_14_and_15(seed, dt):
    rng = np.random.default_rng(seed)
    r, v, a, last, before = rng.normal(size=(5, 7, 2))
    slope = (3.0 * a - 4.0 * last + before) / (2.0 * dt)
    after = Moving(r, v, [last, before]).advanced(a, 0.0, dt)
    np.testing.assert_allclose(after.position, r + dt * v + dt**2 / 2.0 * a + dt**3 / 6.0 * slope, atol=1e-13)
    np.testing.assert_allclose(after.velocity, v + dt * a + dt**2 / 2.0 * slope, atol=1e-13)


@settings(max_examples=12, deadline=None)
@given(st.floats(0.02, 30.0), st.floats(0.05, 1.0), st.integers(1, 30), st.integers(0, 10**6))
def test_force_linear_in_time_is_integrated_exactly(beta, dt, steps, seed):
    """The quadratic of eq. (15) has the slope of a straight line, and damping is integrated in closed form."""
    r, v, constant, slope = np.random.default_rng(seed).normal(size=(4, 3, 2))

    def force(t):
        return constant + slope * t

    now = Moving(r, v, [force(-dt), force(-2.0 * dt)])
    for n in range(steps):
        now = now.advanced(force(n * dt), beta, dt)
    t = steps * dt
    # v' + beta v = c + s t: a particular solution linear in t, and what decays of the difference at the start
    steady = constant / beta - slope / beta**2
    kept = np.exp(-beta * t)
    velocity = steady + slope / beta * t + (v - steady) * kept
    position = r + steady * t + slope / beta * t**2 / 2.0 + (v - steady) * (1.0 - kept) / beta
    size = 1.0 + np.abs(steady).max()
    np.testing.assert_allclose(now.velocity, velocity, rtol=1e-9, atol=1e-9 * size)
    np.testing.assert_allclose(now.position, position, rtol=1e-9, atol=1e-9 * size * (1.0 + t))


@pytest.mark.parametrize("beta", [0.1, 0.8, 3.0])
def test_terminal_velocity_is_force_over_damping(beta):
    force = np.array([[1.75, -0.5]])
    now = Moving([[0.0, 0.0]], history=[force, force])
    for _ in range(round(40.0 / (beta * 0.5))):
        now = now.advanced(force, beta, 0.5)
    np.testing.assert_allclose(now.velocity, force / beta, rtol=1e-12)


@settings(max_examples=12, deadline=None)
@given(st.floats(0.0, 20.0), st.floats(0.01, 1.0), st.integers(1, 20))
def test_velocity_decays_exponentially_without_force(beta, dt, steps):
    now = Moving([[3.0, 4.0]], [[1.0, -2.0]])
    for _ in range(steps):
        now = now.advanced(np.zeros((1, 2)), beta, dt)
    np.testing.assert_allclose(now.velocity, np.array([[1.0, -2.0]]) * np.exp(-beta * dt * steps), rtol=1e-11)


@pytest.mark.parametrize("dimension", [2, 3])
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), decades=st.floats(-6.0, 6.0))
def test_normalized_coulomb_keeps_the_direction_and_is_at_most_of_unit_size(dimension, seed, decades):
    rng = np.random.default_rng(seed)
    force = rng.normal(size=(20, dimension)) * 10.0**decades
    out = normalized(force, rng.uniform(0.0, 20.0, 20), 2.0)
    size, length = np.linalg.norm(force, axis=1), np.linalg.norm(out, axis=1)
    assert np.all(length <= 1.0 + 1e-12)
    np.testing.assert_allclose(out * size[:, None], force * length[:, None], atol=1e-12 * size.max())


def test_normalized_coulomb_is_linear_near_equilibrium_and_of_unit_size_on_a_sparse_front():
    force = np.array([0.003, -0.004])
    (weak,) = normalized(force, 2.5, 2.0)
    assert 0.0 < np.linalg.norm(weak) < 0.1
    for factor in (0.01, 0.5, 3.0):
        np.testing.assert_allclose(normalized(factor * force, 2.5, 2.0)[0], factor * weak, rtol=1e-12)
    np.testing.assert_allclose(normalized(1e6 * force, 2.5, 2.0)[0], [0.6, -0.8], rtol=1e-12)


def test_repulsion_is_whole_at_first_and_fades_to_nothing():
    left = np.array([repulsion_left(idle) for idle in range(2000)])
    assert left[0] == 1.0
    assert left[-1] == 0.0
    assert np.all(np.diff(left) <= 0.0)
    assert np.all(left >= 0.0)


@pytest.mark.parametrize("beta", [0.0, 0.05, 0.4, 0.8, 4.0])
def test_damping_is_beta_at_first_and_never_falls(beta):
    coefficient = np.array([damping_coefficient(beta, idle) for idle in range(2000)])
    assert coefficient[0] == beta
    assert np.all(np.diff(coefficient) >= 0.0)
    assert coefficient[-1] > 2.0 * max(beta, 0.01)
    assert np.isfinite(coefficient).all()


@settings(max_examples=24, deadline=None)
@given(st.floats(0.0, 3.0), st.floats(0.0, 3.0), st.floats(0.1, 5.0), st.integers(0, 300))
def test_friction_that_holds_holds_whatever_is_slower_pulled_less_or_idle_for_longer(pull, speed, w1, idle):
    if is_stuck(pull, speed, w1, idle):
        assert is_stuck(0.5 * pull, speed, w1, idle)
        assert is_stuck(pull, 0.5 * speed, w1, idle)
        assert is_stuck(pull, speed, 2.0 * w1, idle)
        assert is_stuck(pull, speed, w1, idle + 20)
    # forces are in units of w1
    assert is_stuck(pull, speed, w1, idle) == is_stuck(4.0 * pull, speed, 4.0 * w1, idle)


CREEPING = Parameters(reach=8.0)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("reach", (0.0, 5.0, 50.0, 299.0, UNLIMITED_REACH)),
        ("annealing", (0.5, 0.9, 0.99, 0.999, 1.0)),
        ("w1", (0.0, 0.1, 0.8, 1.6, 1.74)),
        ("beta", (2.0, 1.2, 0.8, 0.4, 0.1)),
    ],
)
def test_a_front_creeps_farther_with_more_reach_push_and_annealing_and_with_less_damping(name, values):
    ranges = [creeping_range(replace(CREEPING, **{name: value})) for value in values]
    assert all(before < after for before, after in pairwise(ranges))


@pytest.mark.parametrize("reach", [0.0, 2.0, 120.0])
def test_at_the_values_of_the_paper_a_front_creeps_as_far_as_the_reach(reach):
    assert creeping_range(replace(PRESETS["shape"], reach=reach)) == pytest.approx(reach)


def test_an_unlimited_reach_is_unlimited_from_the_values_of_the_paper_on():
    unlimited = Parameters(reach=UNLIMITED_REACH)
    assert creeping_range(unlimited) == creeping_range(replace(unlimited, beta=0.4)) == np.inf
    assert creeping_range(replace(unlimited, beta=1.6)) == pytest.approx(UNLIMITED_REACH / 4.0)


def test_without_repulsion_no_front_creeps_and_without_annealing_or_limit_every_front_does_so_without_end():
    assert creeping_range(replace(CREEPING, w1=0.0)) == 0.0
    assert creeping_range(replace(CREEPING, w1=0.0, annealing=1.0)) == 0.0
    assert creeping_range(replace(CREEPING, annealing=1.0)) == np.inf
    assert creeping_range(replace(CREEPING, reach=UNLIMITED_REACH, w1=0.0)) == 0.0
    assert np.isfinite(creeping_range(replace(CREEPING, beta=0.0)))
