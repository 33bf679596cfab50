"""The forces on one particle, asked for by a place and worked out on the worker thread."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import Report
from app.session.worker.commands.run import Command, CommandContext
from cpm_core.numerics.types import Array, Position
from cpm_core.segmentation.method import Steerable

NAMES = ("coulomb", "lorentz", "placed", "friction", "damping", "total")
"""Forces that are told of: attributes of the core's `Forces`."""


@dataclass(frozen=True, eq=False, slots=True)
class Probed(Report):
    """What pulls at a particle.

    Attributes
    ----------
    generation, step : int
        The moment of the run.
    identity : int
        Which particle, -1 where there is none near the place asked for.
    position : tuple of float
        Where it is [px of the image].
    forces : mapping
        By name, (row, col) [px of the image / unit of time^2].
    """

    generation: int
    step: int
    identity: int = -1
    position: Position = (0.0, 0.0)
    forces: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Probe(Command):
    """Tell the forces on the particle nearest to a place.

    Attributes
    ----------
    generation : int
        The run.
    place : tuple of float
        (row, col) [px of the image].
    reach : float
        Distance within which a particle counts [px of the image].
    """

    generation: int
    place: Position
    reach: float

    latest_only = True
    activity = "working out the forces on a particle"

    def execute(self, context: CommandContext) -> None:
        """Find it and ask the method."""
        method, state = context.run.method, context.run.state
        if not isinstance(method, Steerable) or state is None or self.generation != context.run.generation:
            context.report(Probed(self.generation, -1))
            return
        position = state.position
        distance = np.hypot(*(position - self.place).T)
        nearest = int(distance.argmin()) if len(distance) else -1
        if nearest < 0 or distance[nearest] > self.reach:
            context.report(Probed(self.generation, state.step))
            return
        found = method.forces(state, context.run.parameters, context.run.charges, [nearest])
        if np.isnan(found.total).any():  # new regions take it away at the next step
            context.report(Probed(self.generation, state.step))
            return
        size = 2.0**state.scale
        at = (float(position[nearest, 0]), float(position[nearest, 1]))
        forces = {name: size * getattr(found, name)[0] for name in NAMES}
        context.report(Probed(self.generation, state.step, int(state.particles.identity[nearest]), at, forces))

    def failure_report(self, error: Exception) -> Report:
        """There is none; who points would be told so in every frame, so that nothing is said."""
        logging.getLogger(__name__).error("%s", sentence(error, self.activity))
        return Probed(self.generation, -1)
