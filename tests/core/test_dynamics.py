"""The motion of the particles, against analytic solutions of the equation of motion."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from cpm_core.dynamics import _damped_series, advance, damping, normalised_coulomb, repulsion_left, stick
from cpm_core.particles import Particles


def particles(position, velocity=None, history=None):
    """Particles that have felt `history`, shape (2, N, D): the last force and the one before."""
    position = np.asarray(position, dtype=float)
    rest = Particles.at_rest(position)
    velocity = rest.velocity if velocity is None else np.asarray(velocity, dtype=float)
    history = rest.force if history is None else np.asarray(history, dtype=float)
    return Particles(position, velocity, history, rest.distance, rest.identity)


def every(beta, count):
    return np.full(count, float(beta))


def oscillator_error(beta, k, dt, duration, start):
    """Error at the end of damped oscillations ``r'' = -k r - beta r'`` that start on the analytic solution.

    `start` holds the positions (first row) and velocities (second row) of some oscillators.
    """
    matrix = np.array([(0.0, 1.0), (-k, -beta)])

    def analytic(t):
        return expm(matrix * t) @ np.array(start)

    now = particles(start[:1], start[1:], [-k * analytic(-dt)[:1], -k * analytic(-2.0 * dt)[:1]])
    for _ in range(round(duration / dt)):
        now = advance(now, -k * now.position, every(beta, 1), dt)
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


def test_strong_damping_is_no_threat_to_stability():
    """At beta dt = 20, where an explicit damping term would explode, the slow creep is followed to 1e-3."""
    beta, k, dt, steps = 40.0, 2.0, 0.5, 40
    rate = -0.5 * beta + np.sqrt(0.25 * beta**2 - k)
    history = [[[-k * np.exp(-rate * dt)]], [[-k * np.exp(-2.0 * rate * dt)]]]
    now = particles([[1.0]], [[rate]], history)
    for _ in range(steps):
        now = advance(now, -k * now.position, every(beta, 1), dt)
    np.testing.assert_allclose(now.position, np.exp(rate * dt * steps), rtol=1e-3)
    np.testing.assert_allclose(now.velocity, rate * np.exp(rate * dt * steps), rtol=1e-3)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.05, 1.0))
def test_without_damping_a_step_is_eq_14_and_15(seed, dt):
    rng = np.random.default_rng(seed)
    r, v, a, last, before = rng.normal(size=(5, 7, 2))
    slope = (3.0 * a - 4.0 * last + before) / (2.0 * dt)
    after = advance(particles(r, v, [last, before]), a, every(0.0, 7), dt)
    np.testing.assert_allclose(after.position, r + dt * v + dt**2 / 2.0 * a + dt**3 / 6.0 * slope, atol=1e-13)
    np.testing.assert_allclose(after.velocity, v + dt * a + dt**2 / 2.0 * slope, atol=1e-13)
    np.testing.assert_array_equal(after.force, [a, last])


@settings(max_examples=30, deadline=None)
@given(st.floats(0.02, 30.0), st.floats(0.05, 1.0), st.integers(1, 30), st.integers(0, 10**6))
def test_force_linear_in_time_is_integrated_exactly(beta, dt, steps, seed):
    """The quadratic of eq. (15) has the slope of a straight line, and damping is integrated in closed form."""
    r, v, constant, slope = np.random.default_rng(seed).normal(size=(4, 3, 2))

    def force(t):
        return constant + slope * t

    now = particles(r, v, [force(-dt), force(-2.0 * dt)])
    for n in range(steps):
        now = advance(now, force(n * dt), every(beta, 3), dt)
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
    now = particles([[0.0, 0.0]], history=[force, force])
    for _ in range(round(40.0 / (beta * 0.5))):
        now = advance(now, force, every(beta, 1), 0.5)
    np.testing.assert_allclose(now.velocity, force / beta, rtol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.0, 20.0), st.floats(0.01, 1.0), st.integers(1, 20))
def test_velocity_decays_exponentially_without_force(beta, dt, steps):
    now = particles([[3.0, 4.0]], [[1.0, -2.0]])
    for _ in range(steps):
        now = advance(now, np.zeros((1, 2)), every(beta, 1), dt)
    np.testing.assert_allclose(now.velocity, np.array([[1.0, -2.0]]) * np.exp(-beta * dt * steps), rtol=1e-11)


def test_each_particle_has_its_own_damping():
    r, v, a = np.random.default_rng(0).normal(size=(3, 4, 2))
    beta = np.array([0.0, 0.5, 2.0, 50.0])
    together = advance(particles(r, v), a, beta, 0.5)
    for i in range(4):
        alone = advance(particles(r[i : i + 1], v[i : i + 1]), a[i : i + 1], beta[i : i + 1], 0.5)
        np.testing.assert_array_equal(together.position[i : i + 1], alone.position)
        np.testing.assert_array_equal(together.velocity[i : i + 1], alone.velocity)


def phi(order, z):
    """``sum_k (-z)^k / (k + order)!`` to fifty digits."""
    with localcontext() as context:
        context.prec = 60
        x, term, total = Decimal(z), Decimal(1), Decimal(0)
        for k in range(1, order + 1):
            term /= k
        k = 0
        while abs(term) > Decimal(10) ** -50:
            total += term
            k += 1
            term *= -x / (k + order)
        return float(total)


@pytest.mark.parametrize("z", [0.0, 1e-9, 1e-4, 9.9e-3, 0.01 - 1e-12, 0.01, 0.01 + 1e-12, 1.1e-2, 0.1, 0.4, 3.0, 20.0])
def test_damped_weights_are_exact_on_both_sides_of_the_series(z):
    found = [float(part[0]) for part in _damped_series(np.array([z]))]
    np.testing.assert_allclose(found, [phi(order, z) for order in range(4)], rtol=1e-10)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6), st.floats(-6.0, 6.0))
def test_normalised_coulomb_keeps_the_direction_and_is_at_most_of_unit_size(seed, decades):
    rng = np.random.default_rng(seed)
    force = rng.normal(size=(20, 2)) * 10.0**decades
    out = normalised_coulomb(force, rng.uniform(0.0, 20.0, 20), 2.0)
    assert np.all(np.linalg.norm(out, axis=1) <= 1.0 + 1e-12)
    cross = force[:, 0] * out[:, 1] - force[:, 1] * out[:, 0]
    assert np.all(np.abs(cross) <= 1e-12 * np.linalg.norm(force, axis=1))
    assert np.all(np.einsum("ni,ni->n", force, out) >= 0.0)


def test_normalised_coulomb_is_linear_near_equilibrium_and_of_unit_size_on_a_sparse_front():
    force = np.array([[0.003, -0.004]])
    spacing = np.array([2.5])
    weak = normalised_coulomb(force, spacing, 2.0)
    assert 0.0 < np.linalg.norm(weak) < 0.1
    for factor in (0.01, 0.5, 3.0):
        np.testing.assert_allclose(normalised_coulomb(factor * force, spacing, 2.0), factor * weak, rtol=1e-12)
    np.testing.assert_allclose(normalised_coulomb(1e6 * force, spacing, 2.0), [[0.6, -0.8]], rtol=1e-12)


def test_normalised_coulomb_of_balanced_or_coinciding_particles_is_nothing():
    assert not normalised_coulomb(np.zeros((3, 2)), np.array([0.0, 2.0, 9.0]), 2.0).any()
    assert not normalised_coulomb(np.ones((1, 2)), np.zeros(1), 2.0).any()


def test_normalised_coulomb_does_not_depend_on_the_scale():
    """Twice the spacing means a quarter of the force: the same push on the same pattern, once beyond d_min."""
    force, spacing = np.array([[0.05, 0.02]]), np.array([3.0])
    once, twice = normalised_coulomb(force, spacing, 2.0), normalised_coulomb(force / 4.0, 2.0 * spacing, 2.0)
    np.testing.assert_allclose(once, twice, rtol=1e-12)


def test_repulsion_is_whole_at_first_and_fades_to_nothing():
    left = repulsion_left(np.arange(2000))
    assert left[0] == 1.0
    assert left[-1] == 0.0
    assert np.all(np.diff(left) <= 0.0)
    assert np.all(left >= 0.0)


@pytest.mark.parametrize("beta", [0.0, 0.05, 0.4, 0.8, 4.0])
def test_damping_is_beta_at_first_and_never_falls(beta):
    coefficient = damping(beta, np.arange(2000))
    assert damping(beta, np.zeros(5, np.int64)).tolist() == [beta] * 5
    assert np.all(np.diff(coefficient) >= 0.0)
    assert coefficient[-1] > 2.0 * max(beta, 0.01)
    assert np.isfinite(coefficient).all()


@pytest.mark.parametrize("beta", [0.0, 0.05, 0.8])
def test_damping_of_a_particle_does_not_depend_on_the_others(beta):
    idle = np.array([0, 10, 60, 500])
    alone = [float(damping(beta, idle[i : i + 1])[0]) for i in range(len(idle))]
    assert damping(beta, idle).tolist() == alone


def seated_crowd(seed, count=40):
    rng = np.random.default_rng(seed)
    position, velocity, last, before, force, normal = rng.normal(size=(6, count, 2))
    moving = particles(position, 0.5 * velocity, [last, before])
    return moving, 0.5 * force, 10.0 * normal, rng.random(count) < 0.7, rng.integers(0, 100, count)


def parts(vectors, normal):
    """Components of vectors (..., N, 2) across and along the edge."""
    unit = normal / np.linalg.norm(normal, axis=1)[:, None]
    tangent = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    return np.einsum("...ni,ni->...n", vectors, unit), np.einsum("...ni,ni->...n", vectors, tangent)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_friction_takes_what_goes_along_the_edge_or_nothing(seed):
    before, force, normal, seated, idle = seated_crowd(seed)
    after, left = stick(before, force, normal, seated, 1.6, idle)
    stuck = np.abs(parts(left, normal)[1]) < 1e-12
    for old, new in ((force, left), (before.velocity, after.velocity), (before.force, after.force)):
        (across, along), (across_after, along_after) = parts(old, normal), parts(new, normal)
        np.testing.assert_allclose(across_after, across, atol=1e-12)
        np.testing.assert_allclose(along_after, np.where(stuck, 0.0, along), atol=1e-12)
    np.testing.assert_array_equal(after.position, before.position)
    assert not stuck[~seated].any()


def along_edge(speed, pull, seated=True, idle=0):
    """Force and velocity along an edge that friction leaves of these; w1 is 1."""
    before = particles([[5.0, 5.0]], [[0.0, speed]])
    after, force = stick(
        before, np.array([[0.3, pull]]), np.array([[4.0, 0.0]]), np.array([seated]), 1.0, np.array([idle])
    )
    assert force[0, 0] == pytest.approx(0.3)
    return float(force[0, 1]), float(after.velocity[0, 1])


def test_friction_holds_the_slow_under_a_small_force_on_an_edge():
    assert along_edge(0.01, 0.01) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("speed", "pull", "seated"),
    [(0.01, 0.01, False), (3.0, 0.01, True), (0.01, 0.9, True)],
    ids=["free", "fast", "pulled hard"],
)
def test_friction_does_not_hold(speed, pull, seated):
    assert along_edge(speed, pull, seated) == pytest.approx((pull, speed))


def test_friction_grows_while_nothing_new_is_found():
    held = [along_edge(0.01, 0.9, idle=idle)[0] == 0.0 for idle in range(0, 400, 10)]
    assert held == sorted(held)
    assert held[-1]


def test_friction_without_a_normal_does_not_fail():
    before = particles([[5.0, 5.0]], [[0.1, 0.1]])
    after, force = stick(before, np.ones((1, 2)), np.zeros((1, 2)), np.array([False]), 1.6, np.array([0]))
    np.testing.assert_array_equal(force, 1.0)
    np.testing.assert_array_equal(after.velocity, before.velocity)
