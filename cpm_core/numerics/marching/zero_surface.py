"""The surface on which a volume passes through zero, as triangles: closed, oriented and manifold by construction."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.marching.cube_table import EDGES, triangles_by_case
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Single

_LEAST_PLANES = 8
"""Planes that one thread takes at least."""

_NEAREST = 1e-3
"""Distance that a vertex keeps from the voxels at the ends of its edge, so that no triangle is without area."""

_ENDS: Index = np.array([[lower, {4: 0, 2: 1, 1: 2}[upper - lower]] for lower, upper in EDGES])
"""Lower corner and axis of each edge."""


def zero_surface(values: Single, inner: tuple[tuple[int, int], ...] | None = None) -> tuple[Array, Index]:
    """Vertices [voxels], shape (N, 3), and triangles, shape (F, 3), of the surface around the voxels above zero.

    Seen from outside, triangles run counter-clockwise. Voxels have 26 neighbors inside and 6 outside (`cube_table`).
    `inner` tells the range of voxels to consider along each axis; the surface is open where it leaves that range.
    """
    within = tuple(slice(a, b) for a, b in inner or [(0, size) for size in values.shape])
    begin = np.array([part.start for part in within], float)
    part = values[within]
    table, counts = triangles_by_case()
    planes, rows, cols = part.shape
    crossed, filled = np.zeros((2, planes, rows), np.int64)
    share(lambda a, b: _count(part, counts, crossed, filled, a, b), planes, _LEAST_PLANES)
    vertex, face = _beginnings(crossed), _beginnings(filled)
    places, faces = np.empty((crossed.sum(), 3)), np.empty((filled.sum(), 3), np.int64)

    def fill(first: int, last: int) -> None:
        numbers = np.empty((2, 3, rows, cols), np.int64)
        _fill(part, table, counts, _ENDS, crossed, filled, vertex, face, numbers, places, faces, first, last)

    share(fill, planes, _LEAST_PLANES)
    places += begin
    return places, faces


def _beginnings(counts: Index) -> Index:
    """Number of the first vertex or triangle of each line of voxels."""
    return np.concatenate([[0], np.cumsum(counts)[:-1]]).reshape(counts.shape)


@inlined
def _moved(values: Single, case: int, p: int, r: int, c: int) -> int:
    """Case of the cube that ends at a column, from that of the cube before it."""
    case = case >> 1 & 0x55
    if values[p, r, c] > 0.0:
        case |= 2
    if values[p, r + 1, c] > 0.0:
        case |= 8
    if values[p + 1, r, c] > 0.0:
        case |= 32
    if values[p + 1, r + 1, c] > 0.0:
        case |= 128
    return case


@compiled
def _count(values: Single, counts: Index, crossed: Index, filled: Index, first: int, last: int) -> None:
    """Numbers of vertices, and of triangles, that belong to each line of voxels: those on edges and in cubes there."""
    planes, rows, cols = values.shape
    for p in range(first, last):
        for r in range(rows):
            found = made = case = 0
            for c in range(cols - 1):
                found += (values[p, r, c] > 0.0) != (values[p, r, c + 1] > 0.0)
            if r + 1 < rows:
                for c in range(cols):
                    found += (values[p, r, c] > 0.0) != (values[p, r + 1, c] > 0.0)
            if p + 1 < planes:
                for c in range(cols):
                    found += (values[p, r, c] > 0.0) != (values[p + 1, r, c] > 0.0)
            if p + 1 < planes and r + 1 < rows:
                for c in range(cols):
                    case = _moved(values, case, p, r, c)
                    made += counts[case] if c else 0
            crossed[p, r], filled[p, r] = found, made


@compiled
def _number(values: Single, p: int, crossed: Index, vertex: Index, numbers: Index, places: Array, own: bool) -> None:
    """Number the vertices of a plane, and place them if they belong to the caller."""
    planes, rows, cols = values.shape
    for r in range(rows):
        number = vertex[p, r]
        for c in range(cols if crossed[p, r] else 0):
            here = values[p, r, c]
            for axis in range(3):
                q, s, t = p + (axis == 0), r + (axis == 1), c + (axis == 2)
                if q < planes and s < rows and t < cols:
                    there = values[q, s, t]
                    if (here > 0.0) != (there > 0.0):
                        numbers[axis, r, c] = number
                        if own:
                            way = min(max(here / (here - there), _NEAREST), 1.0 - _NEAREST)
                            places[number, 0] = p + way * (axis == 0)
                            places[number, 1] = r + way * (axis == 1)
                            places[number, 2] = c + way * (axis == 2)
                        number += 1


@compiled
def _fill(
    values: Single,
    table: Index,
    counts: Index,
    ends: Index,
    crossed: Index,
    filled: Index,
    vertex: Index,
    face: Index,
    numbers: Index,
    places: Array,
    faces: Index,
    first: int,
    last: int,
) -> None:
    """Vertices and triangles of some planes; `numbers` holds the vertices of two planes by axis, row and column."""
    planes, rows, cols = values.shape
    _number(values, first, crossed, vertex, numbers[first & 1], places, True)
    for p in range(first, last):
        if p + 1 < planes:
            _number(values, p + 1, crossed, vertex, numbers[(p + 1) & 1], places, p + 1 < last)
        for r in range(rows):
            case, number = 0, face[p, r]
            for c in range(cols if filled[p, r] else 0):
                case = _moved(values, case, p, r, c)
                for k in range(counts[case] if c else 0):
                    for corner in range(3):
                        edge = table[case, k, corner]
                        low, axis = ends[edge, 0], ends[edge, 1]
                        plane, row, col = low >> 2, r + (low >> 1 & 1), c - 1 + (low & 1)
                        faces[number, corner] = numbers[(p + plane) & 1, axis, row, col]
                    number += 1
