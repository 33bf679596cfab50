"""What a run is taken from one state to the next by: enough to do it again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.regions import Regions
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Position
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine


class RunAction(Protocol):
    """Something done to a state; deeds that are equal lead from the same state to the same one."""

    @property
    def regions(self) -> Regions | None:
        """Regions of the engine by which it was done."""

    def apply(self, engine: Engine, state: State) -> State:
        """Do it to a state, by an engine with these regions."""


@dataclass(frozen=True, slots=True)
class Stepped:
    """One step with these parameters, placed charges and regions; a run that had ended goes on."""

    parameters: Parameters
    charges: tuple[PlacedCharge, ...] = ()
    regions: Regions | None = None

    def apply(self, engine: Engine, state: State) -> State:
        """Take the step."""
        state = state.resumed() if state.stop_reason else state
        return engine.step(state, self.parameters, self.charges)


@dataclass(frozen=True, slots=True)
class Joined:
    """Particles put into the run at seeds, shape (N, 2), of which the bytes are kept: they are compared at once."""

    seeds: bytes
    regions: Regions | None = None

    def apply(self, engine: Engine, state: State) -> State:
        """Put them in."""
        return engine.joined(state, np.frombuffer(self.seeds).reshape(-1, 2))


@dataclass(frozen=True, slots=True)
class Erased:
    """Particles taken out of the run that lie no further from a path than a radius."""

    path: tuple[Position, ...]
    radius: float
    regions: Regions | None = None

    def apply(self, engine: Engine, state: State) -> State:
        """Take them out."""
        return engine.erased(state, lambda places: polyline.distances(self.path, places) <= self.radius)
