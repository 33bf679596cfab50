"""The Lorentz force on a particle in a volume, and the ridge of the edge map next to it.

Far from edges it is the unit vector of the field. On an edge the field along the normal changes its sign over a
fraction of a voxel, and its part along the edge leads to stronger parts. There the relative slope of the edge map takes
its place, ``n (f+ - f-) / (f+ + f-)``, with the edge strength one unit ahead and behind along the normal ``n`` of the
smoothed volume: it has nearly unit size on the flank and falls linearly through zero on the ridge. No normalization is
needed, and the low resolution of the far field does not matter.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from cpm_core.field.interpolation import interpolate_field, normal_at, value_at
from cpm_core.numerics.grids import find_root, renumber_groups
from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import Vector, dot, move_along, row_lengths, row_of, scale_vector, set_row, vector_length

ON_RIDGE_SLOPE = 0.45
"""Relative slope of the edge map under which a particle on an edge is on its ridge."""

_RIDGE_SAMPLE_OFFSET = 0.7
"""Distance of the two samples next to a ridge [units]."""

_MAX_RIDGE_STEP = 0.6
"""Longest step towards the ridge [units]."""

_MIN_RIDGE_STEP = 0.01
"""Step after which the ridge is reached [units]."""


SLOPE_ONSET = 0.5
"""Edge strength, as a fraction of the floor, at which the slope of the edge map begins to count."""


@inlined
def edge_at(edges: Single, pitch: Vector, place: Vector) -> float:
    """Return the edge strength at a place [units]."""
    return value_at(edges, place[0] / pitch[0], place[1] / pitch[1], place[2] / pitch[2])


@compiled
def volume_force_at(
    smoothed: Single, edges: Single, far: Single, pitch: Vector, block: Vector, floor: float, place: Vector
) -> tuple[Vector, Vector, float, float, float]:
    """Return force, normal, edge strength and relative slope of the edge map at a place, and the slope's weight."""
    normal = normal_at(smoothed, pitch, place)
    here = edge_at(edges, pitch, place)
    ahead = edge_at(edges, pitch, move_along(place, 1.0, normal))
    behind = edge_at(edges, pitch, move_along(place, -1.0, normal))
    slope = (ahead - behind) / (ahead + behind + 1e-30)
    near = min(max((max(here, ahead, behind) / floor - SLOPE_ONSET) / (1.0 - SLOPE_ONSET), 0.0), 1.0)
    force = scale_vector(normal, near * slope)
    if near < 1.0:
        away = far_field_at(far, pitch, block, place)
        force = move_along(force, (1.0 - near) / (vector_length(away) + 1e-30), away)
    return force, normal, here, slope, near


@compiled
def force_on_voxels(
    smoothed: Single,
    edges: Single,
    far: Single,
    pitch: Vector,
    block: Vector,
    floor: float,
    first: int,
    last: int,
    out: Single,
) -> None:
    """Write `volume_force_at` of the voxels of some planes into `out`, shape (3, P, R, C)."""
    for i in range(first, last):
        for j in range(edges.shape[1]):
            for k in range(edges.shape[2]):
                place = (i * pitch[0], j * pitch[1], k * pitch[2])
                force = volume_force_at(smoothed, edges, far, pitch, block, floor, place)[0]
                out[0, i, j, k], out[1, i, j, k], out[2, i, j, k] = force


@compiled
def far_field_at(far: Single, pitch: Vector, block: Vector, place: Vector) -> Vector:
    """Interpolate the field of the fixed charges, shape (3, P, R, C) of blocks, at a place [units]."""
    z = (place[0] / pitch[0] + 0.5) / block[0] - 0.5
    y = (place[1] / pitch[1] + 0.5) / block[1] - 0.5
    x = (place[2] / pitch[2] + 0.5) / block[2] - 0.5
    return value_at(far[0], z, y, x), value_at(far[1], z, y, x), value_at(far[2], z, y, x)


@compiled
def project_to_ridge(smoothed: Single, edges: Single, pitch: Vector, place: Vector, rounds: int) -> Vector:
    """Project a place onto the ridge of the edge map along the normal: the top of a parabola, repeated."""
    for _ in range(rounds):
        normal = normal_at(smoothed, pitch, place)
        here = edge_at(edges, pitch, place)
        ahead = edge_at(edges, pitch, move_along(place, _RIDGE_SAMPLE_OFFSET, normal))
        behind = edge_at(edges, pitch, move_along(place, -_RIDGE_SAMPLE_OFFSET, normal))
        bend = ahead - 2.0 * here + behind
        step = _RIDGE_SAMPLE_OFFSET * (-0.5 * (ahead - behind) / bend if bend < 0.0 else np.sign(ahead - behind))
        step = min(max(step, -_MAX_RIDGE_STEP), _MAX_RIDGE_STEP)
        place = move_along(place, step, normal)
        if abs(step) < _MIN_RIDGE_STEP:
            break
    return place


@compiled
def is_ridge(smoothed: Single, edges: Single, pitch: Vector, place: Vector, reach: float) -> bool:
    """Return whether the edge is nowhere stronger at a distance along the normal, to either side."""
    normal = normal_at(smoothed, pitch, place)
    here = edge_at(edges, pitch, place)
    return bool(
        edge_at(edges, pitch, move_along(place, reach, normal)) <= here
        and edge_at(edges, pitch, move_along(place, -reach, normal)) <= here
    )


def project_all_to_ridge(smoothed: Single, edges: Single, pitch: Vector, places: Array, rounds: int) -> Array:
    """Project places, shape (N, 3), onto the ridge; see `project_to_ridge`."""
    out = np.empty_like(places)
    run_in_parallel(
        partial(_project_some, smoothed, edges, pitch, places, rounds, out), len(places), _RIDGE_VOXELS_PER_THREAD
    )
    return out


@compiled
def _project_some(
    smoothed: Single, edges: Single, pitch: Vector, places: Array, rounds: int, out: Array, first: int, last: int
) -> None:
    for i in range(first, last):
        set_row(out, i, project_to_ridge(smoothed, edges, pitch, row_of(places, i), rounds))


@compiled
def face_same_way(one: Vector, other: Vector) -> bool:
    """Return whether two normals face the same way; those of the two walls of a thin object point apart."""
    return dot(one, other) > 0.0


_RIDGE_TEST_DISTANCE = 1.0
"""Distance along the normal at which the edge must not be stronger, to either side [units]."""

_RIDGE_VOXELS_PER_THREAD = 5_000
"""Voxels from which a second thread makes the search faster."""


class Ridges(NamedTuple):
    """Voxels on the ridges of an edge map where it is at or above its floor.

    Their positions [units] and the normals of the surface there, shape (M, 3), with the edge strength and the number,
    from 0, of the connected part of the edge map.
    """

    place: Array
    normal: Array
    strength: Array
    component: Index

    def select(self, index: Index) -> Ridges:
        """Select the voxels with the given indices, shape (K,), in this order."""
        return Ridges(self.place[index], self.normal[index], self.strength[index], self.component[index])


def find_ridges(smoothed: Single, edges: Single, pitch: Vector, floor: float, turn: float) -> Ridges:
    """Find all ridges of the edge map of a smoothed volume, shape (P, R, C).

    A voxel is connected with those of the 26 around it that have a normal like its own: the scalar product is at least
    `turn`, so that walls of two objects that nearly touch each other stay apart.
    """
    voxels, last = np.argwhere(edges >= np.float32(floor)), np.array(smoothed.shape) - 1
    count, slope = len(voxels), np.empty((len(voxels), 3))
    for axis, step in enumerate(np.eye(3, dtype=int)):
        ahead, behind = np.minimum(voxels + step, last), np.maximum(voxels - step, 0)
        slope[:, axis] = (smoothed[tuple(ahead.T)] - smoothed[tuple(behind.T)]) / pitch[axis]
    component = _label_similar_normals(voxels, slope, row_lengths(slope), turn, smoothed.shape[1:])
    place = voxels * np.array(pitch)
    normal, ridge = np.empty((count, 3)), np.empty(count, bool)
    run_in_parallel(
        partial(_find_ridge_voxels, smoothed, edges, pitch, place, normal, ridge), count, _RIDGE_VOXELS_PER_THREAD
    )
    place = place[ridge]
    return Ridges(place, normal[ridge], interpolate_field(edges[None], place / pitch)[:, 0], component[ridge])


@compiled
def _label_similar_normals(voxels: Index, slope: Array, size: Array, turn: float, shape: tuple[int, int]) -> Index:
    """Label the part of each voxel in order; two planes of numbers suffice to find the neighbors before it."""
    group = np.arange(len(voxels))
    window = np.full((2, shape[0] + 2, shape[1] + 2), -1, np.int32)
    plane = -1
    for q in range(len(voxels)):
        p, r, c = voxels[q]
        if p != plane:
            window[p % 2].fill(-1)
            if p != plane + 1:
                window[(p + 1) % 2].fill(-1)
            plane = p
        for n in range(13):  # the other half of the 26 come later
            other = window[(p + n // 9 + 1) % 2, r + n // 3 % 3, c + n % 3]
            if other >= 0:
                product = dot(row_of(slope, q), row_of(slope, other))
                if turn <= -1.0 or product >= turn * size[q] * size[other]:
                    one, two = find_root(group, q), find_root(group, other)
                    group[max(one, two)] = min(one, two)
        window[p % 2, r + 1, c + 1] = q
    renumber_groups(group)
    return group


@compiled
def _find_ridge_voxels(
    smoothed: Single,
    edges: Single,
    pitch: Vector,
    place: Array,
    normal: Array,
    ridge: Mask,
    first: int,
    last: int,
) -> None:
    """Write the normal at each voxel, and whether it is on a ridge."""
    for q in range(first, last):
        here = (place[q, 0], place[q, 1], place[q, 2])
        set_row(normal, q, normal_at(smoothed, pitch, here))
        ridge[q] = is_ridge(smoothed, edges, pitch, here, _RIDGE_TEST_DISTANCE)
