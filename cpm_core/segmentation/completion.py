"""How particles come to rest, and who is left at the end of a scale and of a run."""

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
from cpm_core.particles.coverage.plane import idle_at
from cpm_core.particles.state import State
from cpm_core.segmentation.enclosed_regions import RESEEDINGS, reseeding_places

_UNDER_WAY, _PATIENCE = 0.3, 2
"""Part of the speed at which the field alone drives a particle above which one far from all ground counts as on its way
to some, and how many times as slowly it is then made to rest: it may have a long way to go."""

_CERTAIN = 1.25
"""How many times as strong as the weakest edge that counts one is that holds particles in any case."""

_LEAST_BETA = 0.1
"""Damping with which the speed is reckoned where there is none."""

_NOWHERE = -1
"""What stands for the idle steps of a particle far from all ground."""

_GATHERING, _GATHERED = 100, 0.02
"""Steps without news that particles have to gather round a charge, and the speed under which one has done so before
[px / unit of time]."""


def idle_steps_of(state: State, scale_field: ScaleField, parameters: Parameters) -> Index:
    """Steps since there was new ground around each particle, as far as they make it rest.

    Parameters
    ----------
    state : State
        Before the step.
    scale_field : ScaleField
        What is felt, placed charges included.
    parameters : Parameters
        For the speed that counts as being under way.

    Returns
    -------
    ndarray of int64, shape (N,)
        Steps.
    """
    particles = state.particles
    idle = idle_at(state.coverage, particles.position, state.step_of_scale, _NOWHERE)
    away = idle == _NOWHERE
    if away.any():
        driven = parameters.w2 / max(parameters.beta, _LEAST_BETA)
        speed = np.einsum("ni,ni->n", particles.velocity, particles.velocity)
        under_way = state.idle // _PATIENCE if state.coverage.size else 0  # the first to find any may take all the time
        idle[away] = np.where(speed[away] > (_UNDER_WAY * driven) ** 2, under_way, state.idle)
    if state.charges:
        _let_gather(state, scale_field, idle)
    return idle


def _let_gather(state: State, scale_field: ScaleField, idle: Index) -> None:
    """Keep up the repulsion of what gathers round an attracting charge off any edge, and then let it stand, in place.

    If the repulsion faded first, they would all fall into one spot, and of those that stand in one all but one go.
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
    """Go on with particles beside enclosed boundaries that no particle has reached; None when nothing is missing.

    Nor are any launched where some have been erased, or where a placed charge lets none sit.
    """
    if state.reseedings == RESEEDINGS or state.erased:
        return None
    places = reseeding_places(scale_field, without_off_edge(state, scale_field).particles.position)
    if state.charges:
        places = places[~_is_cleared(state, scale_field, places)]
    if not len(places):
        return None
    state = without_resting_off_edge(state, scale_field)  # else they would be set going again, and to no purpose
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
    """At which pixels, shape (N, 2), the placed charges are stronger than an edge."""
    charges, radius = at_scale(state.charges, state.scale, state.shape), radius_at(state.scale)
    force = placed_force(charges, radius, (0, scale_field.shape[0], 0, scale_field.shape[1]))
    return np.asarray((force[tuple(places.astype(int).T)] ** 2).sum(axis=1) > GATE**2)


def without_resting_off_edge(state: State, scale_field: ScaleField) -> State:
    """Leave out the particles at rest that sit on no edge, if any have found one: nothing draws them on.

    In a hole of a pixel or two none sits in the strict sense, but the edge around is strong. What has gathered round
    an attracting charge stays.
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
    """Leave out the particles that sit on no edge; a finer scale launches them anew from the drawing.

    Those that an attracting charge draws may be kept.
    """
    _, found = contact_at(state.particles.position, scale_field)
    if and_drawn:
        found |= _drawn(state)
    return replace(state, particles=state.particles.where(found))
