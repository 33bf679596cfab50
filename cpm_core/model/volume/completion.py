"""Completion of a scale of a volume: surfaces that fronts did not reach, and the particles that remain.

Fronts stop at some narrow joints between vessels, although the edge continues. When a run is quiet, particles are
reseeded on the stretches that no particle covers, of all parts of the edge map that particles have reached, and of
those that cannot be moved apart from them (`inseparable`).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from cpm_core.field.placed_charges import Placed, radius_at, torn_off
from cpm_core.field.volume_field import VolumeField
from cpm_core.field.volume_surface import Ridges, faces_alike, on_ridges
from cpm_core.model.state import State, SurfaceContact
from cpm_core.model.volume.births import apart
from cpm_core.model.volume.inseparable import inseparable
from cpm_core.model.volume.motion import Cells, build_cells, near, room_for
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index
from cpm_core.numerics.vectors import difference, length, row_of

LAUNCHES = 16
"""Largest number of reseedings at a scale."""

WORTHWHILE = 0.0005
"""Fraction of the particles that a reseeding must add for another one to follow."""

_COVERED_RANGE = 2.2
"""Distance up to which a particle covers the ridge around it, in d_min."""

_RESEEDED_SPACING = 3.0
"""Distance of reseeded particles, in d_min."""

_TOUCHING_DISTANCE = 1.5
"""Distance up to which a particle lies on the ridge of a voxel [units]."""

_COVER_BARE = 0
"""Cover of a ridge voxel without a particle near."""

_COVER_NEAR = 1
"""Cover of a ridge voxel with a particle near."""

_COVER_TOUCHED = 2
"""Cover of a ridge voxel with a particle on it."""

_FINAL_RIDGE_STEPS = 12
"""Number of steps to the ridge at the end."""

_ASTRAY_DISTANCE = 2.0
"""Distance from which a particle on its way to the ridge has lost its place [units]."""

_RIDGES_PER_THREAD = 2_000
"""Ridges from which a second thread makes the search faster."""


def reseed_surface(state: State, field: VolumeField, d_min: float) -> State | None:
    """Add particles on the stretches that fronts did not reach; return None when there are none."""
    if state.reseedings >= LAUNCHES or state.erased:
        return None
    ridges = field.ridges
    if field.walls is not None:  # which divide connected parts: keep the ridges in rooms with particles
        rooms, taken = field.walls.rooms(ridges.place), field.walls.rooms(state.particles.position)
        _, number = np.unique(np.stack([ridges.component, rooms]), axis=1, return_inverse=True)
        inside = np.flatnonzero((rooms >= 0) & np.isin(rooms, taken))
        ridges = ridges._replace(component=number.ravel()).where(inside)
    cover = _cover(state, field, ridges, d_min)
    reached = np.zeros(int(ridges.component.max(initial=-1)) + 1, bool)
    reached[ridges.component[cover == _COVER_TOUCHED]] = True
    more = inseparable(field, ridges, reached, cover != _COVER_BARE)
    bare = np.flatnonzero((cover == _COVER_BARE) & (reached | more)[ridges.component])
    if not len(bare):
        return None
    ridges = ridges.where(bare)
    # the strongest first, and not too near to each other
    order = np.argsort(-ridges.strength, kind="stable")
    chosen = order[apart(ridges.place[order], ridges.normal[order], _RESEEDED_SPACING * d_min)]
    position = _pulled(field, ridges.place[chosen])
    free = ~field.crossed(ridges.place[chosen], position)
    free &= ~torn_off(Placed(state.placed, radius_at(state.scale)), position, ridges.normal[chosen])
    chosen, position = chosen[free], position[free]
    step = state.step_of_scale
    contact = SurfaceContact.of_seated(ridges.normal[chosen], ridges.strength[chosen], step)
    # another reseeding follows one that is worthwhile, and one that leads on to new boundaries
    worthwhile = more.any() or len(chosen) > WORTHWHILE * state.count
    return replace(
        state,
        particles=state.particles.with_more(position, state.next_identity, contact),
        next_identity=state.next_identity + len(chosen),
        reseedings=state.reseedings + 1 if worthwhile else LAUNCHES,
        born=state.born + len(chosen),
        annealed=1.0,
        reactivated=step,
        idle=0,
        quiet=0,
    )


def _cover(state: State, field: VolumeField, ridges: Ridges, d_min: float) -> Index:
    """Return how particles cover each ridge voxel, shape (M,)."""
    contact = state.particles.on_surface
    cover = np.zeros(len(ridges.place), np.int64)
    position, normal = state.particles.position[contact.seated], contact.normal[contact.seated]
    reach = max(_COVERED_RANGE * d_min, _TOUCHING_DISTANCE)
    cells = build_cells(position, field.extent, reach)
    share(
        partial(_find_cover, cells, normal, ridges.place, ridges.normal, reach, cover), len(cover), _RIDGES_PER_THREAD
    )
    return cover


@compiled
def _find_cover(
    cells: Cells, normals: Array, place: Array, facing: Array, reach: float, cover: Index, first: int, last: int
) -> None:
    """Find how the particles of the same sheet cover some voxels."""
    found = room_for(cells)
    for q in range(first, last):
        here, normal = row_of(place, q), row_of(facing, q)
        for n in range(near(cells, here, reach, found)):
            k = found[n]
            if cover[q] < _COVER_TOUCHED and faces_alike(normal, row_of(normals, cells.order[k])):
                away = length(difference(row_of(cells.place, k), here))
                cover[q] = max(cover[q], _COVER_TOUCHED if away < _TOUCHING_DISTANCE else _COVER_NEAR)


def drop_unseated(state: State, field: VolumeField) -> State:
    """Drop the particles off surfaces, and pull the others to the ridge."""
    contact = state.particles.on_surface
    found = state.particles.where(contact.seated & (contact.strength >= field.floor))
    position = _pulled(field, found.position)
    crossing = field.crossed(found.position, position)
    position[crossing] = found.position[crossing]
    kept = np.linalg.norm(position - found.position, axis=1) < _ASTRAY_DISTANCE
    found = replace(found, position=position).where(kept)
    return replace(state, particles=found, deleted=state.deleted + len(state.particles) - len(found))


def _pulled(field: VolumeField, places: Array) -> Array:
    """Move places to the ridge, which may lie behind the outermost voxels, but no farther than their centers."""
    position = on_ridges(field.smoothed, field.edges, field.pitch, places, _FINAL_RIDGE_STEPS)
    return np.clip(position, 0.0, (np.array(field.shape) - 1) * field.pitch)
