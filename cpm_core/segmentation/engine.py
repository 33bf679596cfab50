"""The engine: one step of a run is the composition of motion, deletion, insertion and equilibrium.

``Engine(image, parameters)`` prepares the fields; ``start`` makes the first state of a run; ``step`` makes the next one
from any state, without memory of its own, so that a run can be paused, changed, replayed and branched.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.contours.contour import Bridge
from cpm_core.contours.result import Result
from cpm_core.dynamics.energies import Energies, energies, kinetic_energy
from cpm_core.dynamics.equations import FADED
from cpm_core.dynamics.forces import Forces, forces
from cpm_core.dynamics.integrator import Moved
from cpm_core.dynamics.time_step import displaced, populated
from cpm_core.field.placed_charges import PlacedCharge, in_order
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import OF_SKELETONS, PARAMETERS, Parameters
from cpm_core.parameters.choices import CHOICES
from cpm_core.parameters.provenance import Provenance, taken
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.initialization import starting_points
from cpm_core.particles.state import Particles, State
from cpm_core.reconstruction import find_contours
from cpm_core.segmentation import interventions
from cpm_core.segmentation.completion import idle_steps_of
from cpm_core.segmentation.reach.reach_map import ReachMap
from cpm_core.segmentation.reach.run_fields import RunFields
from cpm_core.segmentation.scale_schedule import advance, start_scale


def reconstruction(
    state: State, image: Image, scale_field: ScaleField, parameters: Parameters, reached: ReachMap | None = None
) -> Result:
    """Contours through the particles of a state, from the fields of its scale, in px of the image."""
    scale, shape, size = state.scale, image.shape, 2.0**state.scale
    # an edge without particles may have been cleared by the user; it is then not traced
    filled = state.converged and not state.charges and not state.erased
    found, bridged = find_contours(state.particles.position, scale_field, parameters, at_rest=filled)
    contours = tuple(replace(c, points=to_image(c.points, scale, shape), strength=c.strength / size) for c in found)
    if reached is not None:
        contours = tuple(replace(c, reached=reached.way_of(c.points)) for c in contours)
    bridges = tuple(Bridge(to_image(b.points, scale, shape), b.length * size, b.strength / size) for b in bridged)
    return Result(
        particles=state.position,
        contours=contours,
        surface=None,
        steps=state.step,
        converged=state.converged,
        stop_reason=state.stop_reason,
        shape=shape,
        spacing=image.spacing,
        unit=image.unit,
        source=image.source,
        bridges=bridges,
        image=image,
        regions=state.regions,
        channel=image.channel(parameters.channel),
        provenance=Provenance(
            "cpm",
            taken(parameters, Engine.parameters),
            len(state.start),
            tuple({"shape": "charge", **asdict(charge)} for charge in state.charges),
            scale,
            sha256=image.sha256,
            of_file=bool(image.file_sha256),
        ),
    )


class Engine(RunFields):
    """The charged-particle model on one image: a `Method` whose states are `State`.

    `ImageFields` describes image, parameters and regions and the errors that they raise.
    """

    name: ClassVar[str] = "cpm"
    title: ClassVar[str] = "Charged particles"
    parameters: ClassVar[tuple[str, ...]] = tuple(name for name in (*PARAMETERS, *CHOICES) if name not in OF_SKELETONS)
    seeded: ClassVar[bool] = True

    @staticmethod
    def steering(parameters: Parameters) -> tuple[object, ...]:
        """Values that a step depends on; see `Method.steering`."""
        return parameters.steering

    def start(self, seeds: ArrayLike) -> State:
        """First state of a run.

        Parameters
        ----------
        seeds : array_like, shape (N, 2)
            Positions (row, col) [px]; those outside the image or the regions of interest, and those on a barrier, are
            left out.

        Returns
        -------
        State
            Particles at rest on the coarsest scale.

        Raises
        ------
        ValueError
            When there is no particle, or none inside the image and the regions of interest.
        """
        points = starting_points(seeds, self.image.shape, self.regions)
        none = Particles.at_rest(points[:0])
        first = State(none, points, self.image.shape, self.scales, no_coverage(()), regions=self.regions)
        return start_scale(first, self.scales - 1, self.regions)

    def step(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> State:
        """One time step.

        Parameters
        ----------
        state : State
            Any state of a run on this image.
        parameters : Parameters
            Effective at once, `scales` from the next start. Values that differ from the last step's reactivate all
            particles.
        charges : sequence of PlacedCharge, optional
            Effective at once. One that is added, removed or moved reactivates the particles within its old and new
            reach; a run that has ended continues once its state is `State.resumed`.

        Returns
        -------
        State
            The next state: the same one if the run has stopped. A state of an engine with other regions continues with
            the particles inside the regions of this one.
        """
        if state.stop_reason:
            return state
        state = interventions.applied(state, self.regions, parameters, charges)
        scale_field = self._charged.of(self._field_of(state, parameters), state.scale, state.charges)
        idle = idle_steps_of(state, scale_field, parameters)
        repulsion_gone = not (idle < FADED).any()
        state, moved = displaced(state, idle, scale_field, parameters)
        if len(state.particles):
            state = self._populate(state, moved, repulsion_gone, scale_field, parameters)
        return advance(state, scale_field, self.regions, parameters)

    def forces(
        self,
        state: State,
        parameters: Parameters,
        charges: Sequence[PlacedCharge] = (),
        index: ArrayLike | None = None,
    ) -> Forces:
        """Forces on the particles of a state, with which a step from it begins.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        parameters : Parameters
            Of the step.
        charges : sequence of PlacedCharge, optional
            Of the step.
        index : array_like of int, optional
            Indices of particles in the order of `state.position`; by default all.

        Returns
        -------
        Forces
            In the order of `index`; NaN for particles that the step removes because they lie outside new regions. As
            exact as in a step: near pairs in single precision (2e-4 of a unit force), distant particles by a mesh that
            is used for four steps (see `mesh_force`). A step also extrapolates the force, eq. (15), integrates the
            damping exactly and applies friction along the edge at once; these are not forces.
        """
        asked = np.arange(state.count) if index is None else np.atleast_1d(np.asarray(index, dtype=np.int64))
        changed = interventions.applied(state, self.regions, parameters, charges)
        scale_field = self._field_of(state, parameters)
        charged = self._charged.of(scale_field, state.scale, changed.charges)
        idle = idle_steps_of(changed, charged, parameters)
        row = _places(state.particles.identity, changed.particles.identity)[asked]
        there = row >= 0
        found = forces(changed, scale_field, charged, idle, parameters, row[there])
        return found if there.all() else Forces(*(_spread(getattr(found, f.name), there) for f in fields(Forces)))

    def energies(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Energies:
        """Kinetic and potential energy of the particles of a state, as `cpm_core.dynamics.energies` defines them.

        The potential of the fixed charges is computed at the first call for a scale and cached with the field.
        """
        placed = replace(state, charges=in_order(charges))
        return energies(placed, self._field_of(state, parameters), parameters)

    def joined(self, state: State, seeds: ArrayLike) -> State:
        """Add particles to a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        seeds : array_like, shape (M, 2)
            Positions of the new particles (row, col) [px]; left out as in `start`.

        Returns
        -------
        State
            With the new particles at rest, at the same scale; finer scales begin with them as well. All particles are
            reactivated, and a run that has ended continues.

        Raises
        ------
        ValueError
            When there is no new particle, or none inside the image and the regions of interest.
        """
        return interventions.joined(state, seeds, self.regions)

    def erased(self, state: State, inside: interventions.Chosen) -> State:
        """Remove particles from a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        inside : ndarray of bool, shape (N,), or callable
            Which particles, or a function of positions, shape (M, 2) [px of the image]. The function is applied to the
            seeds as well, so that a finer scale does not begin there again.

        Returns
        -------
        State
            With the other particles, which are not reactivated: no particles are inserted beside those at rest, and a
            run that has ended stays so. Without any particle left the run ends.

        Raises
        ------
        ValueError
            When `inside` is not one truth value for each particle.
        """
        return interventions.erased(state, inside)

    def result(self, state: State, parameters: Parameters) -> Result:
        """Contours and metrics of any state of a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        parameters : Parameters
            For the reconstruction.

        Returns
        -------
        Result
            In px of the image.
        """
        reached = self.reach_map(state.start, parameters)
        return reconstruction(state, self.image, self._field_of(state, parameters), parameters, reached)

    def measures(self, state: State, parameters: Parameters, thorough: bool = False) -> Mapping[str, float]:
        """Metrics of a state by name, the potential energy only if `thorough`; see `Method.measures`."""
        metrics = {name: float(getattr(state, attribute)) for name, attribute in _METRICS.items()}
        metrics["kinetic"] = kinetic_energy(state)
        slow = {"potential": self.energies(state, parameters, state.charges).potential} if thorough else {}
        return metrics | slow

    def positions(self, state: State) -> Array:
        """Positions of the particles, shape (N, 2) [px of the image]."""
        return state.position

    def _populate(
        self, state: State, moved: Moved, repulsion_gone: bool, scale_field: ScaleField, parameters: Parameters
    ) -> State:
        """Insertion and deletion of a step; a method of its own so that experiments can replace it."""
        return populated(state, moved, repulsion_gone, scale_field, parameters)


_METRICS = {name: name for name in ("epsilon", "count", "born", "deleted", "scale")} | {"numbered": "next_identity"}
"""Metrics by name -> attributes of a state."""


def _places(before: Index, after: Index) -> Index:
    """For each earlier identity its index among the later ones, which keep their order; -1 where it is gone."""
    stays = np.isin(before, after)
    return np.where(stays, np.cumsum(stays) - 1, -1)


def _spread(rows: Array, there: NDArray[np.bool_]) -> Array:
    """Rows, shape (K, 2), at the positions where `there`, shape (M,), is true; NaN elsewhere."""
    spread = np.full((len(there), 2), np.nan)
    spread[there] = rows
    return spread
