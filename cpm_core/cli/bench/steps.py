"""A time step of the model, beside the Coulomb force alone."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from cpm_core.cli.bench.measurement import Measurement, Patience, milliseconds_of
from cpm_core.cli.bench.scenes import objects
from cpm_core.parameters import Parameters
from cpm_core.particles.coulomb.coulomb_force import coulomb_force
from cpm_core.particles.initialization import uniform_grid
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine

_WARM_UP = 60
"""Steps before the clock is started, after which most particles are on an edge and few are at rest."""

_TIMED = 30

SIDES = (345, 1080)
"""Sides of the images on which there are then about 2,000 and 20,000 particles [px]."""


def steps(patience: Patience) -> Iterator[Measurement]:
    """Steps of runs on one scale that are under way, at two numbers of particles."""
    parameters = Parameters(scales=1)
    for side in (150,) if patience.quick else SIDES:
        engine, state = under_way(side, parameters)

        def some(engine: Engine = engine, state: State = state) -> None:
            for _ in range(_TIMED):
                state = engine.step(state, parameters)

        some_steps, force = milliseconds_of(patience, some, partial(coulomb_force, state.position))
        one = some_steps / _TIMED
        particles = len(state.position)
        note = f"{1e3 / one:.0f} steps/s, {1e6 * one / particles:.0f} ns a particle"
        yield Measurement("step", f"step, {particles} particles", one, "ms", "Coulomb force alone", force, note=note)


def under_way(side: int, parameters: Parameters) -> tuple[Engine, State]:
    """A run that started everywhere on a scene of `side` x `side` pixels and is some steps old."""
    engine = Engine(objects((side, side)), parameters)
    state = engine.start(uniform_grid(engine.image.shape))
    for _ in range(_WARM_UP):
        state = engine.step(state, parameters)
    return engine, state
