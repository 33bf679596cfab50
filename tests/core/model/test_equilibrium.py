"""Eq. (23) term by term, and the laws of rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Engine, Parameters, uniform_grid
from cpm_core.model.equations import EPSILON_BOUND, QUIET_STEPS, equilibrium_epsilon, is_quiet

from ..scenes import disk

T = 4
histories = st.lists(st.lists(st.floats(0.0, 500.0), min_size=T, max_size=T), min_size=1, max_size=20)


@settings(max_examples=24, deadline=None)
@given(histories)
def test_epsilon_is_eq_23(history):
    total = 0.0
    for i in range(1, T + 1):
        total += (-1) ** i * sum(row[i - 1] for row in history)
    assert equilibrium_epsilon(np.array(history)) == pytest.approx(abs(total) / len(history), abs=1e-9)


def test_particles_at_rest_have_no_epsilon_and_steady_motion_has():
    rest = np.repeat(np.array([[3.0], [40.0], [17.5]]), T, axis=1)
    assert equilibrium_epsilon(rest) == 0.0
    moving = rest + 0.1 * np.arange(T)[::-1]
    assert equilibrium_epsilon(moving) == pytest.approx(0.2)


@settings(max_examples=24, deadline=None)
@given(st.floats(0, 0.01), st.integers(0, 40), st.integers(0, 40), st.integers(1, 5000))
def test_a_quieter_step_is_never_less_quiet(value, moving, changed, count):
    quiet = is_quiet(value, moving, changed, count)
    assert value < EPSILON_BOUND or not quiet
    assert is_quiet(0.5 * value, moving, changed, count) >= quiet
    assert is_quiet(value, moving // 2, changed, count) >= quiet
    assert is_quiet(value, moving, changed // 2, count) >= quiet
    assert is_quiet(value, moving, changed, 2 * count) >= quiet
    assert is_quiet(value + 0.001, moving, changed, count) <= quiet
    assert is_quiet(value, moving + 1, changed, count) <= quiet
    assert is_quiet(value, moving, changed + 1, count) <= quiet


def test_a_run_at_rest_would_stay_within_a_tenth_of_a_pixel():
    """Were it to go on for as many steps as were quiet; which is what the bounds on motion are for."""
    parameters, scene = Parameters(scales=1), disk((56, 60), (27.4, 30.2), 15.0)
    engine = Engine(scene.values, parameters)
    state = engine.start(uniform_grid(scene.values.shape))
    while not state.stop_reason:
        state = engine.step(state, parameters)
    assert state.converged
    later = state.resume()
    for _ in range(QUIET_STEPS):
        later = engine.step(later, parameters)
    before = dict(zip(state.particles.identity.tolist(), state.position, strict=True))
    kept = [(i, p) for i, p in zip(later.particles.identity.tolist(), later.position, strict=True) if i in before]
    assert len(kept) == len(before) == later.count
    assert max(np.linalg.norm(p - before[i]) for i, p in kept) < 0.1
