"""The free particles, and the state of a run: all that the next step depends on besides image and parameters."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from cpm_core.field.placed_charges import Charges, charges_at_scale
from cpm_core.image.pyramid import to_image, to_scale
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.coverage import Coverage, SurfaceCoverage
from cpm_core.numerics.grids import Window
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Extent, Index, Integers, JsonDict, Mask, Numbers, Single, record
from cpm_core.numerics.vectors import Vector
from cpm_core.parameters.formatting import format_count, format_repr

MESH_INTERVAL = 4
"""Steps for which the force on a mesh is used: during these, particles move by a small part of its reach."""


class MeshForce(NamedTuple):
    r"""Smooth part of the Coulomb force on the nodes of a mesh; a plain tuple for the compiled loops.

    Attributes
    ----------
    force : ndarray of float32, shape (\*nodes, D)
        The force; no nodes when the whole force is summed over pairs.
    first : tuple of float
        Position of the first node [px].
    pitch : float
        Distance of the nodes [px].
    reach : float
        Distance R up to which pairs add what the mesh leaves out [px]; infinite when there is no mesh.
    softening : ndarray of float32, shape (3,)
        Coefficients of the polynomial that replaces the inverse square up to R, by powers of the squared distance; zero
        when there is no mesh.
    """

    force: Single
    first: tuple[float, ...]
    pitch: float
    reach: float
    softening: Single


@record
class SurfaceContact:
    """Contact of particles with surfaces.

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
    def off_surfaces(cls, count: int) -> SurfaceContact:
        """Return the contact of `count` particles that are on no surface, awake since the first step."""
        return cls(np.zeros((count, 3)), np.zeros(count, bool), np.zeros(count), np.zeros(count, np.int64))

    @classmethod
    def from_surface(cls, normal: Array, strength: Array, step: int) -> SurfaceContact:
        """Return the contact of particles on surfaces, awake since a step; normals (N, 3), edge strengths (N,)."""
        count = len(normal)
        return cls(normal, np.ones(count, bool), strength, np.full(count, step))

    def select(self, index: Index) -> SurfaceContact:
        """Select the contact of the particles with the given indices, shape (M,), in this order."""
        return SurfaceContact(*(getattr(self, f.name)[index] for f in fields(self)))

    def append(self, other: SurfaceContact) -> SurfaceContact:
        """Append the contact of other particles."""
        pairs = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return SurfaceContact(*map(np.concatenate, pairs))

    def reactivate(self, step: int, which: Mask | None = None) -> SurfaceContact:
        """Return the contact with particles reactivated at a step: all, or those of a mask, shape (N,)."""
        if which is None:
            return replace(self, reactivated_at=np.full_like(self.reactivated_at, step))
        return replace(self, reactivated_at=np.where(which, step, self.reactivated_at))


HISTORY_STEPS = 4
"""Number T of steps in eq. (23)."""


_PARTICLE_ARRAYS = ("position", "velocity", "force", "distance", "identity")
"""Names of the arrays of particles."""

_NO_NEW_POSITIONS = np.empty((0, 2))
"""Positions of no new particles."""

_NO_NEW_PARENTS = np.empty((0, 2), np.int64)
"""Parents of no new particles."""


@record
class Particles:
    """Free particles as a struct of arrays.

    Attributes
    ----------
    position : ndarray, shape (N, D)
        Positions [px of their scale]; in a volume in units of the smallest side of a voxel (`SpaceState`).
    velocity : ndarray, shape (N, D)
        Velocities [px / unit of time].
    force : ndarray, shape (N, 2, D)
        Undamped force on each at the last step and at the one before: the history of eq. (15).
    distance : ndarray, shape (N, T)
        ``|r|`` at the last T steps, newest first: the history of eq. (23); NaN before the particle was inserted.
    identity : ndarray of int64, shape (N,)
        Number of each, used once only in a run.
    contact : SurfaceContact or None
        Contact of each with surfaces, in a volume; None in the plane.

    Examples
    --------
    >>> particles = cpm.Particles.at_rest(np.array([(4.0, 4.0), (4.0, 9.0), (9.0, 9.0)]))
    >>> particles, bool(particles.young.all())
    (<Particles 3, 2 coordinates each>, True)
    >>> particles.where(particles.position[:, 0] < 5), particles.taken(np.array([2])).position.tolist()
    (<Particles 2, 2 coordinates each>, [[9.0, 9.0]])
    >>> particles.with_more(np.array([(1.0, 1.0)]), 3).identity.tolist()
    [0, 1, 2, 3]
    >>> particles.renewed(np.array([2]), np.array([(4.0, 6.5)]), np.array([(0, 1)]), 3).position.tolist()
    [[9.0, 9.0], [4.0, 6.5]]
    >>> ball, start = cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60)
    >>> cpm.Engine(ball).start(start).particles.on_surface.normal.shape
    (60, 3)
    >>> particles.woken_at(5) is particles  # in the plane the coverage knows which are awake
    True
    """

    position: Array
    velocity: Array
    force: Array
    distance: Array
    identity: Index
    contact: SurfaceContact | None = None

    @classmethod
    def at_rest(cls, position: Array, first_identity: int = 0) -> Particles:
        """Make particles without motion or history at positions of shape (N, D)."""
        count, dimension = position.shape
        return cls(
            np.array(position, float),
            np.zeros((count, dimension)),
            np.zeros((count, 2, dimension)),
            np.full((count, HISTORY_STEPS), np.nan),
            np.arange(first_identity, first_identity + count),
            SurfaceContact.off_surfaces(count) if dimension == 3 else None,
        )

    def __len__(self) -> int:
        return len(self.position)

    @property
    def young(self) -> Mask:
        """Which were inserted less than T steps ago, shape (N,)."""
        return np.isnan(self.distance[:, -1])

    @property
    def surface_contact(self) -> SurfaceContact:
        """Contact of each with surfaces, of particles in a volume."""
        assert self.contact is not None
        return self.contact

    def keep(self, kept: Mask) -> Particles:
        """Keep the particles for which `kept`, shape (N,), is true."""
        return self.select(np.flatnonzero(kept))

    def select(self, index: Index) -> Particles:
        """Select the particles with the given indices, shape (M,), in this order."""
        arrays: JsonDict = {name: getattr(self, name).take(index, axis=0) for name in _PARTICLE_ARRAYS}
        return Particles(**arrays, contact=self.contact and self.contact.select(index))

    def reactivate(self, step: int, which: Mask | None = None) -> Particles:
        """Return the particles reactivated at a step, all or those of a mask, shape (N,).

        In the plane they are returned unchanged: there the coverage records this.
        """
        return self if self.contact is None else replace(self, contact=self.contact.reactivate(step, which))

    def append(self, position: Array, first: int, contact: SurfaceContact | None = None) -> Particles:
        """Append particles without motion or history at positions, shape (M, D), numbered from `first`.

        In a volume they may have contact with surfaces.
        """
        more = Particles.at_rest(position, first)
        arrays: JsonDict = {
            name: np.concatenate([getattr(self, name), getattr(more, name)]) for name in _PARTICLE_ARRAYS
        }
        met = contact or more.contact
        return Particles(**arrays, contact=self.contact and met and self.contact.append(met))

    def replace_particles(
        self, stay: Index, position: Array = _NO_NEW_POSITIONS, parents: Index = _NO_NEW_PARENTS, first: int = 0
    ) -> Particles:
        """Replace the particles by those with the indices `stay` and new ones at positions, shape (M, 2).

        New ones have the mean velocity and force history of their two parents; `parents`, shape (M, 2), are the indices
        of the parents, the same twice for a single one; `first` is the identity of the first new particle.
        """
        before = self.position, self.velocity, self.force, self.distance, self.identity
        count = len(stay) + len(position)
        after: Any = [np.empty((count, *array.shape[1:]), array.dtype) for array in before]
        _write_replaced(before, stay, position, parents, first, tuple(after))
        return Particles(*after)

    def __repr__(self) -> str:
        return format_repr("Particles", f"{len(self):,}", f"{self.position.shape[1]} coordinates each")


@compiled
def _write_replaced(
    before: tuple[Array, Array, Array, Array, Index],
    stay: Index,
    position: Array,
    parents: Index,
    first: int,
    after: tuple[Array, Array, Array, Array, Index],
) -> None:
    """Write the arrays of `Particles.replace_particles`."""
    place, velocity, force, distance, identity = before
    to_place, to_velocity, to_force, to_distance, to_identity = after
    for n in range(len(to_place)):
        born = n - len(stay)
        i, j = (stay[n], stay[n]) if born < 0 else (parents[born, 0], parents[born, 1])
        for axis in range(2):
            to_place[n, axis] = place[i, axis] if born < 0 else position[born, axis]
            to_velocity[n, axis] = 0.5 * (velocity[i, axis] + velocity[j, axis])
            for t in range(2):
                to_force[n, t, axis] = 0.5 * (force[i, t, axis] + force[j, t, axis])
        for t in range(HISTORY_STEPS):
            to_distance[n, t] = distance[i, t] if born < 0 else np.nan
        to_identity[n] = identity[i] if born < 0 else first + born


@record
class SpaceState:
    """Part of a state that exists in a volume only.

    Attributes
    ----------
    pitch : tuple of float
        Sides of a voxel, in units of the smallest one, in which the particles are measured.
    covered : SurfaceCoverage
        Where surfaces have been found at the scale.
    """

    pitch: Vector
    covered: SurfaceCoverage


@record
class State:
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
    coverage : Coverage
        When particles were first on an edge in each cell of the scale.
    mesh : MeshForce or None
        Smooth part of the Coulomb force, used for some steps; None before the first step of a scale.
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
        Particles that moved by more than `equilibrium.STILL` in the last step.
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
    space : SpaceState or None
        Part of the state that belongs to a volume; None in the plane.
    window : tuple of slice, or None
        The pixels of the scale, around the particles, that a run in a large image is limited to, so that it takes the
        time and memory of a small one. Particles are in px of the window, as coverage and mesh. None for all.

    Examples
    --------
    >>> engine = cpm.Engine(cpm.example("disk"))
    >>> state = engine.step(engine.start(cpm.circle((32, 32), 8)), cpm.Parameters())
    >>> state
    <State step 1, scale 2, 9 particles>
    >>> state.count, state.position.shape, state.placed.shape, state.corner, len(state.arrays()) > 5
    (9, (9, 2), (0, 3), (0, 0), True)
    >>> state.at_scale(np.array([[32.0, 32.0]]), 1).tolist()
    [[15.75, 15.75]]
    >>> ended = state.stopped("seen enough")
    >>> ended.stop_reason, ended.resumed().stop_reason
    ('seen enough', '')
    """

    particles: Particles
    start: Array
    shape: Extent
    scale: int
    coverage: Coverage
    mesh: MeshForce | None = None
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
    space: SpaceState | None = None
    window: Window | None = None

    @property
    def corner(self) -> Integers:
        """First pixel of the window."""
        return tuple(side.start for side in self.window) if self.window else (0,) * len(self.shape)

    @property
    def position(self) -> Array:
        """Positions in px of the image itself, at every scale; shape (N, D)."""
        places = self.particles.position + self.corner if self.window else self.particles.position
        return to_image(places if self.space is None else places / self.space.pitch, self.scale, self.shape)

    def at_scale(self, places: Array, scale: int) -> Array:
        """Return positions of the image [px], shape (M, D), as those of particles at a scale."""
        found = to_scale(places, scale, self.shape)
        return found if self.space is None else found * self.space.pitch

    @property
    def placed(self) -> Array:
        """Position of each placed charge, as those of particles at the scale, and its strength; shape (K, D + 1)."""
        placed = charges_at_scale(self.charges, self.scale, self.shape) - (*self.corner, 0.0)
        return placed if self.space is None else placed * (*self.space.pitch, 1.0)

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.particles)

    def list_arrays(self) -> list[Numbers]:
        """Return the arrays that keeping this state costs, without the start, which all states of a run share."""
        particles, mesh, contact = self.particles, self.mesh, self.particles.contact
        return [
            *(getattr(particles, name) for name in _PARTICLE_ARRAYS),
            *self.coverage[:2],
            *(() if mesh is None else (mesh.force,)),
            *(() if self.space is None else (self.space.covered.cells,)),
            *(() if contact is None else (getattr(contact, f.name) for f in fields(contact))),
        ]

    def resume(self) -> State:
        """Return this state as one that continues, so that other parameters can act on it."""
        return replace(self, stop_reason="", converged=False, quiet=0)

    def stop(self, reason: str, converged: bool = False) -> State:
        """Return this state as the last one of its run."""
        return replace(self, stop_reason=reason, converged=converged)

    def __repr__(self) -> str:
        particles = format_count(self.count, "particle")
        return format_repr(
            "State", f"step {self.step}", f"scale {self.scale}", particles, self.stop_reason.partition(":")[0]
        )
