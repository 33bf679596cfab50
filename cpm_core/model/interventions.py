"""Changes of a run under way: by the user, and by the schedule of scales."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.field.placed_charges import Charges, PlacedCharge, changed_charges, check_charges
from cpm_core.image.pyramid import shape_at_scale, to_image, to_scale
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.measures import state_metrics
from cpm_core.model.starts import check_seeds, is_allowed, is_inside_image
from cpm_core.model.state import State
from cpm_core.numerics.types import Array, Extent, Mask
from cpm_core.parameters import Parameters

StateT = TypeVar("StateT", bound=State)
"""State of a run in the plane or in a volume."""

ParticleSelection = Mask | Callable[[Array], ArrayLike]


def apply_interventions(
    state: StateT, regions: AnyRegions | None, parameters: Parameters, charges: Sequence[PlacedCharge]
) -> StateT:
    """Return the state with which a step begins, reactivated where parameters, regions or charges have changed."""
    if state.steering != parameters.steering or state.regions != regions:
        state = replace(limit_to_regions(state, regions).reactivate_all(), steering=parameters.steering)
    placed = check_charges(charges, len(state.shape))
    return state if state.charges == placed else change_charges(state, placed)


def limit_to_regions(state: StateT, regions: AnyRegions | None) -> StateT:
    """Continue in other regions with the particles inside them."""
    if state.regions == regions:
        return state
    allowed = is_allowed(state.position, regions)
    return replace(state, particles=state.particles.keep(allowed), regions=regions)


def change_charges(state: StateT, charges: Charges) -> StateT:
    """Continue with other placed charges, in order, and reactivate the particles within reach of a changed one."""
    changed = replace(state, charges=changed_charges(state.charges, charges)).placed
    woken = state.reactivate_near(changed)
    return replace(woken, charges=charges, annealed=1.0, reactivated=state.step_of_scale, quiet=0)


class ParticleMethod:
    """Base of methods whose states are `State`, in whose runs users add and erase particles."""

    regions: AnyRegions | None
    scales: int

    def can_start(self, parameters: Parameters) -> bool:
        """Return whether a run with these parameters can start: with as many scales."""
        return parameters.scales == self.scales

    def measure_state(self, state: State, parameters: Parameters) -> Mapping[str, float]:
        """Return the metrics of a state by name; see `Method.measure_state`."""
        return state_metrics(state)

    def add_particles(self, state: StateT, seeds: ArrayLike) -> StateT:
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
        points = check_seeds(seeds, state.shape, self.regions)
        more = state.particles.at_rest(state.to_particle_places(points), state.next_identity)
        joined = replace(
            state,
            particles=state.particles.append(more),
            start=np.concatenate([state.start, points]),
            next_identity=state.next_identity + len(points),
        )
        return joined.reactivate_all().resume().widen_window()

    def erase_particles(self, state: StateT, inside: ParticleSelection) -> StateT:
        """Remove particles from a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        inside : ndarray of bool, shape (N,), or callable
            Mask of the particles, or a function of positions, shape (M, 2) [px of the image]. The function is applied
            to the seeds as well, so that a finer scale does not begin there again.

        Returns
        -------
        State
            With the other particles, which are not reactivated: no particles are inserted next to those at rest, and a
            run that has ended stays so. Without any particle left the run ends.

        Raises
        ------
        ValueError
            When `inside` is not one truth value for each particle.
        """
        if callable(inside):
            gone = _check_mask(inside(state.position), state.count, "particles")
            start = state.start[~_check_mask(inside(state.start), len(state.start), "starting particles")]
        else:
            gone, start = _check_mask(inside, state.count, "particles"), state.start
        if not gone.any() and len(start) == len(state.start):
            return state
        rest = replace(state.erase_particles(gone), start=start)
        return rest if rest.count else rest.stop("all particles have been erased")


def _check_mask(inside: ArrayLike, count: int, noun: str) -> Mask:
    """Check a mask of the selected particles, shape (N,)."""
    mask = np.asarray(inside)
    if mask.dtype != np.bool_ or mask.shape != (count,):
        raise ValueError(f"which {noun} to erase must be given by {count} truth values, one for each.")
    return mask


def start_scale(state: StateT, scale: int, regions: AnyRegions | None) -> StateT:
    """Begin a scale with the particles of the coarser one and with all seeds."""
    position = np.concatenate([state.position, state.start])
    crept = np.concatenate([state.particles.crept * 2.0 ** (state.scale - scale), np.zeros(len(state.start))])
    places = to_scale(position, scale, state.shape)
    allowed = _may_be_at(places, scale, state.shape, regions)
    begun = state.begin_scale(scale, places[allowed])
    return replace(begun, particles=replace(begun.particles, crept=crept[allowed]))


def allowed_places(position: Array, scale: int, shape: Extent, regions: AnyRegions | None) -> Array:
    """Return positions, shape (N, D) [px of the image], at a scale, without those where no particle may be."""
    places = to_scale(position, scale, shape)
    return places[_may_be_at(places, scale, shape, regions)]


def _may_be_at(places: Array, scale: int, shape: Extent, regions: AnyRegions | None) -> Mask:
    """Return a mask, shape (N,), of the places of a scale where a particle may be."""
    inside = is_inside_image(places, shape_at_scale(shape, scale))
    inside[inside] = is_allowed(to_image(places[inside], scale, shape), regions)
    return inside
