"""The charged particles as one of the methods that are compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

from cpm_core.contours.contour import Contour
from cpm_core.image.image import Image
from cpm_core.image.pyramid import most_scales
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.methods.method import ContourMethod, Start

MOST_STEPS = 4000


@dataclass(frozen=True, eq=False)
class ParticleState:
    """A state of the particles, with what its contours are reconstructed from."""

    engine: Engine = field(repr=False)
    state: State
    parameters: Parameters

    @property
    def step(self) -> int:
        """Number of steps so far."""
        return self.state.step

    @property
    def stop_reason(self) -> str:
        """Why the run ended, in words; empty while it continues."""
        return self.state.stop_reason

    @property
    def converged(self) -> bool:
        """Whether the particles came to rest."""
        return self.state.converged

    @property
    def points(self) -> Array:
        """The particles, shape (N, 2) [px]."""
        return self.state.position

    @cached_property
    def contours(self) -> tuple[Contour, ...]:
        """The contours that are reconstructed from the particles."""
        return self.engine.result(self.state, self.parameters).contours


def _evolve(image: Image, start: Start, parameters: Parameters) -> Iterator[ParticleState]:
    chosen = replace(parameters, scales=min(parameters.scales, most_scales(image.shape)))
    engine = Engine(image, chosen)
    state = engine.start(start.points)
    yield ParticleState(engine, state, chosen)
    while not state.stop_reason:
        state = engine.step(state, chosen)
        if state.step == MOST_STEPS and not state.stop_reason:
            state = state.stopped(f"stopped after {MOST_STEPS} steps")
        yield ParticleState(engine, state, chosen)


PARTICLES = ContourMethod(
    "cpm",
    Engine.title,
    "Particles that the electric field of the edges attracts, and that repel each other along them.",
    "Jalba, Wilkinson and Roerdink (2004)",
    Parameters,
    _evolve,
    MOST_STEPS,
)
