"""Insertion and deletion of particles on a surface in a volume.

Between: two seated particles of one sheet at ``d_min < d <= d_min + d_max``, with no other one of it in the ball whose
diameter they are, get one at their midpoint, pulled to the ridge of the edge map. Annealing ends this rule.

Ahead: a seated particle sorts its neighbors on the same sheet by their direction in the tangent plane. A gap between
two of them is divided into steps of about 60 degrees, and each step is a place for a new particle, ``0.9 d_min`` ahead,
pulled to the ridge of the edge map: there must be an edge that is strong enough, not turned to another sheet, and room.

A new particle has crept as far as the one that it is next to and the way from there, no farther than the creeping
range.

Of two particles of one sheet nearer than half of ``d_min`` one is deleted, as in the plane.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from cpm_core.field.interpolation import normal_at
from cpm_core.field.placed_charges import NO_PLACED_CHARGES, ChargesAtScale, find_torn_off
from cpm_core.field.scale_field import EDGE_END_FRACTION
from cpm_core.field.volume_field import VolumeField
from cpm_core.field.volume_surface import edge_at, face_same_way, is_ridge, project_to_ridge
from cpm_core.model.equations import DELETION_DISTANCE
from cpm_core.model.volume.motion import (
    VolumeCells,
    act_on_each_other,
    find_near,
    near_buffer,
    on_same_surface,
)
from cpm_core.model.volume.state import VolumeParticles
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import (
    Vector,
    dot,
    keep_apart,
    move_along,
    row_lengths,
    row_of,
    scale_vector,
    subtract_vectors,
    vector_length,
)

_CLOSE_PER_THREAD = 2_000
"""Particles from which a second thread makes the search faster."""


def select_surface_survivors(particles: VolumeParticles, cells: VolumeCells, turn: Index, d_min: float) -> Mask:
    """Return a mask, shape (N,), of the particles that stay.

    Of two nearer than ``d_min / 2`` the one on the weaker edge is deleted, and of equal ones the later, unless both are
    on surfaces, on different sheets. Only those of `turn`, shape (K,), have moved since the last use.
    """
    kept = np.ones(len(particles), bool)
    sheets = (particles.position, particles.normal, particles.on_surface)
    run_in_parallel(
        partial(_find_close, cells, turn, *sheets, DELETION_DISTANCE * d_min, kept), len(turn), _CLOSE_PER_THREAD
    )
    close = np.flatnonzero(~kept)
    if len(close):
        order = close[np.argsort(-particles.strength[close], kind="stable")]
        kept[order] = select_spaced(
            particles.position[order], particles.normal[order], DELETION_DISTANCE * d_min, particles.on_surface[order]
        )
    return kept


@compiled
def _find_close(
    cells: VolumeCells,
    turn: Index,
    position: Array,
    normals: Array,
    seated: Mask,
    distance: float,
    alone: Mask,
    first: int,
    last: int,
) -> None:
    """Mark the particles with another one nearer than a distance as not alone; one of each pair has its turn."""
    found = near_buffer(cells)
    for q in range(first, last):
        i = turn[q]
        for n in range(find_near(cells, row_of(position, i), distance, found)):
            j = cells.order[found[n]]
            if j != i and on_same_surface(i, j, normals, seated):
                alone[i] = alone[j] = False


NEW_PARTICLE_ROOM = 0.68
"""Least distance of a new particle from others of its sheet, in d_min."""

INSERTION_STRIDE = 0.9
"""Distance of a position ahead of a particle, in d_min."""

_GAP_NEIGHBOR_RANGE = 1.7
"""Distance up to which neighbors close a gap, in strides."""

_MIN_OPEN_GAP = np.radians(100.0)
"""Gap between the directions of two neighbors from which on there is room between them."""

_GAP_STEP_ANGLE = np.pi / 3.0
"""Angle between new particles in a gap."""

_GAP_ROUNDING = 0.35
"""Fraction of a step from which a gap gets one more particle, subtracted from one."""

_MAX_NEW_AROUND = 6
"""Largest number of new particles around one."""

_MAX_SORTED_NEIGHBORS = 64
"""Largest number of neighbors that are sorted; there are no more on a sheet that deletion keeps thin."""

_MAX_AHEAD_DISTANCE = 1.6
"""Largest distance of a new particle from the one that it is ahead of, in strides."""

_MIN_NORMAL_PRODUCT = -0.5
"""Scalar product of the normals under which the edge ahead belongs to another sheet."""

_OFFER_RIDGE_STEPS = 6
"""Number of steps to the ridge."""

_OFFER_RIDGE_DISTANCE = 0.7
"""Distance at which the edge must be weaker on both sides [units]."""

_ROUNDING_ERROR = 1e-9
"""Tolerance of half the distance of two particles for rounding [units]."""

_SAME_PLACE_DISTANCE = 0.5
"""Distance up to which two particles are in each other's way on any sheets [units]."""

_SURFACE_SEARCHES_PER_THREAD = 100
"""Particles from which a second thread makes the search faster."""

_Sheets = tuple[Array, Array, Mask, Array]
"""Positions of the particles, normals, which are seated, and edge strengths."""

_Edge = tuple[Single, Single, Vector, float]
"""Smoothed volume, edge map, sides of a voxel, and least edge strength."""

_Search = tuple[VolumeCells, Index, _Sheets, _Edge, Array, Index]
"""Cells, room for a crowd in them, sheets, edge, and the places that are found, with their number for each particle."""


class VolumeBirths(NamedTuple):
    """New particles: positions and normals, shape (M, 3), edge strengths and distances crept, shape (M,)."""

    position: Array
    normal: Array
    strength: Array
    crept: Array


def find_surface_insertions(
    particles: VolumeParticles,
    cells: VolumeCells,
    turn: Index,
    field: VolumeField,
    d_min: float,
    d_max: float = 0.0,
    placed: ChargesAtScale = NO_PLACED_CHARGES,
    farthest: float = np.inf,
) -> VolumeBirths:
    """Find places for new particles next to those on surfaces that have their turn, in the order of these.

    `turn`, shape (K,), are indices of particles; `d_max` is the annealed insertion range, `farthest` the creeping range
    [units]. There are no places where placed charges pull particles off the edge.
    """
    looking, looks = turn[particles.on_surface[turn]], np.zeros(len(particles), bool)
    looks[looking] = True
    found, count = np.empty((len(looking), _MAX_NEW_AROUND, 7)), np.zeros(len(looking), np.int64)
    sheets = (particles.position, particles.normal, particles.on_surface, particles.strength)
    edge = (field.smoothed, field.edge_map, field.pitch, field.floor)
    search = partial(_search_places, looking, looks, cells, sheets, edge, d_min, d_min + d_max, found, count)
    run_in_parallel(search, len(looking), _SURFACE_SEARCHES_PER_THREAD)
    places, parents = found[np.arange(_MAX_NEW_AROUND) < count[:, None]], np.repeat(looking, count)
    crept = particles.crept[parents] + row_lengths(places[:, :3] - particles.position[parents])
    free = (crept <= farthest) & ~field.crosses_wall(particles.position[parents], places[:, :3])
    free &= ~find_torn_off(placed, places[:, :3], places[:, 3:6])
    places, crept = places[free], crept[free]
    some = select_spaced(places[:, :3], places[:, 3:6], NEW_PARTICLE_ROOM * d_min)
    position, normal, strength = places[some, :3], places[some, 3:6], places[some, 6]
    return VolumeBirths(position, normal, strength, crept[some])


@compiled
def _search_places(
    looking: Index,
    looks: Mask,
    cells: VolumeCells,
    sheets: _Sheets,
    edge: _Edge,
    d_min: float,
    reach: float,
    found: Array,
    count: Index,
    first: int,
    last: int,
) -> None:
    """Find the places that some particles offer, up to `_MAX_NEW_AROUND` each."""
    angles, others = np.empty(_MAX_SORTED_NEIGHBORS), near_buffer(cells)
    search = cells, near_buffer(cells), sheets, edge, found, count
    for q in range(first, last):
        i = looking[q]
        around = others[
            : find_near(cells, row_of(sheets[0], i), max(_GAP_NEIGHBOR_RANGE * INSERTION_STRIDE * d_min, reach), others)
        ]
        if reach > d_min:
            _look_between(q, i, looks, around, search, d_min, reach)
        _look_ahead(q, i, around, search, d_min, angles)


@compiled
def _look_between(q: int, i: int, looks: Mask, around: Index, search: _Search, d_min: float, reach: float) -> None:
    """Offer the midpoints of a particle and others of its sheet, with nothing between the two."""
    cells, _, (position, normals, seated, _), _, _, _ = search
    place, normal = row_of(position, i), row_of(normals, i)
    for k in around:
        j = cells.order[k]
        if not seated[j] or (looks[j] and j <= i) or not face_same_way(normal, row_of(normals, j)):
            continue
        away = subtract_vectors(row_of(cells.place, k), place)
        distance = vector_length(away)
        if d_min < distance <= reach:
            middle, room = move_along(place, 0.5, away), 0.5 * distance - _ROUNDING_ERROR
            if not _is_taken(cells, around, middle, normal, normals, room):
                _offer_place(q, i, middle, 0.0, distance, room, search)


@compiled
def _look_ahead(q: int, i: int, around: Index, search: _Search, d_min: float, angles: Array) -> None:
    """Offer the places a stride ahead of a particle, in the widest gap between its neighbors."""
    cells, _, (position, normals, seated, _), _, _, _ = search
    place, own, stride, room = (
        row_of(position, i),
        row_of(normals, i),
        INSERTION_STRIDE * d_min,
        NEW_PARTICLE_ROOM * d_min,
    )
    (one, other), reach, count = tangent_vectors(own), _GAP_NEIGHBOR_RANGE * stride, 0
    for k in around:
        away = subtract_vectors(row_of(cells.place, k), place)
        j = cells.order[k]
        near_it = dot(away, away) < reach * reach and j != i and seated[j] and count < _MAX_SORTED_NEIGHBORS
        if near_it and face_same_way(own, row_of(normals, j)):
            angle, at = np.arctan2(dot(away, other), dot(away, one)), count
            while at > 0 and angles[at - 1] > angle:
                angles[at] = angles[at - 1]
                at -= 1
            angles[at] = angle
            count += 1
    begin, gap, steps = 0.0, 7.0 * _GAP_STEP_ANGLE, 7  # without neighbors: six particles around
    if count > 0:
        begin, gap = angles[count - 1], angles[0] + 2.0 * np.pi - angles[count - 1]
        for n in range(count - 1):
            if angles[n + 1] - angles[n] > gap:
                begin, gap = angles[n], angles[n + 1] - angles[n]
        # one step if there is no room for a particle
        steps = max(2, int(gap / _GAP_STEP_ANGLE + _GAP_ROUNDING)) if gap >= _MIN_OPEN_GAP else 1
    for step in range(1, steps):
        angle = begin + gap * step / steps
        ahead = move_along(move_along(place, stride * np.cos(angle), one), stride * np.sin(angle), other)
        _offer_place(q, i, ahead, room, _MAX_AHEAD_DISTANCE * stride, room, search)


@compiled
def _offer_place(q: int, i: int, place: Vector, nearest: float, farthest: float, room: float, search: _Search) -> None:
    """Pull a place to the ridge, and offer it if the edge of the particle continues there and there is room."""
    cells, crowd, (position, normals, _, strength), edge, found, count = search
    smoothed, edges, pitch, floor = edge
    place = project_to_ridge(smoothed, edges, pitch, place, _OFFER_RIDGE_STEPS)
    away = vector_length(subtract_vectors(place, row_of(position, i)))
    here, normal = edge_at(edges, pitch, place), row_of(normals, i)
    fits = nearest <= away <= farthest and here >= max(floor, EDGE_END_FRACTION * strength[i])
    if not fits or count[q] >= _MAX_NEW_AROUND or not _is_inside_volume(place, smoothed.shape, pitch):
        return
    turned = normal_at(smoothed, pitch, place)
    fits = dot(turned, normal) >= _MIN_NORMAL_PRODUCT and is_ridge(smoothed, edges, pitch, place, _OFFER_RIDGE_DISTANCE)
    if fits and not _is_taken(cells, crowd[: find_near(cells, place, room, crowd)], place, turned, normals, room):
        entry = found[q, count[q]]
        for axis in range(3):
            entry[axis], entry[3 + axis] = place[axis], turned[axis]
        entry[6] = here
        count[q] += 1


@compiled
def tangent_vectors(normal: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors across a normal, at right angles to each other; of no length if it has none."""
    one = (0.0, -normal[2], normal[1]) if abs(normal[0]) < 0.7 else (normal[1], -normal[0], 0.0)
    size = vector_length(one)
    one = scale_vector(one, 1.0 / size if size > 0.0 else 0.0)
    other = (
        normal[1] * one[2] - normal[2] * one[1],
        normal[2] * one[0] - normal[0] * one[2],
        normal[0] * one[1] - normal[1] * one[0],
    )
    return one, other


@compiled
def _is_inside_volume(place: Vector, shape: tuple[int, int, int], pitch: Vector) -> bool:
    """Return whether a place lies between the centers of the outermost voxels."""
    inside = True
    for axis in range(3):
        inside = inside and 0.0 <= place[axis] <= (shape[axis] - 1) * pitch[axis]
    return inside


@compiled
def _is_taken(cells: VolumeCells, crowd: Index, place: Vector, normal: Vector, normals: Array, room: float) -> bool:
    """Return whether a place is too near to one of a crowd: one of its sheet, or one at nearly the same place."""
    for k in crowd:
        away = vector_length(subtract_vectors(row_of(cells.place, k), place))
        if away < room and (away < _SAME_PLACE_DISTANCE or face_same_way(normal, row_of(normals, cells.order[k]))):
            return True
    return False


def select_spaced(position: Array, normal: Array, room: float, seated: Mask | None = None) -> Mask:
    """Select places, shape (M,) of shape (M, 3), so that none has an earlier one of its sheet nearer than `room`.

    `seated`, shape (M,), are those that lie on a sheet, by default all; others are in the way of any.
    """
    on_sheet = np.ones(len(position), bool) if seated is None else seated
    return keep_apart(position, room, act_on_each_other(normal, on_sheet))
