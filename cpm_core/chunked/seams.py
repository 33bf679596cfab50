"""Seams: which chunk a contour belongs to, and contours joined across the borders of chunks.

A closed contour whose box is at most `ChunkGrid.max_whole_side` long belongs to the chunk with the middle of its box.
That chunk sees all of it undisturbed, and so do all chunks whose cores it touches: no chunk asks another. Of longer
contours each chunk keeps the pieces in its core and a little beyond, so that pieces of neighbors overlap; there they
are joined, and stretches that a contour shares with another at its ends are kept once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.chunked.grid import OWNERSHIP_TOLERANCE, Chunk, ChunkGrid, window_limits
from cpm_core.chunked.store import ContourPiece
from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Array, Index, Mask

_PIECE_MARGIN = 6.0
"""Distance beyond its core up to which a chunk keeps long contours [px]."""

_SAME_BOUNDARY_DISTANCE = 0.5
"""Distance up to which two chunks see the same boundary [px]; in fact they differ by some thousandths."""


def select_owned_contours(
    contours: Sequence[Contour], chunk: Chunk, grid: ChunkGrid
) -> tuple[list[ContourPiece], list[ContourPiece]]:
    """Select the contours that a chunk owns, and cut pieces of long ones."""
    low, high = window_limits(chunk.core)
    low, high = np.where(low < 0.0, -np.inf, low), np.where(high > np.array(grid.shape) - 1.0, np.inf, high)
    whole: list[ContourPiece] = []
    pieces: list[ContourPiece] = []
    for one in contours:
        if not one.closed or not grid.sees_whole(one):
            pieces += _clip_contour(one, low - _PIECE_MARGIN, high + _PIECE_MARGIN)
        elif chunk.may_own(one.box.mean(axis=0)):
            whole.append(ContourPiece(one))
    return whole, pieces


def _clip_contour(contour: Contour, low: Array, high: Array) -> Iterator[ContourPiece]:
    """Cut the stretches of a contour within limits, each with one vertex beyond."""
    points = contour.points
    inside = ((points >= low) & (points <= high)).all(axis=1)
    if inside.all():
        yield ContourPiece(contour)
        return
    if contour.closed:  # from a vertex outside on, and back to it
        first = int(np.argmin(inside))
        points = np.roll(points, -first, axis=0)
        points, inside = np.concatenate([points, points[:1]]), np.append(np.roll(inside, -first), False)
    steps = np.flatnonzero(np.diff(inside.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    for first, end in steps.tolist():
        cut = (first > 0, end < len(points))
        stretch = points[max(first - 1, 0) : end + 1]
        ends = (contour.junctions[0] and not cut[0], contour.junctions[1] and not cut[1])
        yield ContourPiece(replace(contour, points=stretch, closed=False, junctions=ends), cut)


def find_duplicates(boxes: Array, chunks: Index, grid: ChunkGrid) -> Mask:
    """Find the contours that two chunks own, of which all but one are duplicates; shape (N,).

    `boxes`, shape (N, 2, 2) [px], and `chunks`, shape (N,), are those of all contours.
    """
    middle = boxes.mean(axis=1)
    edge = (middle + 0.5) % grid.side
    near = np.flatnonzero(
        (np.minimum(edge, grid.side - edge) <= OWNERSHIP_TOLERANCE + _SAME_BOUNDARY_DISTANCE).any(axis=1)
    )
    found = np.zeros(len(boxes), bool)
    if len(near):
        pairs = scipy.spatial.KDTree(boxes[near].reshape(-1, 4)).query_pairs(
            _SAME_BOUNDARY_DISTANCE, p=np.inf, output_type="ndarray"
        )
        one, other = near[pairs].T
        apart = chunks[one] != chunks[other]
        found[np.maximum(one, other)[apart]] = True
    return found


class _End(NamedTuple):
    """The piece that continues another one: its index, which of its ends lies here, and the vertex to continue at."""

    piece: int
    end: int
    vertex: int


def join_pieces(pieces: list[ContourPiece], chunks: Sequence[int], least: float) -> list[Contour]:
    """Join the pieces of all chunks to contours of at least this length; `chunks` holds the chunk of each piece."""
    import shapely

    lines = [shapely.LineString(piece.contour.path) for piece in pieces]
    tree = shapely.STRtree(lines)
    order = sorted(range(len(pieces)), key=lambda n: (lines[n].length, n))
    gone: set[int] = set()
    for n in order:  # drop pieces that lie entirely on pieces of other chunks
        near = tree.query(lines[n], "dwithin", _SAME_BOUNDARY_DISTANCE).tolist()
        others = [lines[m] for m in near if chunks[m] != chunks[n] and m not in gone]
        if others and shapely.union_all(others).buffer(_SAME_BOUNDARY_DISTANCE).covers(lines[n]):
            gone.add(n)
    ends: dict[tuple[int, int], _End] = {}
    for n in (n for n in order if n not in gone):
        for end in (0, 1):
            if pieces[n].cut[end] and (n, end) not in ends:
                points = pieces[n].contour.points[:: -1 if end == 0 else 1]
                near = tree.query(shapely.Point(points[-1]), "dwithin", _SAME_BOUNDARY_DISTANCE).tolist()
                others = [m for m in near if m != n and m not in gone and chunks[m] != chunks[n]]
                for m in sorted(others, key=lambda m: lines[m].distance(shapely.Point(points[-1]))):
                    known = _find_continuation(points, pieces[m].contour.points)
                    if pieces[m].cut[known[0]] and (m, known[0]) not in ends:
                        ends[n, end] = _End(m, *known)
                        back = pieces[m].contour.points[:: -1 if known[0] == 0 else 1]
                        ends[m, known[0]] = _End(n, end, _find_continuation(back, pieces[n].contour.points)[1])
                        break
    left = [n for n in range(len(pieces)) if n not in gone]
    return [one for one in _trim_shared_ends(_chain_pieces(pieces, left, ends)) if one.length >= least]


def _trim_shared_ends(contours: list[Contour]) -> Iterator[Contour]:
    """Cut off the stretches at the ends of contours that lie on others, the shortest contour first."""
    import shapely

    contours = sorted(contours, key=lambda one: one.length)
    lines = [shapely.LineString(one.path) for one in contours]
    tree = shapely.STRtree(lines)
    for n, one in enumerate(contours):
        near = (
            []
            if one.closed
            else [lines[m] for m in tree.query(lines[n], "dwithin", _SAME_BOUNDARY_DISTANCE).tolist() if m != n]
        )
        own = (
            ~shapely.dwithin(shapely.points(one.points), shapely.union_all(near), _SAME_BOUNDARY_DISTANCE)
            if near
            else np.ones(1, bool)
        )
        first, end = (max(int(way.argmax()) - 1, 0) for way in (own, own[::-1]))  # with a vertex where they meet
        kept = one.points[first : len(one.points) - end] if own.any() else one.points[:0]
        lines[n] = shapely.LineString(kept) if len(kept) < len(one.points) else lines[n]
        if len(kept) > 1:
            yield replace(one, points=kept)


def _find_continuation(points: Array, other: Array) -> tuple[int, int]:
    """Find the end of another line that a line runs over before its last point, and the vertex after that point."""
    back = points[max(len(points) - 3, 0)]
    here, before = (int(np.argmin(((other - at) ** 2).sum(axis=1))) for at in (points[-1], back))
    if here == before:  # the line is shorter than the step between vertices
        along = other[min(here + 1, len(other) - 1)] - other[max(here - 1, 0)]
        before = here - 1 if (points[-1] - back) @ along >= 0.0 else here + 1
    return (0, min(here + 1, len(other) - 1)) if here > before else (1, max(here - 1, 0))


def _chain_pieces(
    pieces: Sequence[ContourPiece], left: Sequence[int], ends: dict[tuple[int, int], _End]
) -> list[Contour]:
    """Chain pieces that are connected at their ends, from loose ends on, then those that run around."""
    found, used = [], set[int]()
    loose = [(n, end) for n in left for end in (0, 1) if (n, end) not in ends]
    for first, begun in (*loose, *((n, 0) for n in left)):
        if first in used:
            continue
        following: _End | None = _End(first, begun, 0 if begun == 0 else len(pieces[first].contour.points) - 1)
        passed: list[Contour] = []
        paths: list[Array] = []
        while following is not None and following.piece not in used:
            n, end, vertex = following
            used.add(n)
            passed.append(pieces[n].contour)
            paths.append(passed[-1].points[vertex:] if end == 0 else passed[-1].points[vertex::-1])
            following = ends.get((n, 1 - end))
        around = following is not None and following.piece == first
        if around and following is not None:  # the first stretch begins where the last one ends
            paths[0] = paths[0][following.vertex :]
        closed = around or passed[0].closed
        strength = float(np.average([one.strength for one in passed], weights=[one.length for one in passed]))
        tips = (passed[0].junctions[begun], passed[-1].junctions[1 - end])
        found.append(Contour(np.concatenate(paths), closed, strength, (False, False) if closed else tips))
    return found
