"""Run actions: they lead from one state to the next, and can be repeated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Place
from cpm_core.parameters import Parameters
from cpm_core.segmentation.method import Method, Steerable


class RunAction(Protocol):
    """Something done to a state; equal actions lead from the same state to the same next one."""

    @property
    def regions(self) -> AnyRegions | None:
        """Regions of the method that did it."""

    def apply(self, method: Method[Any], state: Any) -> Any:
        """Apply it to a state of a method with these regions."""


@dataclass(frozen=True, slots=True)
class Stepped:
    """One step with these parameters, placed charges and regions; a run that had ended goes on."""

    parameters: Parameters
    charges: tuple[PlacedCharge, ...] = ()
    regions: AnyRegions | None = None

    def apply(self, method: Method[Any], state: Any) -> Any:
        """Take the step."""
        state = state.resumed() if state.stop_reason else state
        return method.step(state, self.parameters, self.charges)


@dataclass(frozen=True, slots=True)
class Joined:
    """Particles added at seeds, shape (N, `axes`), whose bytes are stored so that actions can be compared."""

    seeds: bytes
    regions: AnyRegions | None = None
    axes: int = 2

    @classmethod
    def at(cls, seeds: Array, regions: AnyRegions | None) -> Joined:
        """Particles added at seeds, shape (N, D)."""
        return cls(seeds.tobytes(), regions, seeds.shape[1])

    @property
    def places(self) -> Array:
        """The seeds."""
        return np.frombuffer(self.seeds).reshape(-1, self.axes)

    def apply(self, method: Method[Any], state: Any) -> Any:
        """Add the particles; a method without moving particles leaves its state as it is."""
        return method.joined(state, self.places) if isinstance(method, Steerable) else state


@dataclass(frozen=True, slots=True)
class Erased:
    """Particles removed that are no farther from a path than a radius, in sides of the smallest pixel or voxel."""

    path: tuple[Place, ...]
    radius: float
    regions: AnyRegions | None = None

    def apply(self, method: Method[Any], state: Any) -> Any:
        """Remove the particles; a method without moving particles leaves its state as it is."""
        spacing = method.image.spacing
        return method.erased(state, lambda at: self.reaches(at, spacing)) if isinstance(method, Steerable) else state

    def reaches(self, places: Array, spacing: tuple[float, ...]) -> ArrayLike:
        """Which places, shape (N, D), are no farther from the path than the radius."""
        sides = np.array(spacing) / min(spacing) if len(self.path[0]) == 3 else 1.0
        return polyline.distances(np.array(self.path) * sides, places * sides) <= self.radius
