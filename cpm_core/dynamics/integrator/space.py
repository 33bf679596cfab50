"""A time step of particles in a volume.

The Coulomb force falls with the third power of the distance, as the field of the fixed charges does, and is summed over
near pairs only: on a surface, those within a few spacings screen the others. Two particles that are seated on different
sheets, such as the two walls of a vessel, do not repel each other. On a surface the Coulomb force acts along it alone,
and static friction holds a particle against it and against the part of the placed charges along the surface.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from cpm_core.dynamics.edge_contact.space import is_seated, on_one_sheet
from cpm_core.dynamics.equations import advance, damped_series, damping, is_stuck, repulsion_left
from cpm_core.dynamics.integrator import Moved
from cpm_core.field.volume.placed_charges import NOTHING_PLACED, Placed, placed_at
from cpm_core.field.volume.surface_force import felt_at
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import Vector, difference, dot, length, moved, row_of, scaled, set_row
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list.space import Cells, cells_around, row_of_cells
from cpm_core.particles.state import Particles
from cpm_core.particles.surface_contact import SurfaceContact

REACH = 2.2
"""Distance up to which particles repel each other, in d_min."""

_FAR_NEIGHBOR = 4.0
"""Distance at which a particle without a second neighbor has one in effect, in d_min."""

_SOFTNESS = 0.5
"""Slope of the normalized Coulomb force near equilibrium, as in `equations`."""

_NEAREST = 1e-4
"""Least squared distance of two particles in their force [units^2]."""

_Fields = tuple[Single, Single, Single]
"""Smoothed volume, edge map, and far field."""

_Grid = tuple[Vector, Vector, float, float]
"""Sides of a voxel, voxels along the sides of a block, least edge strength, and the radius of placed charges."""

_Law = tuple[float, float, float, float, float]
"""Weights w1 and w2, damping, time step, and particle spacing."""

_Felt = tuple[_Fields, _Grid, Array, _Law]
"""All of these, with the placed charges."""

_WORTH_A_THREAD = 100
"""Particles from which a second thread makes the step faster."""


def move(
    particles: Particles,
    turn: Index,
    cells: Cells,
    idle: Index,
    field: VolumeField,
    law: Parameters,
    placed: Placed = NOTHING_PLACED,
) -> Moved:
    """One time step of some particles, `turn` in the order of the cells; the others stay as they are.

    `idle`, shape (N,), are the steps since new ground was found near each; `placed` are the placed charges.
    """
    contact = particles.contact
    assert contact is not None
    after = Particles(
        particles.position.copy(),
        particles.velocity.copy(),
        particles.force.copy(),
        np.roll(particles.distance, 1, axis=1),
        particles.identity,
        SurfaceContact(contact.normal.copy(), contact.seated.copy(), contact.strength.copy(), contact.woken),
    )
    share(partial(_moved, particles, after, turn, cells, idle, _felt(field, law, placed)), len(turn), _WORTH_A_THREAD)
    after.distance[:, 0] = np.linalg.norm(after.position, axis=1)
    motion = np.linalg.norm(after.position - particles.position, axis=1)
    assert after.contact is not None
    return Moved(after, motion, after.contact.strength, after.contact.seated)


def parts_of_force(
    particles: Particles,
    which: Index,
    cells: Cells,
    idle: Index,
    field: VolumeField,
    law: Parameters,
    placed: Placed = NOTHING_PLACED,
) -> tuple[Array, Array, Array, Array]:
    """Coulomb force, Lorentz force, that of placed charges, and friction on some particles, shape (M, 3) each.

    With their weights, as in a step; see `move`.
    """
    contact = particles.contact
    assert contact is not None
    fields, grid, charges, weights = _felt(field, law, placed)
    position = particles.position
    parts = np.empty((4, len(which), 3))
    _parts(which, cells, idle, position, contact.normal, contact.seated, fields, grid, charges, weights, parts)
    return parts[0], parts[1], parts[2], parts[3]


def _felt(field: VolumeField, law: Parameters, placed: Placed) -> _Felt:
    """What particles feel besides each other."""
    return (
        (field.smoothed, field.edge_map, field.far.force),
        (field.pitch, field.far.block, field.floor, placed.radius),
        placed.charges,
        (float(law.w1), float(law.w2), float(law.beta), float(law.time_step), float(law.d_min)),
    )


def _moved(
    before: Particles,
    after: Particles,
    turn: Index,
    cells: Cells,
    idle: Index,
    felt: _Felt,
    first: int,
    last: int,
) -> None:
    """Move a part of the particles, into the arrays of `after`."""
    old, new = before.contact, after.contact
    assert old is not None
    assert new is not None
    _move(
        turn,
        cells,
        idle,
        (before.position, before.velocity, before.force, old.normal),
        old.seated,
        (after.position, after.velocity, after.force, new.normal, new.strength),
        new.seated,
        *felt,
        first,
        last,
    )


@compiled
def _move(
    turn: Index,
    cells: Cells,
    idle: Index,
    before: tuple[Array, Array, Array, Array],
    was_seated: Mask,
    after: tuple[Array, Array, Array, Array, Array],
    seated: Mask,
    fields: _Fields,
    grid: _Grid,
    charges: Array,
    law: _Law,
    first: int,
    last: int,
) -> None:
    """Move some of the particles that have their turn."""
    position, velocity, force, normals = before
    to_position, to_velocity, to_force, to_normal, strength = after
    beta, dt = law[2], law[3]
    for q in range(first, last):
        i = turn[q]
        place, speed = row_of(position, i), row_of(velocity, i)
        coulomb, lorentz, placed, held, normal, here, on_edge = _forces_on(
            i, place, cells, idle[i], normals, was_seated, fields, grid, charges, law
        )
        total = moved(moved(coulomb, 1.0, lorentz), 1.0, placed)
        if held:
            along = moved(coulomb, 1.0, placed)
            total = moved(total, -1.0, moved(along, -dot(along, normal), normal))
            speed = scaled(normal, dot(speed, normal))
        series = damped_series(damping(beta, idle[i]) * dt)
        for axis in range(3):
            now = total[axis]
            old, older = (now, now) if on_edge else (force[i, 0, axis], force[i, 1, axis])
            x, v = advance(place[axis], speed[axis], now, old, older, dt, series)
            to_position[i, axis], to_velocity[i, axis] = x, v
            to_force[i, 0, axis], to_force[i, 1, axis] = now, force[i, 0, axis]
        set_row(to_normal, i, normal)
        strength[i], seated[i] = here, on_edge


@compiled
def _forces_on(
    i: int,
    place: Vector,
    cells: Cells,
    idle: int,
    normals: Array,
    was_seated: Mask,
    fields: _Fields,
    grid: _Grid,
    charges: Array,
    law: _Law,
) -> tuple[Vector, Vector, Vector, bool, Vector, float, bool]:
    """Coulomb force, Lorentz force and that of placed charges on a particle, and whether friction holds it.

    Then the normal of the edge there, its strength, and whether the particle is on it.
    """
    w1, w2, d_min = law[0], law[1], law[4]
    coulomb = (0.0, 0.0, 0.0)
    left = repulsion_left(idle)
    if left > 0.0:
        coulomb = scaled(_repulsion(cells, place, i, normals, was_seated, d_min), w1 * left)
    pull, normal, here, slope, near = felt_at(*fields, grid[0], grid[1], grid[2], place)
    drawn = placed_at(charges, grid[3], place)
    placed = scaled(drawn, w2)
    on_edge, held = is_seated(slope + dot(drawn, normal), near, here, grid[2]), False
    if on_edge:
        coulomb = moved(coulomb, -dot(coulomb, normal), normal)
        along = moved(coulomb, 1.0, moved(placed, -dot(placed, normal), normal))
        held = is_stuck(length(along), 0.0, w1, idle)
    return coulomb, scaled(pull, w2), placed, held, normal, here, on_edge


@compiled
def _parts(
    which: Index,
    cells: Cells,
    idle: Index,
    position: Array,
    normals: Array,
    seated: Mask,
    fields: _Fields,
    grid: _Grid,
    charges: Array,
    law: _Law,
    parts: Array,
) -> None:
    """Write the forces on some particles."""
    for q in range(len(which)):
        i = which[q]
        place = row_of(position, i)
        coulomb, lorentz, placed, held, normal, _, _ = _forces_on(
            i, place, cells, idle[i], normals, seated, fields, grid, charges, law
        )
        along = moved(coulomb, 1.0, placed)
        friction = scaled(moved(along, -dot(along, normal), normal), -1.0 if held else 0.0)
        for axis in range(3):
            parts[0, q, axis], parts[1, q, axis] = coulomb[axis], lorentz[axis]
            parts[2, q, axis], parts[3, q, axis] = placed[axis], friction[axis]


@compiled
def _repulsion(cells: Cells, place: Vector, i: int, normals: Array, seated: Mask, d_min: float) -> Vector:
    """Normalized Coulomb force on a particle from those near it, but for those on other sheets."""
    reach = REACH * d_min
    total = (0.0, 0.0, 0.0)
    nearest, second = np.inf, (_FAR_NEIGHBOR * d_min) ** 2
    top, bottom, front, back, left, right = cells_around(cells, place[0], place[1], place[2], reach)
    for plane in range(top, bottom + 1):
        for row in range(front, back + 1):
            start, end = row_of_cells(cells, plane, row, left, right)
            for k in range(start, end):
                away = difference(place, (cells.z[k], cells.y[k], cells.x[k]))
                squared = dot(away, away)
                j = cells.order[k]
                if squared < reach * reach and j != i and on_one_sheet(i, j, normals, seated):
                    squared = max(squared, _NEAREST)
                    total = moved(total, 1.0 / (squared * squared), away)
                    if squared < nearest:
                        nearest, second = squared, min(nearest, second)
                    elif squared < second:
                        second = squared
    if nearest == np.inf:
        return total
    spacing = 0.5 * (np.sqrt(nearest) + np.sqrt(second))
    scale = _SOFTNESS * spacing**3 * min(1.0, spacing / d_min)
    return scaled(total, scale / max(1.0, scale * length(total)))
