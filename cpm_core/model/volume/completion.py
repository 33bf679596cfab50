"""Completion of a scale of a volume: surfaces that fronts did not reach, and the particles that remain.

Fronts stop at some narrow joints between vessels, although the edge continues. When a run is quiet, particles are
reseeded on the stretches that no particle covers, of all parts of the edge map that particles have reached, and of
those that cannot be moved apart from them (`find_inseparable`).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from cpm_core.field.placed_charges import ChargesAtScale, charge_radius_at, find_torn_off
from cpm_core.field.volume_field import VolumeField
from cpm_core.field.volume_surface import Ridges, face_same_way, project_all_to_ridge
from cpm_core.model.volume.births import select_spaced
from cpm_core.model.volume.inseparable import find_inseparable
from cpm_core.model.volume.motion import VolumeCells, build_volume_cells, find_near, near_buffer
from cpm_core.model.volume.state import VolumeParticles, VolumeState
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index
from cpm_core.numerics.vectors import row_of, subtract_vectors, vector_length

MAX_VOLUME_RESEEDINGS = 16
"""Largest number of reseedings at a scale."""

WORTHWHILE_FRACTION = 0.0005
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


def reseed_surface(state: VolumeState, field: VolumeField, d_min: float, farthest: float) -> VolumeState | None:
    """Add particles on the stretches that fronts did not reach; return None when there are none.

    They count as crept a spacing farther than any other. So there are none once a front has been stopped by the
    creeping range `farthest` [units].
    """
    crept = float(state.particles.crept.max()) + _RESEEDED_SPACING * d_min
    if state.reseedings >= MAX_VOLUME_RESEEDINGS or state.erased or crept > farthest:
        return None
    ridges = field.ridges
    if field.walls is not None:  # which divide connected parts: keep the ridges in rooms with particles
        rooms, taken = field.walls.find_rooms(ridges.place), field.walls.find_rooms(state.particles.position)
        _, number = np.unique(np.stack([ridges.component, rooms]), axis=1, return_inverse=True)
        inside = np.flatnonzero((rooms >= 0) & np.isin(rooms, taken))
        ridges = ridges._replace(component=number.ravel()).select(inside)
    cover = _measure_cover(state, field, ridges, d_min)
    reached = np.zeros(int(ridges.component.max(initial=-1)) + 1, bool)
    reached[ridges.component[cover == _COVER_TOUCHED]] = True
    linked = find_inseparable(field, ridges, reached, cover != _COVER_BARE)
    bare = np.flatnonzero((cover == _COVER_BARE) & (reached | linked)[ridges.component])
    if not len(bare):
        return None
    ridges = ridges.select(bare)
    # the strongest first, and not too near to each other
    order = np.argsort(-ridges.strength, kind="stable")
    chosen = order[select_spaced(ridges.place[order], ridges.normal[order], _RESEEDED_SPACING * d_min)]
    position = _pull_to_ridge(field, ridges.place[chosen])
    free = ~field.crosses_wall(ridges.place[chosen], position)
    free &= ~find_torn_off(ChargesAtScale(state.placed, charge_radius_at(state.scale)), position, ridges.normal[chosen])
    chosen, position = chosen[free], position[free]
    step = state.step_of_scale
    more = VolumeParticles.at_rest_on_surfaces(
        position,
        state.next_identity,
        ridges.normal[chosen],
        ridges.strength[chosen],
        np.full(len(chosen), crept),
        np.full(len(chosen), step),
    )
    # another reseeding follows one that is worthwhile, and one that leads on to new boundaries
    worthwhile = linked.any() or len(chosen) > WORTHWHILE_FRACTION * state.count
    return replace(
        state,
        particles=state.particles.append(more),
        next_identity=state.next_identity + len(chosen),
        reseedings=state.reseedings + 1 if worthwhile else MAX_VOLUME_RESEEDINGS,
        born=state.born + len(chosen),
        annealed=1.0,
        reactivated=step,
        idle=0,
        quiet=0,
    )


def _measure_cover(state: VolumeState, field: VolumeField, ridges: Ridges, d_min: float) -> Index:
    """Return how particles cover each ridge voxel, shape (M,)."""
    cover = np.zeros(len(ridges.place), np.int64)
    on_surface = state.particles.on_surface
    position, normal = state.particles.position[on_surface], state.particles.normal[on_surface]
    reach = max(_COVERED_RANGE * d_min, _TOUCHING_DISTANCE)
    cells = build_volume_cells(position, field.extent, reach)
    run_in_parallel(
        partial(_find_cover, cells, normal, ridges.place, ridges.normal, reach, cover), len(cover), _RIDGES_PER_THREAD
    )
    return cover


@compiled
def _find_cover(
    cells: VolumeCells, normals: Array, place: Array, facing: Array, reach: float, cover: Index, first: int, last: int
) -> None:
    """Find how the particles of the same sheet cover some voxels."""
    found = near_buffer(cells)
    for q in range(first, last):
        here, normal = row_of(place, q), row_of(facing, q)
        for n in range(find_near(cells, here, reach, found)):
            k = found[n]
            if cover[q] < _COVER_TOUCHED and face_same_way(normal, row_of(normals, cells.order[k])):
                away = vector_length(subtract_vectors(row_of(cells.place, k), here))
                cover[q] = max(cover[q], _COVER_TOUCHED if away < _TOUCHING_DISTANCE else _COVER_NEAR)


def drop_off_surface(state: VolumeState, field: VolumeField) -> VolumeState:
    """Drop the particles off surfaces, and pull the others to the ridge."""
    found = state.particles.keep(state.particles.on_surface & (state.particles.strength >= field.floor))
    position = _pull_to_ridge(field, found.position)
    crossing = field.crosses_wall(found.position, position)
    position[crossing] = found.position[crossing]
    kept = np.linalg.norm(position - found.position, axis=1) < _ASTRAY_DISTANCE
    found = replace(found, position=position).keep(kept)
    return replace(state, particles=found, deleted=state.deleted + len(state.particles) - len(found))


def _pull_to_ridge(field: VolumeField, places: Array) -> Array:
    """Move places to the ridge, which may lie behind the outermost voxels, but no farther than their centers."""
    position = project_all_to_ridge(field.smoothed, field.edge_map, field.pitch, places, _FINAL_RIDGE_STEPS)
    return np.clip(position, 0.0, (np.array(field.shape) - 1) * field.pitch)
