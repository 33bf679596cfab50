"""The free particles, and the state of a run: all that the next step depends on besides image and parameters.

Here is what the plane and a volume share; `PlaneState` and `VolumeState` add what belongs to one of their laws.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Self

import numpy as np

from cpm_core.field.placed_charges import Charges, charges_at_scale
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image, to_scale
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, Extent, Index, Mask, Numbers, record
from cpm_core.parameters.formatting import format_count, format_repr

HISTORY_STEPS = 4
"""Number T of steps in eq. (23)."""


@record
class Particles:
    """Free particles as a struct of arrays.

    Attributes
    ----------
    position : ndarray, shape (N, D)
        Positions [px of their scale]; in a volume in units of the smallest side of a voxel (`VolumeState`).
    velocity : ndarray, shape (N, D)
        Velocities [px / unit of time].
    force : ndarray, shape (N, 2, D)
        Undamped force on each at the last step and at the one before: the history of eq. (15).
    distance : ndarray, shape (N, T)
        ``|r|`` at the last T steps, newest first: the history of eq. (23); NaN before the particle was inserted.
    identity : ndarray of int64, shape (N,)
        Number of each, used once only in a run.
    crept : ndarray, shape (N,)
        Distance that each, or the front that it descends from, has crept along edges since it left the area of the
        start, or in a volume the particles of the start [px].

    Examples
    --------
    >>> particles = cpm.Particles.at_rest(np.array([(4.0, 4.0), (4.0, 9.0), (9.0, 9.0)]))
    >>> particles, bool(particles.young.all())
    (<Particles 3, 2 coordinates each>, True)
    >>> particles.keep(particles.position[:, 0] < 5), particles.select(np.array([2])).position.tolist()
    (<Particles 2, 2 coordinates each>, [[9.0, 9.0]])
    >>> particles.append(cpm.Particles.at_rest(np.array([(1.0, 1.0)]), 3)).identity.tolist()
    [0, 1, 2, 3]
    """

    position: Array
    velocity: Array
    force: Array
    distance: Array
    identity: Index
    crept: Array

    @classmethod
    def at_rest(cls, position: Array, first_identity: int = 0) -> Self:
        """Make particles without motion or history at positions of shape (N, D)."""
        count, dimension = position.shape
        return cls(
            np.array(position, float),
            np.zeros((count, dimension)),
            np.zeros((count, 2, dimension)),
            np.full((count, HISTORY_STEPS), np.nan),
            np.arange(first_identity, first_identity + count),
            np.zeros(count),
        )

    def __len__(self) -> int:
        return len(self.position)

    @property
    def young(self) -> Mask:
        """Which were inserted less than T steps ago, shape (N,)."""
        return np.isnan(self.distance[:, -1])

    def keep(self, kept: Mask) -> Self:
        """Keep the particles for which `kept`, shape (N,), is true."""
        return self.select(np.flatnonzero(kept))

    def select(self, index: Index) -> Self:
        """Select the particles with the given indices, shape (M,), in this order."""
        return type(self)(*(array.take(index, axis=0) for array in vars(self).values()))

    def append(self, more: Self) -> Self:
        """Append other particles."""
        return type(self)(*map(np.concatenate, zip(vars(self).values(), vars(more).values(), strict=True)))

    def __repr__(self) -> str:
        return format_repr(type(self).__name__, f"{len(self):,}", f"{self.position.shape[1]} coordinates each")


@record
class State(ABC):
    """State of a run: complete input of the next step besides image and parameters.

    Attributes
    ----------
    particles : Particles
        The free particles, in px of their scale.
    start : ndarray, shape (M, D)
        The seeds [px of the image]; every scale begins with them as well.
    shape : tuple of int
        Shape of the image.
    scale : int
        0 is the image itself, 1 half its size, and so on.
    step : int
        Number of steps of the run.
    step_of_scale : int
        Number of steps at this scale.
    annealed : float
        Fraction of the insertion range d_max that annealing has left.
    steering : tuple
        `Parameters.steering` of the last step; empty before the first.
    regions : Regions or VolumeRegions or None
        Regions of interest and barriers of the last step.
    charges : tuple of PlacedCharge
        Placed charges of the last step.
    erased : bool
        Whether particles have been erased since all were last reactivated.
    reactivated : int
        Step of this scale at which the particles were last reactivated, by its beginning or by other parameters.
    next_identity : int
        Identity of the next particle to be inserted.
    born, deleted : int
        Particles inserted and deleted in the last step.
    epsilon : float
        Left side of eq. (23) [px of the scale]; NaN while it has no history.
    displacement : float
        Mean distance that a particle moved in the last step [px of the scale].
    moving : int
        Particles that moved by more than `equations.STILL_DISTANCE` in the last step.
    idle : int
        Consecutive steps with next to no newly covered cells at this scale.
    quiet : int
        Consecutive steps in which hardly any particle moved, was inserted or was deleted.
    reseedings : int
        Number of reseedings next to boundaries of enclosed regions at this scale.
    stop_reason : str
        Why the run ended, in words; empty while it continues.
    converged : bool
        Whether it ended at rest.

    Examples
    --------
    >>> engine = cpm.Engine(cpm.example("disk"))
    >>> state = engine.step(engine.start(cpm.circle((32, 32), 8)), cpm.Parameters())
    >>> state
    <PlaneState step 1, scale 2, 9 particles>
    >>> state.count, state.position.shape, state.placed.shape, len(state.list_arrays()) > 5
    (9, (9, 2), (0, 3), True)
    >>> bool(np.allclose(state.to_particle_places(state.position), state.particles.position))
    True
    >>> state.from_seeds(cpm.circle((32, 32), 8), cpm.example("disk"), 3, None).count
    0
    >>> state.begin_scale(1, state.position).scale, state.window, state.widen_window() is state
    (1, None, True)
    >>> state.erase_particles(state.position[:, 0] < 32).count, state.reactivate_all().reactivated
    (5, 1)
    >>> state.reactivate_near(np.array([(32.0, 50.0, 1.0)])).reactivated
    0
    >>> ended = state.stop("seen enough")
    >>> ended.stop_reason, ended.resume().stop_reason
    ('seen enough', '')
    """

    particles: Particles
    start: Array
    shape: Extent
    scale: int
    step: int = 0
    step_of_scale: int = 0
    annealed: float = 1.0
    steering: tuple[object, ...] = ()
    regions: AnyRegions | None = None
    charges: Charges = ()
    erased: bool = False
    reactivated: int = 0
    next_identity: int = 0
    born: int = 0
    deleted: int = 0
    epsilon: float = float("nan")
    displacement: float = float("nan")
    moving: int = 0
    idle: int = 0
    quiet: int = 0
    reseedings: int = 0
    stop_reason: str = ""
    converged: bool = False

    @classmethod
    def from_seeds(cls, seeds: Array, image: Image, scales: int, regions: AnyRegions | None) -> Self:
        """Return the state before the coarsest scale, without particles; seeds of shape (M, D) [px of the image]."""
        return cls(Particles.at_rest(seeds[:0]), seeds, image.shape, scales, regions=regions)

    @property
    def position(self) -> Array:
        """Positions in px of the image itself, at every scale; shape (N, D)."""
        return to_image(self.particles.position, self.scale, self.shape)

    @property
    def placed(self) -> Array:
        """Position of each placed charge, as those of particles at the scale, and its strength; shape (K, D + 1)."""
        return charges_at_scale(self.charges, self.scale, self.shape)

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.particles)

    @property
    def window(self) -> Window | None:
        """The pixels of the scale that the run is limited to; None for all, as always in a volume."""
        return None

    def to_particle_places(self, places: Array) -> Array:
        """Return positions of the image [px], shape (M, D), as those of particles: in px of the scale."""
        return to_scale(places, self.scale, self.shape)

    def list_arrays(self) -> list[Numbers]:
        """Return the arrays that keeping this state costs, without the start, which all states of a run share."""
        return list(vars(self.particles).values())

    def begin_scale(self, scale: int, places: Array) -> Self:
        """Return the first state of a scale, with particles at rest at some places of it, shape (N, D) [px]."""
        return replace(
            self,
            scale=scale,
            step_of_scale=0,
            next_identity=self.next_identity + len(places),
            annealed=1.0,
            reactivated=0,
            idle=0,
            quiet=0,
            reseedings=0,
            epsilon=float("nan"),
        )

    def widen_window(self) -> Self:
        """Return this state in a wider window if particles have come near the end of its own; else the same one."""
        return self

    def reactivate_all(self) -> Self:
        """Reactivate all particles, so that those at rest follow a change."""
        return replace(self, annealed=1.0, erased=False, reactivated=self.step_of_scale, idle=0, quiet=0, reseedings=0)

    @abstractmethod
    def reactivate_near(self, charges: Array) -> Self:
        """Reactivate the particles within reach of charges, given as in `placed`."""

    def erase_particles(self, gone: Mask) -> Self:
        """Erase the particles for which `gone`, shape (N,), is true."""
        return replace(self, particles=self.particles.keep(~gone), erased=True)

    def resume(self) -> Self:
        """Return this state as one that continues, so that other parameters can act on it, or as many steps again."""
        return replace(self, stop_reason="", converged=False, quiet=0, reactivated=self.step_of_scale)

    def stop(self, reason: str, converged: bool = False) -> Self:
        """Return this state as the last one of its run."""
        return replace(self, stop_reason=reason, converged=converged)

    def __repr__(self) -> str:
        particles = format_count(self.count, "particle")
        return format_repr(
            type(self).__name__,
            f"step {self.step}",
            f"scale {self.scale}",
            particles,
            self.stop_reason.partition(":")[0],
        )
