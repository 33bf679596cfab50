"""The state of a run on an image, and the window of a large image that a run is limited to."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from cpm_core.field.placed_charges import CHARGE_REACH
from cpm_core.image.image import Image
from cpm_core.image.pyramid import shape_at_scale, to_image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.coverage import (
    COVERAGE_CELL,
    NEVER_COVERED,
    Coverage,
    no_coverage,
    with_times_reset,
    with_times_reset_near,
)
from cpm_core.model.plane.repulsion import MeshForce
from cpm_core.model.state import Particles, State
from cpm_core.numerics.grids import Window, window_shape
from cpm_core.numerics.types import Array, Extent, Integers, Mask, Numbers

_WINDOW_END_DISTANCE = 16.0
"""Distance of a particle from the end of a window that widens it [px]: farther than any moves or searches in a step."""

_MIN_WINDOW_ROOM = 96
"""Least room around particles in a new window [px]."""

_MIN_WINDOWED_PIXELS = 2**20
"""Pixels of an image above which a run takes place in windows."""

_MAX_WINDOW_SHARE = 0.5
"""Largest share of an image that a window may cover; beyond it the run takes place in the whole image."""


def window_around(position: Array, shape: Extent, room: float = 0.0) -> Window | None:
    """Return the pixels of a scale of this shape around particles, with some room [px] to move; None for all.

    Windows begin between cells of the coverage, so that a wider window has the same cells.
    """
    if not len(position):
        return None
    low, high = position.min(axis=0), position.max(axis=0)
    room = max(room, _MIN_WINDOW_ROOM, float(np.max(high - low)) / 2.0)
    first = (np.clip(low - room, 0, shape) // COVERAGE_CELL * COVERAGE_CELL).astype(int)
    end = np.clip(np.ceil((high + room) / COVERAGE_CELL) * COVERAGE_CELL, 0, shape).astype(int)
    if np.prod(end - first) > _MAX_WINDOW_SHARE * np.prod(shape):
        return None
    return tuple(map(slice, first.tolist(), end.tolist()))


@dataclass(frozen=True, eq=False, repr=False)
class PlaneState(State):
    """State of a run on an image.

    Attributes
    ----------
    coverage : Coverage
        When particles were first on an edge in each cell of the scale.
    mesh : MeshForce or None
        Smooth part of the Coulomb force, used for some steps; None before the first step of a scale.
    window : tuple of slice, or None
        The pixels of the scale, around the particles, that a run in a large image is limited to, so that it takes the
        time and memory of a small one. Particles are in px of the window, as coverage and mesh. None for all.
    """

    coverage: Coverage = field(kw_only=True)
    mesh: MeshForce | None = None
    window: Window | None = None

    @classmethod
    def from_seeds(cls, seeds: Array, image: Image, scales: int, regions: AnyRegions | None) -> Self:
        """Return the state before the coarsest scale, from seeds of shape (N, 2) [px]; see `State.from_seeds`."""
        none = Particles.at_rest(seeds[:0])
        return cls(none, seeds, image.shape, scales, regions=regions, coverage=no_coverage(()))

    @property
    def corner(self) -> Integers:
        """First pixel of the window."""
        return tuple(side.start for side in self.window) if self.window else (0, 0)

    @property
    def position(self) -> Array:
        """Positions in px of the image itself, at every scale; shape (N, 2)."""
        places = self.particles.position + self.corner if self.window else self.particles.position
        return to_image(places, self.scale, self.shape)

    @property
    def placed(self) -> Array:
        """Position of each placed charge [px of the window], and its strength; shape (K, 3)."""
        return super().placed - (*self.corner, 0.0)

    def to_particle_places(self, places: Array) -> Array:
        """Return positions of the image [px], shape (M, 2), in px of the window."""
        return super().to_particle_places(places) - self.corner

    def list_arrays(self) -> list[Numbers]:
        """Return the arrays that keeping this state costs; see `State.list_arrays`."""
        mesh = () if self.mesh is None else (self.mesh.force,)
        return [*super().list_arrays(), self.coverage.found, self.coverage.latest, *mesh]

    def begin_scale(self, scale: int, places: Array) -> Self:
        """Return the first state of a scale, in a window if the image is large; see `State.begin_scale`."""
        shape = shape_at_scale(self.shape, scale)
        window = window_around(places, shape) if math.prod(self.shape) > _MIN_WINDOWED_PIXELS else None
        coverage = no_coverage(window_shape(window) if window else shape)
        begun = replace(super().begin_scale(scale, places), window=window, coverage=coverage, mesh=None)
        return replace(begun, particles=Particles.at_rest(places - begun.corner, self.next_identity))

    def widen_window(self) -> Self:
        """Return this state in a wider window if particles have come near the end of its own; else the same one."""
        if self.window is None or not self.count:
            return self
        shape, position = shape_at_scale(self.shape, self.scale), self.particles.position + self.corner
        first, last = np.transpose([(side.start, side.stop - 1) for side in self.window])
        near = (first > 0) & (position.min(axis=0) - first < _WINDOW_END_DISTANCE)
        if not (near | ((last + 1 < shape) & (last - position.max(axis=0) < _WINDOW_END_DISTANCE))).any():
            return self
        window = window_around(np.concatenate([position, [first, last]]), shape)
        moved, former = replace(self, window=window, mesh=None), self.coverage.found.shape
        before = (np.subtract(self.corner, moved.corner) / COVERAGE_CELL).astype(int)
        behind = np.subtract(no_coverage(window_shape(window) if window else shape).found.shape, former) - before
        around = np.transpose([before, behind])
        found, latest = (np.pad(steps, around, constant_values=NEVER_COVERED) for steps in self.coverage[:2])
        particles = replace(self.particles, position=position - moved.corner)
        return replace(moved, particles=particles, coverage=Coverage(found, latest, self.coverage.size))

    def reactivate_all(self) -> Self:
        """Reactivate all particles, as the coverage records when they were awake."""
        return replace(
            super().reactivate_all(), coverage=with_times_reset(self.coverage, self.step_of_scale), mesh=None
        )

    def reactivate_near(self, charges: Array) -> Self:
        """Reactivate the particles in the cells within reach of charges, shape (K, 3)."""
        reach = CHARGE_REACH * 0.5**self.scale
        coverage = with_times_reset_near(self.coverage, charges[:, :2], reach, self.step_of_scale)
        valid = self.mesh is not None and len(self.mesh.force) > 0  # else all particles may have been at rest
        return replace(self, coverage=coverage, mesh=self.mesh if valid else None)

    def erase_particles(self, gone: Mask) -> Self:
        """Erase the particles for which `gone`, shape (N,), is true, and the force of all on the mesh."""
        return replace(super().erase_particles(gone), mesh=None)
