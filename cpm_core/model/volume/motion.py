"""The motion of particles of a volume in one time step.

The Coulomb force falls with the third power of the distance, as the field of the fixed charges does, and is summed over
near pairs only: on a surface, those within a few spacings screen the others. Two particles on different sheets, such as
the two walls of a vessel, do not repel each other. On a surface the Coulomb force acts along it alone, and static
friction holds a particle against it and against the part of the placed charges along the surface.

Particles are sorted into cubic cells. Surfaces fill few of the cells of a large volume: the list has an entry for each
row of cells along the last axis and not for each cell; within a row the particles are sorted by their cells, and those
of some cells are found by bisection.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np

from cpm_core.field.placed_charges import NO_PLACED_CHARGES, ChargesAtScale, placed_force
from cpm_core.field.volume_field import VolumeField
from cpm_core.field.volume_surface import ON_RIDGE_SLOPE, face_same_way, volume_force_at
from cpm_core.image.volume_regions import Walls
from cpm_core.model.coverage import cell_of, sort_by_cell
from cpm_core.model.equations import (
    COULOMB_SOFTNESS,
    advance_coordinate,
    damped_motion,
    is_stuck,
    repulsion_left,
)
from cpm_core.model.volume.state import VolumeParticles
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import (
    Vector,
    dot,
    move_along,
    row_lengths,
    row_of,
    scale_vector,
    set_row,
    subtract_vectors,
    vector_length,
)
from cpm_core.parameters import Parameters


class VolumeCells(NamedTuple):
    """Particles sorted into cubic cells of a side `size` [px]; a plain tuple for the compiled loops.

    The particles of a row of cells along the last axis, from `start` on, are contiguous, with the column of the cell,
    the index and the place [px] of each. Those beyond the grid belong to its outermost cells.
    """

    size: float
    planes: int
    rows: int
    cols: int
    start: Index
    col: Index
    order: Index
    place: Array


MIN_CELL_SIDE = 4.0
"""Least side of a cell, which limits the memory however small the distances [units]."""


def build_volume_cells(position: Array, shape: Vector, size: float) -> VolumeCells:
    """Sort the particles `position`, shape (N, 3), in a volume of this size into cells of side `size` [px]."""
    planes, rows, cols = (int(n / size) + 1 for n in shape)
    return VolumeCells(size, planes, rows, cols, *_sort_into_volume_cells(position, size, planes, rows, cols))


@compiled
def _sort_into_volume_cells(
    position: Array, size: float, planes: int, rows: int, cols: int
) -> tuple[Index, Index, Index, Array]:
    """Return the arrays of `VolumeCells`, from `start` on, for particles in a grid of this size."""
    count = len(position)
    col, line = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(count):
        col[i] = cell_of(position[i, 2], size, cols)
    by_col, order, sorted_places = np.empty(count, np.int64), np.empty(count, np.int64), np.empty((count, 3))
    sort_by_cell(col, by_col, np.zeros(cols + 1, np.int64))
    for n in range(count):
        place = row_of(position, by_col[n])
        line[n] = cell_of(place[0], size, planes) * rows + cell_of(place[1], size, rows)
    start = np.zeros(planes * rows + 1, np.int64)
    sort_by_cell(line, order, start)
    for n in range(count):
        order[n] = by_col[order[n]]
        set_row(sorted_places, n, row_of(position, order[n]))
        line[n] = col[order[n]]
    return start, line, order, sorted_places


@compiled
def find_near(cells: VolumeCells, place: Vector, reach: float, found: Index) -> int:
    """Write the sorted particles that are nearer to a place than a reach into `found`; return their number.

    `found` has room for one more than there are particles.
    """
    front = cell_of(place[1] - reach, cells.size, cells.rows)
    back = cell_of(place[1] + reach, cells.size, cells.rows)
    left = cell_of(place[2] - reach, cells.size, cells.cols)
    right = cell_of(place[2] + reach, cells.size, cells.cols)
    first = cell_of(place[0] - reach, cells.size, cells.planes)
    last = cell_of(place[0] + reach, cells.size, cells.planes)
    count = 0
    for plane in range(first, last + 1):
        for line in range(plane * cells.rows + front, plane * cells.rows + back + 1):
            end = cells.start[line + 1]
            k, high = cells.start[line], end
            while k < high:  # the first that is not left of them
                middle = (k + high) // 2
                if cells.col[middle] < left:
                    k = middle + 1
                else:
                    high = middle
            while k < end and cells.col[k] <= right:
                away = subtract_vectors(place, row_of(cells.place, k))
                found[count] = k  # the next one takes its place unless it is near: no branch to mispredict
                count += dot(away, away) < reach * reach
                k += 1
    return count


@compiled
def near_buffer(cells: VolumeCells) -> Index:
    """Allocate room for the particles that `find_near` finds."""
    return np.empty(len(cells.order) + 1, np.int64)


@compiled
def is_on_surface(slope: float, near: float, strength: float, floor: float) -> bool:
    """Return whether a particle is on the ridge of an edge that is strong enough.

    `slope` is the relative slope of the edge map along the normal, to which that of placed charges is added, `near` its
    weight in the force.
    """
    return near >= 1.0 and abs(slope) < ON_RIDGE_SLOPE and strength >= floor


@compiled
def on_same_surface(i: int, j: int, normals: Array, seated: Mask) -> bool:
    """Return whether two particles, with normals (N, 3), are neighbors: those on surfaces only if on the same sheet."""
    return not (seated[i] and seated[j]) or face_same_way(row_of(normals, i), row_of(normals, j))


def act_on_each_other(normals: Array, seated: Mask) -> Callable[[Index, Index], Mask]:
    """Return the rule `on_same_surface` for many pairs, by the indices of both."""
    return lambda i, j: (np.einsum("ni,ni->n", normals[i], normals[j]) > 0.0) | ~(seated[i] & seated[j])


REPULSION_REACH = 2.2
"""Distance up to which particles repel each other, in d_min."""

_SECOND_NEIGHBOR_DISTANCE = 4.0
"""Distance, in d_min, that a particle without a second neighbor counts it at."""

MIN_SQUARED_DISTANCE = 1e-4
"""Least squared distance of two particles in their force and energy [units^2]."""

_Fields = tuple[Single, Single, Single]
"""Smoothed volume, edge map, and far field."""

_Grid = tuple[Vector, Vector, float, float]
"""Sides of a voxel, voxels along the sides of a block, least edge strength, and the radius of placed charges."""

_Law = tuple[float, float, float, float]
"""Weights w1 and w2, time step, and particle spacing."""

_Felt = tuple[_Fields, _Grid, Array, _Law]
"""All of these, with the placed charges."""

_VOLUME_MOVED_PER_THREAD = 100
"""Particles from which a second thread makes the step faster."""


def move_in_volume(
    particles: VolumeParticles,
    turn: Index,
    cells: VolumeCells,
    idle: Index,
    field: VolumeField,
    law: Parameters,
    placed: ChargesAtScale = NO_PLACED_CHARGES,
) -> tuple[VolumeParticles, Array]:
    """Move some particles by one time step, in the order of the cells; the others stay as they are.

    `turn`, shape (K,), are their indices; `idle`, shape (N,), are the steps since something new was covered near each;
    `placed` are the placed charges.
    """
    after = replace(
        particles,
        position=particles.position.copy(),
        velocity=particles.velocity.copy(),
        force=particles.force.copy(),
        distance=np.roll(particles.distance, 1, axis=1),
        normal=particles.normal.copy(),
        on_surface=particles.on_surface.copy(),
        strength=particles.strength.copy(),
    )
    before = particles.position, particles.velocity, particles.force, particles.normal
    written = after.position, after.velocity, after.force, after.normal, after.strength
    felt = _gather_surroundings(field, law, placed)
    damped = damped_motion(law.beta, law.time_step)
    work = partial(_move_turn, turn, cells, idle, before, particles.on_surface, written, after.on_surface, felt, damped)
    run_in_parallel(work, len(turn), _VOLUME_MOVED_PER_THREAD)
    after.distance[:, 0] = row_lengths(after.position)
    return after, row_lengths(after.position - particles.position)


def force_parts(
    particles: VolumeParticles,
    which: Index,
    cells: VolumeCells,
    idle: Index,
    field: VolumeField,
    law: Parameters,
    placed: ChargesAtScale = NO_PLACED_CHARGES,
) -> Array:
    """Return Coulomb force, Lorentz force, that of placed charges, and friction on some particles, shape (4, M, 3).

    With their weights, as in a step; see `move_in_volume`.
    """
    parts, felt = np.empty((4, len(which), 3)), _gather_surroundings(field, law, placed)
    _write_force_parts(which, cells, idle, particles.position, particles.normal, particles.on_surface, felt, parts)
    return parts


def _gather_surroundings(field: VolumeField, law: Parameters, placed: ChargesAtScale) -> _Felt:
    """Collect everything that acts on particles except each other."""
    return (
        (field.smoothed, field.edge_map, field.far_field.force),
        (field.pitch, field.far_field.block, field.floor, placed.radius),
        placed.charges,
        (float(law.w1), float(law.w2), float(law.time_step), float(law.d_min)),
    )


@compiled
def _move_turn(
    turn: Index,
    cells: VolumeCells,
    idle: Index,
    before: tuple[Array, Array, Array, Array],
    was_seated: Mask,
    after: tuple[Array, Array, Array, Array, Array],
    seated: Mask,
    felt: _Felt,
    damped: Array,
    first: int,
    last: int,
) -> None:
    """Move some of the particles that have their turn."""
    position, velocity, force, normals = before
    to_position, to_velocity, to_force, to_normal, strength = after
    dt, found = felt[3][2], near_buffer(cells)
    for q in range(first, last):
        i = turn[q]
        place, speed = row_of(position, i), row_of(velocity, i)
        coulomb, lorentz, placed, held, normal, here, on_edge = _forces_on(
            i, place, cells, found, idle[i], normals, was_seated, felt
        )
        total = move_along(move_along(coulomb, 1.0, lorentz), 1.0, placed)
        if held:
            along = move_along(coulomb, 1.0, placed)
            total = move_along(total, -1.0, move_along(along, -dot(along, normal), normal))
            speed = scale_vector(normal, dot(speed, normal))
        late = min(idle[i], len(damped) - 1)
        series = (damped[late, 0], damped[late, 1], damped[late, 2], damped[late, 3])
        for axis in range(3):
            now = total[axis]
            old, older = (now, now) if on_edge else (force[i, 0, axis], force[i, 1, axis])
            x, v = advance_coordinate(place[axis], speed[axis], now, old, older, dt, series)
            to_position[i, axis], to_velocity[i, axis] = x, v
            to_force[i, 0, axis], to_force[i, 1, axis] = now, force[i, 0, axis]
        set_row(to_normal, i, normal)
        strength[i], seated[i] = here, on_edge


@compiled
def _forces_on(
    i: int,
    place: Vector,
    cells: VolumeCells,
    found: Index,
    idle: int,
    normals: Array,
    was_seated: Mask,
    felt: _Felt,
) -> tuple[Vector, Vector, Vector, bool, Vector, float, bool]:
    """Return Coulomb force, Lorentz force and that of placed charges on a particle, and whether friction holds it.

    Return also the normal of the edge there, its strength, and whether the particle is on it.
    """
    fields, (pitch, block, floor, radius), charges, (w1, w2, _, d_min) = felt
    coulomb = (0.0, 0.0, 0.0)
    left = repulsion_left(idle)
    if left > 0.0:
        coulomb = scale_vector(_repulsion_on(cells, found, place, i, normals, was_seated, d_min), w1 * left)
    pull, normal, here, slope, near = volume_force_at(*fields, pitch, block, floor, place)
    drawn = placed_force(charges, radius, place)
    placed = scale_vector(drawn, w2)
    on_edge, held = is_on_surface(slope + dot(drawn, normal), near, here, floor), False
    if on_edge:
        coulomb = move_along(coulomb, -dot(coulomb, normal), normal)
        along = move_along(coulomb, 1.0, move_along(placed, -dot(placed, normal), normal))
        held = is_stuck(vector_length(along), 0.0, w1, idle)
    return coulomb, scale_vector(pull, w2), placed, held, normal, here, on_edge


@compiled
def _write_force_parts(
    which: Index,
    cells: VolumeCells,
    idle: Index,
    position: Array,
    normals: Array,
    seated: Mask,
    felt: _Felt,
    parts: Array,
) -> None:
    """Write the forces on some particles."""
    found = near_buffer(cells)
    for q in range(len(which)):
        i = which[q]
        place = row_of(position, i)
        coulomb, lorentz, placed, held, normal, _, _ = _forces_on(
            i, place, cells, found, idle[i], normals, seated, felt
        )
        along = move_along(coulomb, 1.0, placed)
        friction = scale_vector(move_along(along, -dot(along, normal), normal), -1.0 if held else 0.0)
        for axis in range(3):
            parts[0, q, axis], parts[1, q, axis] = coulomb[axis], lorentz[axis]
            parts[2, q, axis], parts[3, q, axis] = placed[axis], friction[axis]


@compiled
def _repulsion_on(
    cells: VolumeCells, found: Index, place: Vector, i: int, normals: Array, seated: Mask, d_min: float
) -> Vector:
    """Return the normalized Coulomb force on a particle from those near it, except for those on other sheets."""
    total, own, on_surface = (0.0, 0.0, 0.0), row_of(normals, i), seated[i]
    nearest, second = np.inf, (_SECOND_NEIGHBOR_DISTANCE * d_min) ** 2
    for n in range(find_near(cells, place, REPULSION_REACH * d_min, found)):
        k = found[n]
        j = cells.order[k]
        away = subtract_vectors(place, row_of(cells.place, k))
        apart = (j == i) | (on_surface & seated[j] & (not face_same_way(own, row_of(normals, j))))
        # no branches: half of them would be mispredicted in a thin object
        squared = np.inf if apart else max(dot(away, away), MIN_SQUARED_DISTANCE)
        total = move_along(total, 1.0 / (squared * squared), away)
        second = min(second, max(nearest, squared))
        nearest = min(nearest, squared)
    if nearest == np.inf:
        return total
    spacing = 0.5 * (np.sqrt(nearest) + np.sqrt(second))
    scale = COULOMB_SOFTNESS * spacing**3 * min(1.0, spacing / d_min)
    return scale_vector(total, scale / max(1.0, scale * vector_length(total)))


def hold_at_walls(walls: Walls, before: VolumeParticles, after: VolumeParticles) -> VolumeParticles:
    """Return particles after a step, held back where they would cross a wall.

    Such a particle keeps the part of its step and of its velocity along two axes or one, the faces and edges of voxels:
    the first of these parts that crosses no wall. Otherwise it stays where it was, at rest.
    """
    blocked = np.flatnonzero(walls.is_crossed_by(before.position, after.position))
    if not len(blocked):
        return after
    position, velocity = after.position.copy(), after.velocity.copy()
    for kept in (*combinations(range(3), 2), *combinations(range(3), 1)):
        along = np.isin(np.arange(3), kept)
        ends = before.position[blocked] + (position[blocked] - before.position[blocked]) * along
        free = ~walls.is_crossed_by(before.position[blocked], ends)
        chosen = blocked[free]
        position[chosen], velocity[chosen] = ends[free], velocity[chosen] * along
        blocked = blocked[~free]
    position[blocked], velocity[blocked] = before.position[blocked], 0.0
    return replace(after, position=position, velocity=velocity)
