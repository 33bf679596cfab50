"""The potential energy of a run: worked out now and then, and only where that does not hold up the run."""

from __future__ import annotations

from cpm_core.parameters import Parameters
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine

_EVERY = 8
"""Steps between two looks: one takes about as long as a small part of a step."""

_AT_ONCE = 1 << 20
"""Pixels up to which the potential, which has to be made once for each field, is ready within a blink."""


class PotentialEnergySampler:
    """Tells the potential energy of states of a run."""

    def __init__(self) -> None:
        self.wanted = False
        """Whether somebody looks at it, so that it is worth waiting for."""

    def potential(self, engine: Engine, state: State, parameters: Parameters) -> float | None:
        """The potential energy of a state, None where it is not worked out."""
        height, width = engine.image.shape
        if state.step % _EVERY or not (self.wanted or height * width <= _AT_ONCE):
            return None
        return engine.energies(state, parameters, state.charges).potential
