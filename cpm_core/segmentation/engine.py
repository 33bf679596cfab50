"""The engine: one step of a run is the composition of motion, deletion, insertion and equilibrium.

``Engine(image, parameters)`` prepares what the particles feel; ``start`` makes the first state of a run; ``step`` makes
the next one from any state, without memory of its own, so that a run can be paused, steered, replayed and branched.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
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
from cpm_core.field.image_fields import ImageFields
from cpm_core.field.placed_charges import PlacedCharge, in_order
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import PARAMETERS, Parameters
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.starting_points import starting_points
from cpm_core.particles.state import Particles, State
from cpm_core.reconstruction import find_contours
from cpm_core.segmentation import interventions
from cpm_core.segmentation.completion import idle_steps_of
from cpm_core.segmentation.scale_schedule import advance, start_scale


def reconstruction(state: State, image: Image, scale_field: ScaleField, parameters: Parameters) -> Result:
    """Contours through the particles of a state, from the fields of its scale, in px of the image."""
    scale, shape, size = state.scale, image.shape, 2.0**state.scale
    # an edge without particles may have been cleared by the user, and is then not walked along
    filled = state.converged and not state.charges and not state.erased
    found, bridged = find_contours(state.particles.position, scale_field, parameters, at_rest=filled)
    contours = tuple(replace(c, points=to_image(c.points, scale, shape), strength=c.strength / size) for c in found)
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
    )


class Engine(ImageFields):
    """The charged-particle model on one image: a `Method` whose states are `State`.

    It is made of image, parameters and regions as `ImageFields` is, which says what they are and which are refused.
    """

    name: ClassVar[str] = "cpm"
    title: ClassVar[str] = "Charged particles"
    parameters: ClassVar[tuple[str, ...]] = tuple(PARAMETERS)
    seeded: ClassVar[bool] = True

    @staticmethod
    def steering(parameters: Parameters) -> tuple[object, ...]:
        """Values that a step obeys; see `Method.steering`."""
        return parameters.steering

    def start(self, seeds: ArrayLike) -> State:
        """First state of a run.

        Parameters
        ----------
        seeds : array_like, shape (N, 2)
            Where the particles begin (row, col) [px]; those outside the image or the regions of interest, and those on
            a barrier, are left out.

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
        begun = State(none, points, self.image.shape, self.scales, no_coverage(()), regions=self.regions)
        return start_scale(begun, self.scales - 1, self.regions)

    def step(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> State:
        """One time step.

        Parameters
        ----------
        state : State
            Any state of a run on this image.
        parameters : Parameters
            Obeyed at once, `scales` from the next start on. Other values than in the last step set particles that have
            come to rest going again.
        charges : sequence of PlacedCharge, optional
            Obeyed at once. One that comes, goes or is moved sets those particles going again that it is or was felt by;
            a run that has ended goes on for it once it is `State.resumed`.

        Returns
        -------
        State
            The next state: the same one if the run has stopped. A state of an engine with other regions goes on with
            the particles that lie in this one's.
        """
        if state.stop_reason:
            return state
        state = interventions.taken_up(state, self.regions, parameters, charges)
        scale_field = self._charged_field(parameters, state.scale, state.charges)
        idle = idle_steps_of(state, scale_field, parameters)
        repulsion_gone = not (idle < FADED).any()
        state, moved = displaced(state, idle, scale_field, parameters)
        if len(state.particles):
            state = self._populate(state, moved, repulsion_gone, scale_field, parameters)
        return advance(state, scale_field, self.regions)

    def forces(
        self,
        state: State,
        parameters: Parameters,
        charges: Sequence[PlacedCharge] = (),
        index: ArrayLike | None = None,
    ) -> Forces:
        """Forces on the particles of a state: those with which a step from it begins.

        Parameters
        ----------
        state : State
            A state of a run on this image, at rest or not.
        parameters : Parameters
            Of the step.
        charges : sequence of PlacedCharge, optional
            Of the step.
        index : array_like of int, optional
            Which of the particles are asked about, in the order of `state.position`; by default all of them.

        Returns
        -------
        Forces
            In the order asked for; NaN for particles that the step takes away, since they lie outside new regions. As
            exactly as a step reckons them: pairs in single precision (2e-4 of a force of unit size), and what comes
            from afar by a mesh, which serves for four steps (`mesh_force` tells what that leaves out). A step carries
            the force on by its change in the last two steps, eq. (15), and integrates the damping exactly; friction
            also takes the speed along the edge at once. None of this is a force.
        """
        asked = np.arange(state.count) if index is None else np.atleast_1d(np.asarray(index, dtype=np.int64))
        taken_up = interventions.taken_up(state, self.regions, parameters, charges)
        scale_field = self.scale_field(parameters, state.scale)
        charged = self._charged_field(parameters, state.scale, taken_up.charges)
        idle = idle_steps_of(taken_up, charged, parameters)
        place = _places(state.particles.identity, taken_up.particles.identity)[asked]
        there = place >= 0
        found = forces(taken_up, scale_field, charged, idle, parameters, place[there])
        return found if there.all() else Forces(*(_spread(getattr(found, f.name), there) for f in fields(Forces)))

    def energies(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Energies:
        """Kinetic and potential energy of the particles of a state, as `cpm_core.dynamics.energies` defines them.

        The potential of the fixed charges is made when it is first asked for at a scale, and kept as long as the field.
        """
        placed = replace(state, charges=in_order(charges))
        return energies(placed, self.scale_field(parameters, state.scale), parameters)

    def joined(self, state: State, seeds: ArrayLike) -> State:
        """Put more particles into a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        seeds : array_like, shape (M, 2)
            Where the new particles begin (row, col) [px]; those outside the image or the regions of interest, and those
            on a barrier, are left out.

        Returns
        -------
        State
            With the new particles at rest, at the same scale; they are remembered for the finer scales. All particles
            are set going again, and a run that has ended goes on.

        Raises
        ------
        ValueError
            When there is no new particle, or none inside the image and the regions of interest.
        """
        return interventions.joined(state, seeds, self.regions)

    def erased(self, state: State, inside: interventions.Chosen) -> State:
        """Take particles out of a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        inside : ndarray of bool, shape (N,), or callable
            Which particles, or what tells so of positions, shape (M, 2) [px of the image]. It is then asked of the
            places where the particles began as well, so that a finer scale does not begin there again.

        Returns
        -------
        State
            With the others, which are not woken by it: where none of them moves nothing grows anew, and a run that has
            ended stays so. Where none is left the run ends.

        Raises
        ------
        ValueError
            When `inside` is not one truth value for each particle.
        """
        return interventions.erased(state, inside)

    def result(self, state: State, parameters: Parameters) -> Result:
        """Contours and figures of any state of a run.

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
        return reconstruction(state, self.image, self.scale_field(parameters, state.scale), parameters)

    def measures(self, state: State, parameters: Parameters, thorough: bool = False) -> Mapping[str, float]:
        """Figures of a state by name, the potential energy only if `thorough`; see `Method.measures`."""
        figures = {name: float(getattr(state, attribute)) for name, attribute in _FIGURES.items()}
        figures["kinetic"] = kinetic_energy(state)
        slow = {"potential": self.energies(state, parameters, state.charges).potential} if thorough else {}
        return figures | slow

    def positions(self, state: State) -> Array:
        """Where the particles are, shape (N, 2) [px of the image]."""
        return state.position

    def _populate(
        self, state: State, moved: Moved, repulsion_gone: bool, scale_field: ScaleField, parameters: Parameters
    ) -> State:
        """Population of a step, by itself for the experiments that do without."""
        return populated(state, moved, repulsion_gone, scale_field, parameters)


_FIGURES = {name: name for name in ("epsilon", "count", "born", "deleted", "scale")} | {"numbered": "next_identity"}
"""Figures by name, and what of a state they are."""


def _places(before: Index, after: Index) -> Index:
    """For each identity before the index of the same one after, -1 where it is gone; those after keep their order."""
    stays = np.isin(before, after)
    return np.where(stays, np.cumsum(stays) - 1, -1)


def _spread(rows: Array, there: NDArray[np.bool_]) -> Array:
    """Rows, shape (K, 2), put where `there`, shape (M,), is true; NaN elsewhere."""
    spread = np.full((len(there), 2), np.nan)
    spread[there] = rows
    return spread
