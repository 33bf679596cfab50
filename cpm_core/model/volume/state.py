"""The particles and the state of a run in a volume."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from cpm_core.field.placed_charges import charge_radius_at, near_charges
from cpm_core.field.volume_field import pitch_of
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.coverage import SurfaceCoverage, no_surface_coverage
from cpm_core.model.state import Particles, State
from cpm_core.numerics.types import Array, Index, Mask, Numbers
from cpm_core.numerics.vectors import Vector


@dataclass(frozen=True, eq=False, repr=False)
class VolumeParticles(Particles):
    """Free particles in a volume, and the surface at each.

    Attributes
    ----------
    normal : ndarray, shape (N, 3)
        Direction in which the smoothed volume rises at each.
    on_surface : ndarray of bool, shape (N,)
        Whether each lies on the ridge of an edge that is strong enough.
    strength : ndarray, shape (N,)
        Edge strength at each.
    reactivated_at : ndarray of int64, shape (N,)
        Step of the scale at which something new was last covered near each.
    """

    normal: Array
    on_surface: Mask
    strength: Array
    reactivated_at: Index

    @classmethod
    def at_rest(cls, position: Array, first_identity: int = 0) -> Self:
        """Make particles without motion or history off all surfaces, at positions of shape (N, 3)."""
        count = len(position)
        return cls(
            **vars(Particles.at_rest(position, first_identity)),
            normal=np.zeros((count, 3)),
            on_surface=np.zeros(count, bool),
            strength=np.zeros(count),
            reactivated_at=np.zeros(count, np.int64),
        )

    @classmethod
    def at_rest_on_surfaces(
        cls, position: Array, first_identity: int, normal: Array, strength: Array, crept: Array, reactivated_at: Index
    ) -> Self:
        """Make particles without motion or history on surfaces, at positions of shape (N, 3)."""
        on_surface = np.ones(len(position), bool)
        return cls(
            **(vars(Particles.at_rest(position, first_identity)) | {"crept": crept}),
            normal=normal,
            on_surface=on_surface,
            strength=strength,
            reactivated_at=reactivated_at,
        )

    def reactivate(self, which: Mask, step: int) -> Self:
        """Return the particles, those of a mask, shape (N,), reactivated at a step of the scale."""
        return replace(self, reactivated_at=np.where(which, step, self.reactivated_at))


@dataclass(frozen=True, eq=False, repr=False)
class VolumeState(State):
    """State of a run in a volume.

    Attributes
    ----------
    particles : VolumeParticles
        The free particles, in units of the smallest side of a voxel of their scale.
    pitch : tuple of float
        Sides of a voxel, in units of the smallest one, in which the particles are measured.
    coverage : SurfaceCoverage
        Where surfaces have been found at the scale.
    """

    particles: VolumeParticles
    pitch: Vector = field(kw_only=True)
    coverage: SurfaceCoverage = field(kw_only=True)

    @classmethod
    def from_seeds(cls, seeds: Array, image: Image, scales: int, regions: AnyRegions | None) -> Self:
        """Return the state before the coarsest scale, from seeds of shape (N, 3) [voxels]; see `State.from_seeds`."""
        none, pitch = VolumeParticles.at_rest(seeds[:0]), pitch_of(image.spacing)
        return cls(none, seeds, image.shape, scales, regions=regions, pitch=pitch, coverage=no_surface_coverage())

    @property
    def position(self) -> Array:
        """Positions in voxels of the volume itself, at every scale; shape (N, 3)."""
        return to_image(self.particles.position / self.pitch, self.scale, self.shape)

    @property
    def placed(self) -> Array:
        """Position of each placed charge [units of the scale], and its strength; shape (K, 4)."""
        return super().placed * (*self.pitch, 1.0)

    def to_particle_places(self, places: Array) -> Array:
        """Return positions of the volume [voxels], shape (M, 3), in units of the scale."""
        return super().to_particle_places(places) * self.pitch

    def list_arrays(self) -> list[Numbers]:
        """Return the arrays that keeping this state costs; see `State.list_arrays`."""
        return [*super().list_arrays(), self.coverage.cells]

    def begin_scale(self, scale: int, places: Array) -> Self:
        """Return the first state of a scale; see `State.begin_scale`."""
        particles = VolumeParticles.at_rest(places * self.pitch, self.next_identity)
        return replace(super().begin_scale(scale, places), particles=particles, coverage=no_surface_coverage())

    def reactivate_all(self) -> Self:
        """Reactivate all particles, so that those at rest follow a change."""
        everywhere = np.ones(self.count, bool)
        particles = self.particles.reactivate(everywhere, self.step_of_scale)
        return replace(super().reactivate_all(), particles=particles, coverage=no_surface_coverage())

    def reactivate_near(self, charges: Array) -> Self:
        """Reactivate the particles within reach of charges, shape (K, 4)."""
        near = near_charges(charges, charge_radius_at(self.scale), self.particles.position)
        return replace(self, particles=self.particles.reactivate(near, self.step_of_scale), idle=0, reseedings=0)
