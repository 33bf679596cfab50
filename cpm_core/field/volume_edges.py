"""The edge map of a volume, kept only where particles feel it: in bricks of voxels in which there are edges."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from cpm_core.field.interpolation import between_voxels, mean_of_eight
from cpm_core.numerics.grids import Labels
from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import Vector

HALF_NEAR = 0.5
"""Edge strength, as a fraction of the floor, at which the slope of the edge map begins to count."""

_SIDE, _REACH = 8, 3
"""Voxels along the side of a brick, and how far from one that counts the edge map is kept: two units and a voxel."""

_LEAST_LINES = 8
"""Planes that are worth a thread."""

_EVERYWHERE = np.ones((0, 0, 0), bool)
"""The mask of what is of interest where everything is."""


class Slopes(NamedTuple):
    """What edge strengths are computed from: a smoothed volume, shape (P, R, C).

    Differences of voxels two apart are multiplied with the factors of their axes; `inside` are the voxels that have an
    edge strength, all if it is empty.
    """

    smoothed: Single
    factors: tuple[np.float32, np.float32, np.float32]
    inside: Mask

    @classmethod
    def of(cls, smoothed: Single, pitch: Vector, inside: Mask | None = None) -> Slopes:
        """Those of a smoothed volume with voxels of these sides [units]."""
        plane, row, col = (np.float32(0.5 / side) for side in pitch)
        return cls(smoothed, (plane, row, col), _EVERYWHERE if inside is None else inside)

    def strengths(self, first: int = 0, end: int | None = None) -> Single:
        """Size of the slope at the voxels of some planes, from central differences [gray levels / unit]."""
        planes = range(self.smoothed.shape[0])[first:end]
        out = np.empty((len(planes), *self.smoothed.shape[1:]), np.float32)
        share(partial(_strengths, self, planes.start, out), len(out), _LEAST_LINES)
        return out


class Edges(NamedTuple):
    """The edge map of a volume in bricks; a plain tuple for the compiled loops.

    A brick begins at every eighth voxel along each axis, with a number that is -1 where no edge is near. Its values,
    shape (M, 9, 9, 9), include those of the next voxel along each axis, to interpolate between them.
    """

    planes: int
    rows: int
    cols: int
    number: Labels
    values: Single

    @classmethod
    def of(cls, slopes: Slopes, floor: float) -> Edges:
        """The edge map around the voxels where the force of edges of at least this strength begins to count."""
        planes, rows, cols = slopes.smoothed.shape
        seen = np.zeros([-(-n // _SIDE) for n in (planes, rows, cols)], bool)
        share(partial(_mark, slopes, np.float32(HALF_NEAR * floor), seen), planes, _LEAST_LINES)
        number = np.where(seen, np.cumsum(seen).reshape(seen.shape) - 1, -1).astype(np.int32)
        values = np.empty((np.count_nonzero(seen), *(_SIDE + 1,) * 3), np.float32)
        share(partial(_fill, slopes, number, values), len(seen), 1)
        return cls(planes, rows, cols, number, values)

    def above(self, floor: float) -> Index:
        """The voxels, shape (M, 3), in their order, with edges of at least this strength."""
        voxels = np.empty((_above(self, np.float32(floor), np.empty((0, 3), np.int64)), 3), np.int64)
        _above(self, np.float32(floor), voxels)
        return voxels

    def at(self, pitch: Vector, places: Array) -> Array:
        """Edge strength at places, shape (N, 3) [units]."""
        out = np.empty(len(places))
        _at(self, pitch, places, out)
        return out


@compiled
def _strengths(slopes: Slopes, plane: int, out: Single, first: int, end: int) -> None:
    """Write the strengths of some of the planes from a given one on."""
    for i in range(first, end):
        for j in range(out.shape[1]):
            _strengths_of_row(slopes, plane + i, j, out[i, j])


@compiled
def _strengths_of_row(slopes: Slopes, i: int, j: int, out: Single) -> None:
    """Write the strengths of a row of voxels."""
    smoothed, (plane, row, col), inside = slopes
    planes, rows, cols = smoothed.shape
    above, below = smoothed[max(i - 1, 0), j], smoothed[min(i + 1, planes - 1), j]
    before, here, after = smoothed[i, max(j - 1, 0)], smoothed[i, j], smoothed[i, min(j + 1, rows - 1)]
    for k in range(cols):
        down, back = (below[k] - above[k]) * plane, (after[k] - before[k]) * row
        right = (here[min(k + 1, cols - 1)] - here[max(k - 1, 0)]) * col
        out[k] = np.sqrt(down * down + back * back + right * right)
    if len(inside):
        for k in range(cols):
            out[k] *= inside[i, j, k]


@compiled
def _mark(slopes: Slopes, least: np.float32, seen: Mask, first: int, end: int) -> None:
    """Mark the bricks around the voxels of some planes that are at or above a strength."""
    line = np.empty(slopes.smoothed.shape[2], np.float32)
    planes, rows, cols = seen.shape
    for i in range(first, end):
        for j in range(slopes.smoothed.shape[1]):
            _strengths_of_row(slopes, i, j, line)
            for k in range(len(line)):
                if line[k] >= least:
                    for p in range(max(i - _REACH, 0) // _SIDE, min((i + _REACH) // _SIDE + 1, planes)):
                        for r in range(max(j - _REACH, 0) // _SIDE, min((j + _REACH) // _SIDE + 1, rows)):
                            for c in range(max(k - _REACH, 0) // _SIDE, min((k + _REACH) // _SIDE + 1, cols)):
                                seen[p, r, c] = True


@compiled
def _fill(slopes: Slopes, number: Labels, values: Single, first: int, end: int) -> None:
    """Write the strengths in some planes of bricks."""
    planes, rows, cols = slopes.smoothed.shape
    line = np.empty(cols, np.float32)
    for p in range(first, end):
        for r in range(number.shape[1]):
            if number[p, r].max() < 0:
                continue
            for a in range(_SIDE + 1):
                for b in range(_SIDE + 1):
                    _strengths_of_row(slopes, min(_SIDE * p + a, planes - 1), min(_SIDE * r + b, rows - 1), line)
                    for c in range(number.shape[2]):
                        if number[p, r, c] >= 0:
                            for d in range(_SIDE + 1):
                                values[number[p, r, c], a, b, d] = line[min(_SIDE * c + d, cols - 1)]


@compiled
def _above(edges: Edges, floor: np.float32, voxels: Index) -> int:
    """Write the voxels at or above a strength as far as there is room; return their number."""
    count = 0
    for i in range(edges.planes):
        for j in range(edges.rows):
            line = edges.number[i // _SIDE, j // _SIDE]
            for c in range(len(line)):
                if line[c] >= 0:
                    here = edges.values[line[c], i % _SIDE, j % _SIDE]
                    for d in range(min(_SIDE, edges.cols - _SIDE * c)):
                        if here[d] >= floor:
                            if count < len(voxels):
                                voxels[count, 0], voxels[count, 1], voxels[count, 2] = i, j, _SIDE * c + d
                            count += 1
    return count


@inlined
def edge_at(edges: Edges, pitch: Vector, place: Vector) -> float:
    """Edge strength at a place [units]; 0 where no edge is near."""
    i, z = between_voxels(edges.planes, place[0] / pitch[0])
    j, y = between_voxels(edges.rows, place[1] / pitch[1])
    k, x = between_voxels(edges.cols, place[2] / pitch[2])
    n = edges.number[i // _SIDE, j // _SIDE, k // _SIDE]
    return mean_of_eight(edges.values[n], (i % _SIDE, z), (j % _SIDE, y), (k % _SIDE, x)) if n >= 0 else 0.0


@compiled
def _at(edges: Edges, pitch: Vector, places: Array, out: Array) -> None:
    for i in range(len(places)):
        out[i] = edge_at(edges, pitch, (places[i, 0], places[i, 1], places[i, 2]))
