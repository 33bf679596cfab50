"""The engine: one step of a run is the composition of motion, deletion, insertion and equilibrium.

``Engine(image, parameters)`` prepares what the particles feel; ``start`` makes the first state of a run; ``step`` makes
the next one from any state, without memory of its own, so that a run can be paused, steered, replayed and branched.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Bridge
from cpm_core.contours.result import Result
from cpm_core.dynamics.energies import Energies, energies
from cpm_core.dynamics.equations import FADED
from cpm_core.dynamics.forces import Forces, forces
from cpm_core.dynamics.integrator import Moved
from cpm_core.dynamics.time_step import displaced, populated
from cpm_core.field.placed_charge_cache import PlacedChargeCache, charged_force, charged_potential
from cpm_core.field.placed_charges import PlacedCharge, at_scale, in_order
from cpm_core.field.scale_field import ScaleField
from cpm_core.field.scale_space import ScaleSpace
from cpm_core.image.image import Image, as_plane
from cpm_core.image.pyramid import to_image
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.starting_points import starting_points
from cpm_core.particles.state import Particles, State
from cpm_core.reconstruction import find_contours
from cpm_core.segmentation import interventions
from cpm_core.segmentation.completion import idle_steps_of
from cpm_core.segmentation.scale_schedule import advance, start_scale


class Engine:
    """The charged-particle model on one image.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image.
    parameters : Parameters, optional
        For the number of scales, and the fields to prepare at once.
    regions : Regions, optional
        Regions of interest, which particles stay in, and barriers, which they do not cross; the whole image by default.

    Raises
    ------
    ValueError
        When the image has no edges in the regions of interest, or fewer scales than asked for.
    """

    def __init__(
        self, values: ArrayLike | Image, parameters: Parameters | None = None, regions: Regions | None = None
    ) -> None:
        parameters = parameters or Parameters()
        self.image = as_plane(values)
        array = self.image.values
        if array.min() == array.max():
            raise ValueError(
                f"{self.image.source} is constant ({array.flat[0]:g} everywhere) and has no edges: "
                "open an image that shows something."
            )
        self.regions = regions
        if regions is not None:
            regions.check(array.shape)
        self._scale_space = ScaleSpace(array, parameters.scales, regions)
        self._scale_space.prepare(parameters)
        self._charged = PlacedChargeCache(array.shape)
        self._latest = parameters
        if regions is not None:
            self._check_edges()

    def with_regions(self, regions: Regions | None) -> Engine:
        """Engine for the same image with other regions.

        Parameters
        ----------
        regions : Regions or None
            Regions of interest and barriers. Where only the barriers are others, nothing of the fields is built anew;
            where the regions of interest are others, the image's gradient is taken over. A state of this engine can be
            stepped by the new one.

        Returns
        -------
        Engine
            For as many scales.

        Raises
        ------
        ValueError
            When the image has no edges in the regions of interest, or one of them holds no pixel.
        """
        others = regions is not None and (self.regions is None or regions.interest != self.regions.interest)
        if regions is not None and others:
            regions.check(self.image.values.shape)
        other = copy(self)
        other.regions = regions
        other._scale_space = self._scale_space.with_regions(regions)
        other._charged = PlacedChargeCache(self.image.values.shape)
        if others:
            other._check_edges()
        return other

    def _check_edges(self) -> None:
        if not self.scale_field(self._latest).edge_map.any():
            raise ValueError("there are no edges in the regions of interest: draw them around what is to be found.")

    @property
    def scales(self) -> int:
        """Levels of the pyramid."""
        return len(self._scale_space)

    def scale_field(self, parameters: Parameters, scale: int = 0) -> ScaleField:
        """Fields of a scale, built when they are first asked for."""
        self._latest = parameters
        return self._scale_space.at(scale, parameters)

    def edge_map(self, parameters: Parameters, scale: int = 0) -> Array:
        """Edge map of a scale, shape (H, W), zero where the edge floor leaves no fixed charge."""
        return self.scale_field(parameters, scale).fixed_charges

    def field(self, parameters: Parameters, scale: int = 0, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Lorentz force on the pixels of a scale, shape (2, H, W), with that of placed charges.

        Without any the vectors have at most unit length. The charges are in px of the image, whatever the scale.
        """
        return charged_force(
            self.scale_field(parameters, scale), at_scale(in_order(charges), scale, self.image.shape), scale
        )

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
        nobody = Particles.at_rest(points[:0])
        begun = State(nobody, points, self.image.shape, self.scales, no_coverage(()), regions=self.regions)
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
        state = self._taken_up(state, parameters, charges)
        scale_field = self._charged.of(self.scale_field(parameters, state.scale), state.scale, state.charges)
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
            As exactly as a step reckons them: pairs in single precision (2e-4 of a force of unit size), and what comes
            from afar by a mesh, which serves for four steps (`coulomb.far_force` tells what that leaves out). A step
            carries the force on by its change in the last two steps, eq. (15), and integrates the damping exactly;
            friction also takes the speed along the edge at once. None of this is a force.
        """
        state = self._taken_up(state, parameters, charges)
        scale_field = self.scale_field(parameters, state.scale)
        charged = self._charged.of(scale_field, state.scale, state.charges)
        idle = idle_steps_of(state, charged, parameters)
        which = np.arange(state.count) if index is None else index
        return forces(state, scale_field, charged, idle, parameters, which)

    def energies(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Energies:
        """Kinetic and potential energy of the particles of a state, as `cpm_core.dynamics.energies` defines them.

        The potential of the fixed charges is made when it is first asked for at a scale, and kept as long as the field.
        """
        return energies(
            replace(state, charges=in_order(charges)), self.scale_field(parameters, state.scale), parameters
        )

    def potential(self, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Potential on the pixels of the image, shape (H, W) [grey levels], lowest where particles are drawn to.

        That of the fixed charges, eq. (7), and that of placed ones, whose unit of force counts as the mean slope of the
        former. The former is made when it is first asked for, and kept as long as the field.
        """
        return charged_potential(self.scale_field(parameters), at_scale(in_order(charges), 0, self.image.shape))

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
        scale, shape, scale_field = state.scale, self.image.shape, self.scale_field(parameters, state.scale)
        # an edge that nobody is on may have been cleared by the user, and is then not walked along
        filled = state.converged and not state.charges and not state.erased
        found, bridged = find_contours(state.particles.position, scale_field, parameters, at_rest=filled)
        size = 2.0**scale
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
            spacing=self.image.spacing,
            unit=self.image.unit,
            source=self.image.source,
            bridges=bridges,
        )

    def _populate(
        self, state: State, moved: Moved, repulsion_gone: bool, scale_field: ScaleField, parameters: Parameters
    ) -> State:
        """Population of a step, by itself for the experiments that do without."""
        return populated(state, moved, repulsion_gone, scale_field, parameters)

    def _taken_up(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge]) -> State:
        """A state as a step takes it up, under other parameters, regions or charges than its last one or the same."""
        if state.steering != parameters.steering or state.regions != self.regions:
            allowed = interventions.within(state, self.regions)
            state = replace(interventions.reactivated(allowed), steering=parameters.steering)
        placed = in_order(charges)
        return state if state.charges == placed else interventions.reactivated_near(state, placed)
