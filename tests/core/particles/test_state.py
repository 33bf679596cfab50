"""What keeping a state costs, and what of it can be made again."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import Engine, Parameters
from cpm_core.particles.mesh import MESH_EVERY
from cpm_core.particles.state import State

from ..scenes import ring

PARAMETERS = Parameters(scales=1)
ARRAYS = ("position", "velocity", "force", "distance", "identity")


@pytest.fixture(scope="module")
def engine():
    return Engine(ring((120, 110), (59.4, 55.7), 20.0, 45.0).values, PARAMETERS)


@pytest.fixture(scope="module")
def states(engine):
    """So many particles, for a while, that a mesh serves for what comes from afar."""
    states = [engine.start(np.random.default_rng(1).uniform(0.0, 109.0, (3000, 2)))]
    for _ in range(11):
        states.append(engine.step(states[-1], PARAMETERS))
    assert any(state.mesh is not None and len(state.mesh.force) for state in states)
    return states


def bits(state: State):
    return [getattr(state.particles, name).tobytes() for name in ARRAYS]


def test_the_memory_of_a_state_is_that_of_its_arrays(states):
    state = states[6]
    particles = sum(getattr(state.particles, name).nbytes for name in ARRAYS)
    assert particles == state.count * 8 * (2 + 2 + 4 + 4 + 1)
    rest = state.start.nbytes + state.coverage.found.nbytes + state.coverage.latest.nbytes
    rest += state.mesh.force.nbytes + state.mesh.softening.nbytes
    assert state.nbytes == particles + rest


def test_an_array_that_is_there_twice_counts_once(states):
    state = states[0]
    assert state.coverage.found is state.coverage.latest
    particles = sum(getattr(state.particles, name).nbytes for name in ARRAYS)
    assert state.nbytes == particles + state.start.nbytes + state.coverage.found.nbytes
    shared = replace(state, start=state.particles.position)
    assert shared.nbytes == state.nbytes - state.start.nbytes


def test_a_view_counts_as_all_that_it_keeps_in_memory(states):
    state = states[6]
    wide = np.zeros((100 * len(state.start), 2))
    assert replace(state, start=wide[:10]).nbytes == state.nbytes - state.start.nbytes + wide.nbytes


def test_a_step_from_a_light_state_gives_the_same_bits(engine, states):
    lighter = 0
    for state in states[:-1]:
        light = state.light()
        lighter += light.nbytes < state.nbytes
        assert light.mesh is None or state.step_of_scale % MESH_EVERY
        one, other = state, light
        for _ in range(MESH_EVERY + 1):
            one, other = (engine.step(each, PARAMETERS) for each in (one, other))
            assert bits(one) == bits(other)
    assert lighter >= 1
