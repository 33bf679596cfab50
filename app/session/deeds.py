"""What a run is taken from one state to the next by: enough to do it again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cpm_core.engine import Engine
from cpm_core.parameters import Parameters
from cpm_core.particles import State


class Deed(Protocol):
    """Something done to a state; deeds that are equal lead from the same state to the same one."""

    def again(self, engine: Engine, state: State) -> State:
        """Do it to a state of a run of this engine."""


@dataclass(frozen=True, slots=True)
class Stepped:
    """One step with these parameters; a run that had ended goes on."""

    parameters: Parameters

    def again(self, engine: Engine, state: State) -> State:
        """Take the step."""
        return engine.step(state.resumed() if state.stop_reason else state, self.parameters)
