"""Seams: contours joined across the borders of chunks.

A contour away from the border of a core belongs to one chunk alone. Of all others each chunk keeps what lies in its
core and a little beyond, so that the pieces of neighbors overlap. Of a stretch that several chunks see, the first one
keeps its own; then the ends of what is left lie next to one another, and are joined.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from cpm_core.chunked.grid import Chunk, outer_limits
from cpm_core.contours.contour import Contour
from cpm_core.numerics.grids import label_joined_pairs
from cpm_core.numerics.types import Array, Extent

_PIECE_MARGIN = 2.0
"""Distance beyond its core up to which a chunk keeps pieces of contours [px]."""

_UNSHARED_MARGIN = 3.0
"""Distance from the border of its core from which on only one chunk sees a contour in or near its core [px]."""

_SAME_BOUNDARY_DISTANCE = 0.5
"""Distance up to which two chunks see the same boundary [px]; in fact they differ by some thousandths."""

_JOINT_DISTANCE = 1.0
"""Distance up to which the ends of two pieces are joined [px]; the distance above is left between them."""


def split_by_core(contours: Sequence[Contour], chunk: Chunk, shape: Extent) -> tuple[list[Contour], list[Contour]]:
    """Split what a chunk of an image of this shape sees into contours of it alone, and pieces to be joined."""
    low, high = outer_limits(chunk.core, shape)
    own: list[Contour] = []
    pieces: list[Contour] = []
    for one in contours:
        if (one.box[0] >= low + _UNSHARED_MARGIN).all() and (one.box[1] <= high - _UNSHARED_MARGIN).all():
            own.append(one)
        else:
            pieces += clip_contour(one, low - _PIECE_MARGIN, high + _PIECE_MARGIN)
    return own, pieces


def clip_contour(contour: Contour, low: Array, high: Array) -> Iterator[Contour]:
    """Clip a contour to a box between two corners, shapes (2,) [px]."""
    import shapely

    return _take_stretches(contour, shapely.clip_by_rect(shapely.LineString(contour.path), *low, *high))


def _take_stretches(contour: Contour, lines: Any) -> Iterator[Contour]:
    """Take the stretches of a contour along lines of shapely; their ends are at its junctions where these are left."""
    import shapely

    junctions = contour.points[[0, -1]][list(contour.junctions)]
    for points in map(shapely.get_coordinates, shapely.get_parts(shapely.line_merge(lines))):
        if len(points) > 1:
            away = np.linalg.norm(points[[0, -1], None] - junctions, axis=2)
            closed = contour.closed and bool((points[0] == points[-1]).all())
            first, last = (away <= _JOINT_DISTANCE).any(axis=1).tolist()
            yield replace(contour, points=points[: len(points) - closed], closed=closed, junctions=(first, last))


def join_pieces(pieces: Sequence[Contour], chunks: Sequence[int], least: float) -> list[Contour]:
    """Join the pieces of all chunks to contours of at least this length; `chunks` holds the chunk of each piece."""
    import shapely

    if not pieces:
        return []
    lines, of = np.array([shapely.LineString(piece.path) for piece in pieces]), np.array(chunks)
    one, other = shapely.STRtree(lines).query(lines, "dwithin", _SAME_BOUNDARY_DISTANCE)
    earlier = of[other] < of[one]
    seen = np.full(len(lines), None)
    if earlier.any():
        shapely.multilinestrings(lines[other[earlier]], indices=one[earlier], out=seen)
    new = shapely.difference(lines, shapely.buffer(seen, _SAME_BOUNDARY_DISTANCE))
    left = np.where(shapely.is_missing(seen), lines, new)
    stretches = [part for piece, line in zip(pieces, left, strict=True) for part in _take_stretches(piece, line)]
    joined = _join_stretches(stretches, _find_joints(stretches))
    return [one for one in joined if one.length >= least]


def _find_joints(stretches: Sequence[Contour]) -> list[tuple[int, int]]:
    """Find the ends that lie next to each other, the nearest first; stretch n has the ends 2n and 2n + 1."""
    ends = np.concatenate([one.points[[0, -1]] for one in stretches])
    loose = np.flatnonzero([not (one.closed or at_junction) for one in stretches for at_junction in one.junctions])
    pairs = loose[scipy.spatial.KDTree(ends[loose]).query_pairs(_JOINT_DISTANCE, output_type="ndarray")]
    joints: list[tuple[int, int]] = []
    taken = set[int]()
    for a, b in pairs[np.argsort(np.linalg.norm(ends[pairs[:, 0]] - ends[pairs[:, 1]], axis=1))].tolist():
        is_dot = a // 2 == b // 2 and stretches[a // 2].length <= 2.0 * _JOINT_DISTANCE
        if taken.isdisjoint((a, b)) and not is_dot:
            joints.append((a, b))
            taken |= {a, b}
    return joints


def _join_stretches(stretches: Sequence[Contour], joints: Sequence[tuple[int, int]]) -> Iterator[Contour]:
    """Join stretches at pairs of their ends."""
    import shapely

    ends = [tuple(end) for one in stretches for end in one.points[[0, -1]].tolist()]
    flags = [at_junction for one in stretches for at_junction in one.junctions]
    junctions = {end for end, at_junction in zip(ends, flags, strict=True) if at_junction}
    pairs = np.array(joints, np.int64).reshape(-1, 2)
    group = label_joined_pairs(pairs.T // 2, len(stretches))
    lines = [shapely.LineString(one.path) for one in stretches]
    lines += [shapely.LineString([ends[a], ends[b]]) for a, b in joints]
    of_line = np.concatenate([group, group[pairs[:, 0] // 2]])
    order = np.argsort(of_line, kind="stable")
    whole = shapely.line_merge(shapely.multilinestrings(np.array(lines)[order], indices=of_line[order]))
    lengths = np.array([one.length for one in stretches])
    strengths = np.bincount(group, lengths * [one.strength for one in stretches]) / np.bincount(group, lengths)
    for line, strength in zip(whole, strengths.tolist(), strict=True):
        points = shapely.get_coordinates(line)
        at_junction = [at for at, place in enumerate(map(tuple, points.tolist())) if place in junctions]
        is_ring = bool((points[0] == points[-1]).all())
        if is_ring and at_junction:  # around, from a junction back to it
            points = np.concatenate([points[at_junction[0] :], points[1 : at_junction[0] + 1]])
        closed = is_ring and not at_junction
        first, last = (tuple(end) in junctions for end in points[[0, -1]].tolist())
        yield Contour(points[:-1] if closed else points, closed, strength, (first, last))
