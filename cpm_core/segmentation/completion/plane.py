"""Completion: how particles come to rest, and which remain at the end of a scale and of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.dynamics.edge_contact.plane import contact_at
from cpm_core.dynamics.equations import FADED, LATEST
from cpm_core.field.placed_charges import at_scale, placed_force, radius_at, within_reach
from cpm_core.field.scale_field import GATE, ScaleField
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import Parameters
from cpm_core.particles.coverage import idle_at
from cpm_core.particles.state import State
from cpm_core.segmentation.enclosed_regions import RESEEDINGS, reseeding_places

_UNDER_WAY, _PATIENCE = 0.3, 2
"""Fraction of the speed that the field alone gives a particle, above which one outside the coverage map counts as
under way, and the factor by which it then comes to rest more slowly: it may have far to go."""

_TRAVELLING = 0.25
"""Fraction of the particles that may be under way at the end of a coarser scale."""

_CERTAIN = 1.25
"""Edge strength, in multiples of the edge floor, that holds particles in any case."""

_LEAST_BETA = 0.1
"""Damping with which the speed is estimated where there is none."""

_OUTSIDE = -1
"""Value for the idle steps of a particle outside the coverage map."""

_GATHERING, _GATHERED = 100, 0.02
"""Steps without new coverage in which particles gather around a charge, and the speed under which one has done so
earlier [px / unit of time]."""


def idle_steps_of(state: State, scale_field: ScaleField, parameters: Parameters) -> Index:
    """Steps since there was new coverage around each particle, shape (N,), which bring it to rest.

    `state` is the one before the step, and `scale_field` includes the placed charges.
    """
    particles = state.particles
    idle = idle_at(state.coverage, particles.position, state.step_of_scale, _OUTSIDE)
    away = idle == _OUTSIDE
    if away.any():
        under_way = state.idle // _PATIENCE if state.coverage.size else 0  # before the first coverage there is no limit
        idle[away] = np.where(_is_fast(state.particles.velocity[away], parameters), under_way, state.idle)
    if state.charges:
        _let_gather(state, scale_field, idle)
    return idle


def is_travelling(state: State, parameters: Parameters) -> bool:
    """Whether so many particles are still under way to their first edge that a coarser scale has not done its work.

    A start far from all edges would else be handed on to the finest scale, where noise stops particles that have far
    to go.
    """
    idle = idle_at(state.coverage, state.particles.position, state.step_of_scale, _OUTSIDE)
    flying = int(np.count_nonzero(_is_fast(state.particles.velocity[idle == _OUTSIDE], parameters)))
    return flying > _TRAVELLING * state.count


def _is_fast(velocity: Array, parameters: Parameters) -> NDArray[np.bool_]:
    """Which particles of these velocities, shape (N, D), move so fast that the field alone must drive them."""
    driven = parameters.w2 / max(parameters.beta, _LEAST_BETA)
    return np.asarray(np.einsum("ni,ni->n", velocity, velocity) > (_UNDER_WAY * driven) ** 2)


def _let_gather(state: State, scale_field: ScaleField, idle: Index) -> None:
    """Keep the repulsion of particles that gather around an attracting charge off the edges, then fix them (in place).

    If the repulsion faded first, they would all move to one position, and all but one would be deleted.
    """
    near = np.flatnonzero(_drawn(state))
    strength, _ = contact_at(state.particles.position[near], scale_field)
    near = near[strength < scale_field.floor]
    velocity = state.particles.velocity[near]
    slow = np.einsum("ni,ni->n", velocity, velocity) < _GATHERED**2
    gathered = (idle[near] >= _GATHERING) | (slow & (idle[near] >= FADED))
    idle[near] = np.where(gathered, LATEST, 0)


def _drawn(state: State) -> NDArray[np.bool_]:
    """Which particles are within reach of a charge that attracts them, shape (N,)."""
    attracting = [charge for charge in state.charges if charge.strength > 0.0]
    return within_reach(state.particles.position, attracting, state.scale, state.shape)


def reseeded(state: State, scale_field: ScaleField) -> State | None:
    """Reseed beside enclosed boundaries that no particle has reached; None when none is missing.

    There is no reseeding in a run with erased particles, nor where a placed charge is stronger than an edge.
    """
    if state.reseedings == RESEEDINGS or state.erased:
        return None
    places = reseeding_places(scale_field, without_off_edge(state, scale_field).particles.position)
    if state.charges:
        places = places[~_is_cleared(state, scale_field, places)]
    if not len(places):
        return None
    state = without_resting_off_edge(state, scale_field)  # else they would be reactivated in vain
    return replace(
        state,
        particles=state.particles.with_more(places, state.next_identity),
        next_identity=state.next_identity + len(places),
        reseedings=state.reseedings + 1,
        born=state.born + len(places),
        annealed=1.0,
        reactivated=state.step_of_scale,
        idle=0,
        quiet=0,
    )


def _is_cleared(state: State, scale_field: ScaleField, places: Array) -> NDArray[np.bool_]:
    """At which pixels, shape (N, 2), the placed charges are stronger than an edge, shape (N,)."""
    charges, radius = at_scale(state.charges, state.scale, state.shape), radius_at(state.scale)
    force = placed_force(charges, radius, (0, scale_field.shape[0], 0, scale_field.shape[1]))
    return np.asarray((force[tuple(places.astype(int).T)] ** 2).sum(axis=1) > GATE**2)


def without_resting_off_edge(state: State, scale_field: ScaleField) -> State:
    """Leave out the particles at rest off the edge, if any particle has found an edge.

    In a hole of one or two pixels no particle has edge contact in the strict sense, but the edge around it is strong.
    Particles around an attracting charge stay.
    """
    position = state.particles.position
    strength, on_edge = contact_at(position, scale_field)
    found = on_edge | (strength >= _CERTAIN * scale_field.floor)
    if not found.any():
        return state
    found |= _drawn(state)
    if found.all():
        return state
    return replace(state, particles=state.particles.where(found), deleted=state.deleted + int((~found).sum()))


def without_off_edge(state: State, scale_field: ScaleField, and_drawn: bool = False) -> State:
    """Leave out the particles off the edge, since a finer scale begins with all seeds again.

    Those within reach of an attracting charge can be kept.
    """
    _, found = contact_at(state.particles.position, scale_field)
    if and_drawn:
        found |= _drawn(state)
    return replace(state, particles=state.particles.where(found))
