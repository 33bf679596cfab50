"""How far fronts creep in a volume: damping, weights and annealing decide, at every step."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import KDTree

import cpm_core as cpm
from cpm_core.model.equations import creeping_range

from ...reconstruction.surface.solids import ball, grid, rod, union, without

VOLUME = cpm.PRESETS["volume"]
SIDE, MIDDLE = 56.0, np.full(3, 27.5)
BENT = union(rod((6, 8, 8), (48, 8, 8), 4.0), rod((48, 8, 8), (48, 48, 8), 4.0), rod((48, 48, 8), (48, 48, 48), 4.0))
"""A rod with two corners."""

SHELL = without(ball(24.0, MIDDLE), ball(10.0, MIDDLE))


def volume(solid):
    gray = 200.0 * np.clip(0.5 + solid(grid(side=SIDE)), 0.0, 1.0)
    return gray + np.random.default_rng(1).normal(0.0, 4.0, gray.shape)


@cache
def bent():
    return cpm.Engine(volume(BENT), VOLUME)


def run(engine, state, parameters, steps=10_000):
    """The states that follow, up to a number of steps."""
    states = [state.resume()]
    while len(states) <= steps and not states[-1].stop_reason:
        states.append(engine.step(states[-1], parameters))
    return states


@cache
def from_one_end(parameters):
    return run(bent(), bent().start(cpm.sphere((8.0, 8.0, 8.0), 2.0, 60)), parameters)


@cache
def cells():
    places = grid(side=SIDE)
    return places[np.abs(BENT(places)) < 0.5]


def found(state):
    """Fraction of the surface with a particle near it."""
    return float((KDTree(state.position).query(cells())[0] < 2.5).mean())


SWEEPS = {
    "damping": [replace(VOLUME, beta=beta) for beta in (3.2, 1.6, 0.8, 0.4, 0.1)],
    "weights": [replace(VOLUME, w1=ratio * VOLUME.w2) for ratio in (0.05, 0.3, 0.5, 0.857, 0.98)],
    "annealing": [replace(VOLUME, annealing=annealing) for annealing in (0.5, 0.9, 0.95, 0.99, 1.0)],
}


@pytest.mark.parametrize("name", SWEEPS)
def test_less_damping_more_push_and_more_annealing_find_no_less_and_extreme_values_fail(name):
    ends = [from_one_end(parameters)[-1] for parameters in SWEEPS[name]]
    shares = [found(state) for state in ends]
    assert all(state.converged for state in ends)
    assert all(after >= before - 0.01 for before, after in pairwise(shares))
    assert shares[0] < 0.3
    assert shares[0] + 0.1 < shares[1] < 0.9
    assert shares[3:] == [1.0, 1.0]


def test_with_the_values_of_the_paper_fronts_creep_without_limit():
    published = replace(cpm.Parameters(), scales=1)
    assert creeping_range(published) == creeping_range(VOLUME) == np.inf
    assert found(from_one_end(published)[-1]) == 1.0


def test_no_particle_has_crept_beyond_the_range_and_those_of_the_start_have_not_crept():
    for parameters in (SWEEPS["damping"][0], SWEEPS["weights"][1], SWEEPS["annealing"][1]):
        states = from_one_end(parameters)
        started = states[0].next_identity
        for state in states[1:]:
            crept, identity = state.particles.crept, state.particles.identity
            assert crept.max() <= creeping_range(parameters)
            assert not crept[identity < started].any()
        assert crept.max() > 0.8 * creeping_range(parameters)


@pytest.mark.parametrize(
    ("at", "name"),
    [("at rest", "damping"), ("at rest", "weights"), ("at rest", "annealing"), ("in the middle of a run", "damping")],
)
def test_a_slider_acts_at_the_next_step_and_back_again(at, name):
    states, changed = from_one_end(VOLUME), SWEEPS[name][1]
    state = states[-1] if at == "at rest" else states[len(states) // 2]
    assert state.particles.crept.max() > creeping_range(changed)
    less = run(bent(), state, changed)
    assert less[1].particles.crept.max() <= creeping_range(changed)
    assert less[1].count < 0.9 * state.count
    assert abs(found(less[-1]) - found(from_one_end(changed)[-1])) < 0.03
    assert found(run(bent(), less[-1], VOLUME)[-1]) == 1.0


def test_without_repulsion_only_what_the_start_flies_to_is_found():
    states = from_one_end(replace(VOLUME, w1=0.0))
    assert 0 < states[-1].count <= len(states[0].start)


def test_nothing_is_reseeded_once_a_front_has_been_stopped():
    engine = cpm.Engine(volume(SHELL), VOLUME)
    start = engine.start(cpm.sphere(MIDDLE - (17.0, 0.0, 0.0), 3.0, 80))
    weak, strong = (run(engine, start, replace(VOLUME, beta=beta)) for beta in (2.4, 0.8))
    assert max(state.reseedings for state in weak) == 0
    hollow = np.linalg.norm(strong[-1].position - MIDDLE, axis=1) < 12.0
    assert hollow.sum() > 200


def test_what_is_reseeded_has_crept_farther_than_any_other_and_goes_first():
    engine = cpm.Engine(volume(SHELL), VOLUME)
    states = run(engine, engine.start(cpm.sphere(MIDDLE, 26.0, 400)), VOLUME)
    before, after = next(pair for pair in pairwise(states) if pair[1].reseedings > pair[0].reseedings)
    new = ~np.isin(after.particles.identity, before.particles.identity)
    assert after.particles.crept[new].min() > before.particles.crept.max()
