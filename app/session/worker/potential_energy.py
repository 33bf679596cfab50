"""When the potential energy of a run is measured: now and then, and only where that does not hold up the run."""

from __future__ import annotations

import math

_EVERY = 8
"""Steps between two looks: one takes about as long as a small part of a step."""

_AT_ONCE = 1 << 20
"""Pixels up to which the potential, which has to be made once for each field, is ready within a blink."""


class PotentialEnergySampler:
    """Tells of which steps of a run the potential energy is measured."""

    def __init__(self) -> None:
        self.wanted = False
        """Whether it is looked at, so that it is worth waiting for."""

    def due(self, step: int, shape: tuple[int, ...]) -> bool:
        """Whether to measure it after a step on an image of this shape."""
        return not step % _EVERY and (self.wanted or math.prod(shape) <= _AT_ONCE)
