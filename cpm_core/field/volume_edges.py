"""The edge map of a volume, kept only where particles feel it: in bricks of voxels that contain edges."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from cpm_core.field.interpolation import trilinear_mean, voxel_before
from cpm_core.numerics.grids import Labels
from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import Vector

SLOPE_ONSET = 0.5
"""Edge strength, as a fraction of the floor, at which the slope of the edge map begins to count."""

_BRICK_SIDE = 8
"""Number of voxels along the side of a brick."""

_BRICK_MARGIN = 3
"""Number of voxels around one that counts in which the edge map is kept: two units and a voxel."""

PLANES_PER_THREAD = 8
"""Number of planes or rows that are worth a thread."""

_WHOLE_VOLUME = np.ones((0, 0, 0), bool)
"""Empty mask of interest, which stands for all voxels."""


class VolumeSlopes(NamedTuple):
    """Smoothed volume, shape (P, R, C), from which edge strengths are computed.

    Differences of voxels two apart are multiplied with the factors of their axes; `inside` are the voxels that have an
    edge strength, all if it is empty.
    """

    smoothed: Single
    factors: tuple[np.float32, np.float32, np.float32]
    inside: Mask

    @classmethod
    def from_volume(cls, smoothed: Single, pitch: Vector, inside: Mask | None = None) -> VolumeSlopes:
        """Make slopes from a smoothed volume, shape (P, R, C), with voxels of these sides [units]."""
        plane, row, col = (np.float32(0.5 / side) for side in pitch)
        return cls(smoothed, (plane, row, col), _WHOLE_VOLUME if inside is None else inside)

    def edge_strengths(self, first: int = 0, end: int | None = None) -> Single:
        """Return the edge strength in some planes, shape (P, R, C), by central differences [gray levels / unit]."""
        planes = range(self.smoothed.shape[0])[first:end]
        out = np.empty((len(planes), *self.smoothed.shape[1:]), np.float32)
        run_in_parallel(partial(_write_strengths, self, planes.start, out), len(out), PLANES_PER_THREAD)
        return out


class EdgeBricks(NamedTuple):
    """Edge map of a volume in bricks; a plain tuple for the compiled loops.

    A brick begins at every eighth voxel along each axis, with a number that is -1 where no edge is near. Its values,
    shape (M, 9, 9, 9), include those of the next voxel along each axis, to interpolate between them.
    """

    planes: int
    rows: int
    cols: int
    number: Labels
    values: Single

    @classmethod
    def from_slopes(cls, slopes: VolumeSlopes, floor: float) -> EdgeBricks:
        """Build the edge map around the voxels where the force of edges of strength `floor` begins to count."""
        planes, rows, cols = slopes.smoothed.shape
        seen = np.zeros([-(-n // _BRICK_SIDE) for n in (planes, rows, cols)], bool)
        run_in_parallel(partial(_mark_bricks, slopes, np.float32(SLOPE_ONSET * floor), seen), planes, PLANES_PER_THREAD)
        number = np.where(seen, np.cumsum(seen).reshape(seen.shape) - 1, -1).astype(np.int32)
        values = np.empty((np.count_nonzero(seen), *(_BRICK_SIDE + 1,) * 3), np.float32)
        run_in_parallel(partial(_fill_bricks, slopes, number, values), len(seen), 1)
        return cls(planes, rows, cols, number, values)

    def voxels_above(self, floor: float) -> Index:
        """Return the voxels, shape (M, 3), in order, whose edge strength is at least `floor`."""
        voxels = np.empty((_collect_voxels_above(self, np.float32(floor), np.empty((0, 3), np.int64)), 3), np.int64)
        _collect_voxels_above(self, np.float32(floor), voxels)
        return voxels

    def strengths_at(self, pitch: Vector, places: Array) -> Array:
        """Return the edge strength, shape (N,), at places, shape (N, 3) [units]."""
        out = np.empty(len(places))
        _write_strengths_at(self, pitch, places, out)
        return out


@compiled
def _write_strengths(slopes: VolumeSlopes, plane: int, out: Single, first: int, end: int) -> None:
    """Write the strengths of some of the planes from a given one on."""
    for i in range(first, end):
        for j in range(out.shape[1]):
            _write_row_strengths(slopes, plane + i, j, out[i, j])


@compiled
def _write_row_strengths(slopes: VolumeSlopes, i: int, j: int, out: Single) -> None:
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
def _mark_bricks(slopes: VolumeSlopes, least: np.float32, seen: Mask, first: int, end: int) -> None:
    """Mark the bricks around the voxels of some planes that are at or above a strength."""
    line = np.empty(slopes.smoothed.shape[2], np.float32)
    planes, rows, cols = seen.shape
    for i in range(first, end):
        for j in range(slopes.smoothed.shape[1]):
            _write_row_strengths(slopes, i, j, line)
            for k in range(len(line)):
                if line[k] >= least:
                    for p in range(
                        max(i - _BRICK_MARGIN, 0) // _BRICK_SIDE, min((i + _BRICK_MARGIN) // _BRICK_SIDE + 1, planes)
                    ):
                        for r in range(
                            max(j - _BRICK_MARGIN, 0) // _BRICK_SIDE, min((j + _BRICK_MARGIN) // _BRICK_SIDE + 1, rows)
                        ):
                            for c in range(
                                max(k - _BRICK_MARGIN, 0) // _BRICK_SIDE,
                                min((k + _BRICK_MARGIN) // _BRICK_SIDE + 1, cols),
                            ):
                                seen[p, r, c] = True


@compiled
def _fill_bricks(slopes: VolumeSlopes, number: Labels, values: Single, first: int, end: int) -> None:
    """Write the strengths in some planes of bricks."""
    planes, rows, cols = slopes.smoothed.shape
    line = np.empty(cols, np.float32)
    for p in range(first, end):
        for r in range(number.shape[1]):
            if number[p, r].max() < 0:
                continue
            for a in range(_BRICK_SIDE + 1):
                for b in range(_BRICK_SIDE + 1):
                    _write_row_strengths(
                        slopes, min(_BRICK_SIDE * p + a, planes - 1), min(_BRICK_SIDE * r + b, rows - 1), line
                    )
                    for c in range(number.shape[2]):
                        if number[p, r, c] >= 0:
                            for d in range(_BRICK_SIDE + 1):
                                values[number[p, r, c], a, b, d] = line[min(_BRICK_SIDE * c + d, cols - 1)]


@compiled
def _collect_voxels_above(edges: EdgeBricks, floor: np.float32, voxels: Index) -> int:
    """Write the voxels at or above a strength as far as there is room; return their number."""
    count = 0
    for i in range(edges.planes):
        for j in range(edges.rows):
            line = edges.number[i // _BRICK_SIDE, j // _BRICK_SIDE]
            for c in range(len(line)):
                if line[c] >= 0:
                    here = edges.values[line[c], i % _BRICK_SIDE, j % _BRICK_SIDE]
                    for d in range(min(_BRICK_SIDE, edges.cols - _BRICK_SIDE * c)):
                        if here[d] >= floor:
                            if count < len(voxels):
                                voxels[count, 0], voxels[count, 1], voxels[count, 2] = i, j, _BRICK_SIDE * c + d
                            count += 1
    return count


@inlined
def edge_at(edges: EdgeBricks, pitch: Vector, place: Vector) -> float:
    """Return the edge strength at a place [units]; 0 where no edge is near."""
    i, z = voxel_before(edges.planes, place[0] / pitch[0])
    j, y = voxel_before(edges.rows, place[1] / pitch[1])
    k, x = voxel_before(edges.cols, place[2] / pitch[2])
    n = edges.number[i // _BRICK_SIDE, j // _BRICK_SIDE, k // _BRICK_SIDE]
    return (
        trilinear_mean(edges.values[n], (i % _BRICK_SIDE, z), (j % _BRICK_SIDE, y), (k % _BRICK_SIDE, x))
        if n >= 0
        else 0.0
    )


@compiled
def _write_strengths_at(edges: EdgeBricks, pitch: Vector, places: Array, out: Array) -> None:
    for i in range(len(places)):
        out[i] = edge_at(edges, pitch, (places[i, 0], places[i, 1], places[i, 2]))
