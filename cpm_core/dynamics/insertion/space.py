"""Insertion of particles on a surface in a volume: hexagonal fronts in its tangent plane.

A seated particle sorts its neighbors on the same sheet by their direction in the tangent plane. A gap between two of
them is divided into steps of about 60 degrees, and each step is a place for a new particle, ``0.9 d_min`` ahead, pulled
to the ridge of the edge map: there must be an edge that is strong enough, not turned to another sheet, and room.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.dynamics.insertion import STRIDE
from cpm_core.field.interpolation.space import normal_at, sampled
from cpm_core.field.scale_field import FAINTEST
from cpm_core.field.volume.placed_charges import NOTHING_PLACED, Placed, torn_off
from cpm_core.field.volume.surface_force import faces_alike, is_ridge, on_ridge
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import Vector, difference, dot, length, moved, row_of, scaled
from cpm_core.particles.cell_list import cell_of
from cpm_core.particles.cell_list.space import Cells, cells_around, row_of_cells
from cpm_core.particles.state import Particles

ROOM = 0.68
"""Least distance of a new particle from others of its sheet, in d_min."""

_NEIGHBORS = 1.7
"""Distance up to which neighbors close a gap, in strides."""

_WIDEST_GAP = np.radians(100.0)
"""Gap between the directions of two neighbors from which on there is room between them."""

_STEP, _ROUNDING = np.pi / 3.0, 0.35
"""Angle between new particles in a gap, and how readily a gap gets one more."""

_MOST = 6
"""New particles around one."""

_MOST_NEIGHBORS = 64
"""Neighbors that are sorted; there are no more on a sheet that deletion keeps thin."""

_FARTHEST = 1.6
"""Distance of a new particle from the one that it is ahead of, in strides."""

_TURNED = -0.5
"""Scalar product of the normals under which the edge ahead belongs to another sheet."""

_ROUNDS, _RIDGE = 6, 0.7
"""Steps to the ridge, and the distance at which the edge must be weaker on both sides."""

_SAME_PLACE = 0.5
"""Distance up to which two particles are in each other's way on any sheets [units]."""

_WORTH_A_THREAD = 100
"""Particles from which a second thread makes the search faster."""


class Fronts(NamedTuple):
    """New particles: positions and normals, shape (M, 3), and edge strengths, shape (M,)."""

    position: Array
    normal: Array
    strength: Array


def fronts(
    particles: Particles, cells: Cells, turn: Index, field: VolumeField, d_min: float, placed: Placed = NOTHING_PLACED
) -> Fronts:
    """Places ahead of the seated particles that have their turn, in the order of these.

    They are where the placed charges leave particles on the edge.
    """
    contact = particles.contact
    assert contact is not None
    looking = turn[contact.seated[turn]]
    found, count = np.empty((len(looking), _MOST, 7)), np.zeros(len(looking), np.int64)
    sheets = (particles.position, contact.normal, contact.seated, contact.strength)
    find = partial(_fronts, looking, cells, *sheets, field.smoothed, field.edge_map, field.pitch, field.floor)
    share(lambda first, last: find(d_min, found, count, first, last), len(looking), _WORTH_A_THREAD)
    places, parents = found[np.arange(_MOST) < count[:, None]], np.repeat(looking, count)
    places = places[~field.crossed(particles.position[parents], places[:, :3])]
    places = places[~torn_off(placed, places[:, :3], places[:, 3:6])]
    some = places[apart(places, ROOM * d_min, cells)]
    return Fronts(some[:, :3].copy(), some[:, 3:6].copy(), some[:, 6].copy())


@compiled
def _fronts(
    looking: Index,
    cells: Cells,
    position: Array,
    normals: Array,
    seated: Mask,
    strength: Array,
    smoothed: Single,
    edges: Single,
    pitch: Vector,
    floor: float,
    d_min: float,
    found: Array,
    count: Index,
    first: int,
    last: int,
) -> None:
    """Find the places ahead of some particles."""
    angles = np.empty(_MOST_NEIGHBORS)
    stride, room = STRIDE * d_min, ROOM * d_min
    for q in range(first, last):
        i = looking[q]
        place, normal = row_of(position, i), row_of(normals, i)
        one, other = tangents(normal)
        start, gap, steps = _widest_gap(cells, place, i, normals, seated, one, other, _NEIGHBORS * stride, angles)
        for step in range(1, steps):
            angle = start + gap * step / steps
            ahead = moved(moved(place, stride * np.cos(angle), one), stride * np.sin(angle), other)
            ahead = on_ridge(smoothed, edges, pitch, ahead, _ROUNDS)
            away = length(difference(ahead, place))
            here = sampled(edges, pitch, ahead)
            turned = normal_at(smoothed, pitch, ahead)
            fits = room <= away <= _FARTHEST * stride and here >= max(floor, FAINTEST * strength[i])
            fits = fits and dot(turned, normal) >= _TURNED and _inside(ahead, edges.shape, pitch)
            fits = fits and count[q] < _MOST and is_ridge(smoothed, edges, pitch, ahead, _RIDGE)
            if fits and not _is_taken(cells, ahead, turned, normals, room):
                entry = found[q, count[q]]
                for axis in range(3):
                    entry[axis], entry[3 + axis] = ahead[axis], turned[axis]
                entry[6] = here
                count[q] += 1


@compiled
def tangents(normal: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors of the plane across a normal, at right angles to each other."""
    one = (0.0, -normal[2], normal[1]) if abs(normal[0]) < 0.7 else (normal[1], -normal[0], 0.0)
    one = scaled(one, 1.0 / length(one))
    other = (
        normal[1] * one[2] - normal[2] * one[1],
        normal[2] * one[0] - normal[0] * one[2],
        normal[0] * one[1] - normal[1] * one[0],
    )
    return one, other


@compiled
def _widest_gap(
    cells: Cells,
    place: Vector,
    i: int,
    normals: Array,
    seated: Mask,
    one: Vector,
    other: Vector,
    reach: float,
    angles: Array,
) -> tuple[float, float, int]:
    """Where the widest gap around a particle begins, how wide it is, and the steps that it is divided into.

    Without room for a particle there is one step, and without neighbors there are seven: six particles around.
    """
    own, count = row_of(normals, i), 0
    top, bottom, front, back, left, right = cells_around(cells, place[0], place[1], place[2], reach)
    for plane in range(top, bottom + 1):
        for row in range(front, back + 1):
            start, end = row_of_cells(cells, plane, row, left, right)
            for k in range(start, end):
                j = cells.order[k]
                if j != i and seated[j] and count < _MOST_NEIGHBORS and faces_alike(own, row_of(normals, j)):
                    away = difference((cells.z[k], cells.y[k], cells.x[k]), place)
                    if dot(away, away) < reach * reach:
                        angles[count] = np.arctan2(dot(away, other), dot(away, one))
                        count += 1
    if count == 0:
        return 0.0, 7.0 * _STEP, 7
    around = np.sort(angles[:count])
    begin, gap = around[count - 1], around[0] + 2.0 * np.pi - around[count - 1]
    for n in range(count - 1):
        if around[n + 1] - around[n] > gap:
            begin, gap = around[n], around[n + 1] - around[n]
    if gap < _WIDEST_GAP:
        return 0.0, 0.0, 1
    return begin, gap, max(2, int(gap / _STEP + _ROUNDING))


@compiled
def _inside(place: Vector, shape: tuple[int, int, int], pitch: Vector) -> bool:
    """Whether a place lies between the centers of the outermost voxels."""
    inside = True
    for axis in range(3):
        inside = inside and 0.0 <= place[axis] <= (shape[axis] - 1) * pitch[axis]
    return inside


@compiled
def _is_taken(cells: Cells, place: Vector, normal: Vector, normals: Array, room: float) -> bool:
    """Whether a particle is too near to a place: one of its sheet, or one at nearly the same place."""
    top, bottom, front, back, left, right = cells_around(cells, place[0], place[1], place[2], room)
    for plane in range(top, bottom + 1):
        for row in range(front, back + 1):
            start, end = row_of_cells(cells, plane, row, left, right)
            for k in range(start, end):
                away = length(difference((cells.z[k], cells.y[k], cells.x[k]), place))
                if away < room:
                    alike = faces_alike(normal, row_of(normals, cells.order[k]))
                    if alike or away < _SAME_PLACE:
                        return True
    return False


def apart(places: Array, room: float, cells: Cells) -> Mask:
    """Which of some places stay, shape (M,), so that none has an earlier one of its sheet nearer than `room`.

    `places`, shape (M, 6) or more, are positions and normals; `cells` tells the volume.
    """
    kept = np.ones(len(places), np.bool_)
    if len(places):
        head = np.full(1 << (2 * len(places)).bit_length(), -1, np.int32)
        _keep_apart(places, room, cells.size, (cells.planes, cells.rows, cells.cols), head, kept)
    return kept


@compiled
def _keep_apart(
    places: Array, room: float, size: float, counts: tuple[int, int, int], head: NDArray[np.int32], kept: Mask
) -> None:
    """Drop the places that have an earlier one near them.

    `head`, as long as a power of two, begins chains of those kept; the cells share them.
    """
    planes, rows, cols = counts
    last = len(head) - 1
    chain = np.empty(len(places), np.int32)
    for q in range(len(places)):
        z, y, x = places[q, 0], places[q, 1], places[q, 2]
        for plane in range(cell_of(z - room, size, planes), cell_of(z + room, size, planes) + 1):
            for row in range(cell_of(y - room, size, rows), cell_of(y + room, size, rows) + 1):
                for col in range(cell_of(x - room, size, cols), cell_of(x + room, size, cols) + 1):
                    k = head[((plane * rows + row) * cols + col) & last]
                    while k >= 0 and kept[q]:
                        away = np.sqrt((places[k, 0] - z) ** 2 + (places[k, 1] - y) ** 2 + (places[k, 2] - x) ** 2)
                        if away < room and faces_alike(
                            (places[q, 3], places[q, 4], places[q, 5]), (places[k, 3], places[k, 4], places[k, 5])
                        ):
                            kept[q] = False
                        k = chain[k]
        if kept[q]:
            own = (cell_of(z, size, planes) * rows + cell_of(y, size, rows)) * cols + cell_of(x, size, cols)
            chain[q], head[own & last] = head[own & last], q
