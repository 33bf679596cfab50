"""The forces on one particle, requested by a position and computed on the worker thread."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from app.model.text.language import tr
from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import Report
from app.session.worker.commands.run import Command, CommandContext
from cpm_core.numerics.types import Array, Place
from cpm_core.segmentation.method import Steerable

NAMES = ("coulomb", "lorentz", "placed", "friction", "damping", "total")
"""Forces that are reported: attributes of the core's `Forces`."""


@dataclass(frozen=True, eq=False, slots=True)
class Probed(Report):
    """The forces on a particle.

    Attributes
    ----------
    generation, step : int
        Run and step.
    identity : int
        The particle, -1 where there is none near the position.
    position : tuple of float
        Its position [px of the image].
    forces : mapping
        By name, (row, col) [px of the image / unit of time^2]; in a volume, (plane, row, col) in smallest sides of a
        voxel.
    sizes : mapping
        Size of each, in a volume.
    trouble : str
        What working them out failed with.
    """

    generation: int
    step: int
    identity: int = -1
    position: Place = (0.0, 0.0)
    forces: Mapping[str, Array] = field(default_factory=dict)
    trouble: str = ""
    sizes: Mapping[str, float] = field(default_factory=dict)

    def size(self, name: str) -> float:
        """Size of a force, also of one of which a slice shows a part."""
        return self.sizes[name] if name in self.sizes else math.hypot(*self.forces[name])


@dataclass(frozen=True, slots=True)
class Probe(Command):
    """Report the forces on the particle nearest to a place (row, col), within `reach` [px of the image]."""

    generation: int
    place: Place
    reach: float

    latest_only = True
    activity = tr("working out the forces on a particle")

    def execute(self, context: CommandContext) -> None:
        """Find the particle and report its forces."""
        method, state = context.run.method, context.run.state
        if not isinstance(method, Steerable) or state is None or self.generation != context.run.generation:
            context.report(Probed(self.generation, -1))
            return
        position = state.position
        distance = np.linalg.norm(position - self.place, axis=1)
        nearest = int(distance.argmin()) if len(distance) else -1
        if nearest < 0 or distance[nearest] > self.reach:
            context.report(Probed(self.generation, state.step))
            return
        found = method.forces(state, context.run.parameters, context.run.charges, [nearest])
        if np.isnan(found.total).any():  # new regions delete it at the next step
            context.report(Probed(self.generation, state.step))
            return
        size = 2.0**state.scale
        at = tuple(position[nearest].tolist())
        forces = {name: size * getattr(found, name)[0] for name in NAMES}
        sizes = {name: float(np.linalg.norm(force)) for name, force in forces.items()}
        identity = int(state.particles.identity[nearest])
        context.report(Probed(self.generation, state.step, identity, at, forces, sizes=sizes))

    def failure_report(self, error: Exception) -> Report:
        """There is none."""
        return Probed(self.generation, -1, trouble=sentence(error, self.activity))
