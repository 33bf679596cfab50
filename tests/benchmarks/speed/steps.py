"""Runs under way: a time step beside the Coulomb force alone, the reconstruction beside one triangulation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import scipy

from cpm_core.model.coulomb import coulomb_force
from cpm_core.model.starts import uniform_grid
from cpm_core.model.state import State
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.published.crust import reconstruct_curve
from cpm_core.segmentation.engine import Engine
from tests.benchmarks.speed.measurement import Measurement, Patience, milliseconds_of
from tests.benchmarks.speed.scenes import HAND, along_curves, objects

_WARM_UP = 60
"""Steps before the time is taken, after which most particles are on an edge and few are at rest."""

_TIMED = 30

SIDES = (345, 1080)
"""Sides of the images on which there are then about 2,000 and 20,000 particles [px]."""

_POINTS = 5_000
_STEPS = 120
"""Steps before a reconstruction, which a window does in the course of a run."""


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


def under_way(side: int | tuple[int, int], parameters: Parameters, count: int = _WARM_UP) -> tuple[Engine, State]:
    """A run that started everywhere on a scene of that side, or (rows, columns), and has done `count` steps."""
    engine = Engine(objects(side if isinstance(side, tuple) else (side, side)), parameters)
    state = engine.start(uniform_grid(engine.image.shape))
    for _ in range(count):
        state = engine.step(state, parameters)
    return engine, state


def reconstructions(patience: Patience) -> Iterator[Measurement]:
    """Contours through points without an image, and those of a run under way."""
    points = along_curves(800 if patience.quick else _POINTS)
    ours, peer = milliseconds_of(patience, lambda: reconstruct_curve(points), lambda: scipy.spatial.Delaunay(points))
    yield Measurement("reconstruction", f"curves through {len(points)} points", ours, "ms", "1 triangulation", peer)
    parameters = replace(PRESETS["automatic"], scales=1)
    engine, state = under_way((160, 220) if patience.quick else HAND, parameters, _STEPS)
    ours, peer = milliseconds_of(
        patience, lambda: engine.result(state, parameters), lambda: scipy.spatial.Delaunay(state.position)
    )
    what = f"contours of a run, {len(state.position)} particles"
    yield Measurement("reconstruction", what, ours, "ms", "1 triangulation", peer)
