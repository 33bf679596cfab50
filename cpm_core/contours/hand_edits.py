"""Edits of contours by hand: drawn pieces, removed stretches, both of which survive further runs.

Every operation is one value, `HandEdit`: a stretch that is removed, a piece that is added, or both. A cut removes a
stretch of length zero, a join adds a piece between two ends, a redrawn stretch is removed and another one added. The
next reconstruction moves contours by fractions of a pixel, or ends them elsewhere; `apply_hand_edits` identifies the
contours of an edit by places on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from cpm_core.contours.contour import Contour, Contours
from cpm_core.contours.polygonal_line import PolygonalLine, close_line, join_lines
from cpm_core.contours.review import ANCHOR_REACH
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Integers, Line, Position, frozen

HandEditKind = Literal["cut", "deletion", "redrawing", "join", "extension", "line", "outline"]
"""Kind of an edit, by what it removes and adds."""

_SEARCH_DISTANCES = (1.0, 2.0, ANCHOR_REACH)
"""Distances within which a removed stretch is searched, the first one that finds any [px]."""

_JOINING_DISTANCE = 3.0 * ANCHOR_REACH
"""Distance from a piece up to which the end of its contour is joined to it after another run [px]."""

_ALREADY_JOINED_DISTANCE = 1.5
"""Distance from a contour within which a piece is already part of it [px]."""

_MIN_SHARE_FOUND = 0.5
"""Least length of a rediscovered stretch that is removed, as a fraction of the original length."""

_OUTLINE_COVER_DISTANCE = 1.5
"""Distance from an outline within which an open contour runs along it [px]."""

_SHORTEST_REMAINDER = 4.0
"""Least length of a stretch that is removed from a contour or remains of it [px]."""

_OUTLINE_SAMPLING = 0.5
"""Distance between samples along a line that is compared with an outline [px]."""


@frozen
class HandEdit:
    """One change of contours by hand.

    Attributes
    ----------
    removed : tuple of (row, col)
        Places along the stretch of a contour that is removed [px]; a single one cuts the contour there.
    added : tuple of (row, col)
        Vertices of the piece that is added [px].
    closed : bool
        Whether the piece is a closed contour of its own. It replaces the stretches of open contours along it.
    before, after : tuple of (row, col)
        For each end of the piece that continues a contour one place on that contour, some pixels back from its end;
        empty for a loose end.
    """

    removed: Line = ()
    added: Line = ()
    closed: bool = False
    before: Line = ()
    after: Line = ()

    @property
    def kind(self) -> HandEditKind:
        """Kind of the edit, by what it removes and adds."""
        if self.removed:
            return "redrawing" if self.added else "cut" if len(self.removed) == 1 else "deletion"
        if self.closed:
            return "outline"
        return "join" if self.before and self.after else "extension" if self.before or self.after else "line"


def apply_hand_edits(contours: Contours, edits: Sequence[HandEdit]) -> tuple[tuple[Contour, ...], Integers]:
    """Apply edits by hand to contours, in the order in which they were made.

    Parameters
    ----------
    contours : sequence of Contour
        Contours of a reconstruction.
    edits : sequence of HandEdit
        Edits, which may have been made on an earlier reconstruction.

    Returns
    -------
    contours : tuple of Contour
        Longest first. Contours that no edit has changed are the same Python objects as before.
    missed : tuple of int
        Indices of the edits that did not find all their contours; their pieces are added nevertheless.
    """
    if not edits:
        return tuple(contours), ()
    lines, missed = [PolygonalLine.from_contour(contour) for contour in contours], []
    for number, edit in enumerate(edits):
        done = not edit.removed
        if len(edit.removed) == 1:
            lines, done = _cut_nearest_line(lines, edit.removed[0])
        for reach in _SEARCH_DISTANCES:
            if not done and len(edit.removed) > 1:
                lines, done = _remove_stretch(lines, np.array(edit.removed), reach)
        if edit.added:
            lines, held = _add_piece(lines, edit)
            done = done and held
        if not done:
            missed.append(number)
    found = [line.to_contour() for line in lines]
    return tuple(sorted(found, key=lambda contour: -contour.length)), tuple(missed)


# Removing


def _cut_nearest_line(lines: list[PolygonalLine], place: Position) -> tuple[list[PolygonalLine], bool]:
    """Cut the nearest line within reach at a place; its end cannot be cut."""
    near = [
        (line.project_point(place)[1], index)
        for index, line in enumerate(lines)
        if line.passes_near(place, ANCHOR_REACH)
    ]
    for _, index in sorted(near):
        line = lines[index]
        pieces = line.split_at((line.project_point(place)[0],))
        if line.closed or len(pieces) > 1:
            return [*lines[:index], *pieces, *lines[index + 1 :]], True
    return lines, False


def _remove_stretch(lines: list[PolygonalLine], path: Array, reach: float) -> tuple[list[PolygonalLine], bool]:
    """Remove the stretch that follows a path within reach from its first place to its last."""
    box = np.stack([path.min(axis=0) - reach, path.max(axis=0) + reach])
    pieces: dict[int, list[PolygonalLine]] = {}
    for number, line in enumerate(lines):
        if (line.box[1] >= box[0]).all() and (line.box[0] <= box[1]).all():
            near = (line.project_point(path[0]), line.project_point(path[-1]))
            pieces[number] = line.split_at(along for along, away in near if away <= reach)
    found = [(n, k) for n, some in pieces.items() for k, piece in enumerate(some) if piece.follows_path(path, reach)]
    if found and reach > _SEARCH_DISTANCES[0]:  # the contour has moved: others may lie as near
        longest = max(found, key=lambda one: pieces[one[0]][one[1]].length)
        enough = pieces[longest[0]][longest[1]].length >= _MIN_SHARE_FOUND * polyline.path_length(path)
        found = [longest] if enough else []
    touched = {n for n, _ in found}
    for n in touched:
        pieces[n] = [piece for k, piece in enumerate(pieces[n]) if (n, k) not in found]
    rest = [piece for n, line in enumerate(lines) for piece in (pieces[n] if n in touched else [line])]
    return rest, bool(found)


# Adding


class _Tie(NamedTuple):
    """Line that a piece continues: its number, whether at its last end, and the length along it where it is joined."""

    line: int
    at_last: bool
    along: float


def _add_piece(lines: list[PolygonalLine], edit: HandEdit) -> tuple[list[PolygonalLine], bool]:
    """Add a piece, joined to the lines that it continues; also return whether all of them were found."""
    points = np.array(edit.added)
    piece = PolygonalLine.from_drawn_points(points, edit.closed)
    if edit.closed:
        return [*(rest for line in lines for rest in _remove_covered_stretches(line, piece)), piece], True
    if edit.before and edit.after and any(_already_joins(line, piece, edit) for line in lines):
        return lines, True
    first = _find_tie(lines, points, edit.before)
    last = _find_tie(lines, points[::-1], edit.after)
    if first is not None and last is not None and first.line == last.line and first.at_last == last.at_last:
        last = None
    piece = replace(piece, junctions=(_meets_side(lines, points[0]), _meets_side(lines, points[-1])))
    rest = [line for n, line in enumerate(lines) if n not in {tie.line for tie in (first, last) if tie is not None}]
    found = (first is not None or not edit.before) and (last is not None or not edit.after)
    if first is not None and last is not None and first.line == last.line:
        line = lines[first.line]
        begin, end = sorted((first.along, last.along))
        kept = line.part_between(begin, end)
        closed = close_line(join_lines(kept if first.at_last else kept.reversed(), piece))
        # a piece that leads back along the line encloses nothing
        return ([*rest, closed] if len(closed.points) > 2 else lines), found
    if first is not None:
        piece = join_lines(_line_up_to_tie(lines, first), piece)
    if last is not None:
        piece = join_lines(piece, _line_up_to_tie(lines, last).reversed())
    return [*rest, piece], found


def _remove_covered_stretches(line: PolygonalLine, outline: PolygonalLine) -> list[PolygonalLine]:
    """Return the pieces of a line that remain where an outline takes its place: of an open one, those off it."""
    apart = (line.box[1] < outline.box[0] - _OUTLINE_COVER_DISTANCE).any() or (
        line.box[0] > outline.box[1] + _OUTLINE_COVER_DISTANCE
    ).any()
    if line.closed or apart or line.length < _SHORTEST_REMAINDER:
        return [line]
    count = max(1, int(np.ceil(line.length / _OUTLINE_SAMPLING)))
    near = (
        polyline.distances_to_path(outline.path, polyline.path_midpoints(line.path, count)) <= _OUTLINE_COVER_DISTANCE
    )
    step, bounds = line.length / count, [0, *(np.flatnonzero(np.diff(near)) + 1).tolist(), count]
    stretches = [(a, b) for a, b in pairwise(bounds) if near[a] and (b - a) * step >= _SHORTEST_REMAINDER]
    cuts = [end * step for stretch in stretches for end in stretch]
    if not cuts:
        return [line]
    return [
        rest
        for rest in line.split_at(cuts)
        if rest.length >= _SHORTEST_REMAINDER
        and not rest.follows_path(outline.path, _OUTLINE_COVER_DISTANCE + _OUTLINE_SAMPLING)
    ]


def _line_up_to_tie(lines: list[PolygonalLine], tie: _Tie) -> PolygonalLine:
    """Return the line of a tie up to the place where the piece begins, which comes last."""
    line = lines[tie.line]
    return line.part_between(0.0, tie.along) if tie.at_last else line.part_between(tie.along, line.length).reversed()


def _find_tie(lines: list[PolygonalLine], piece: Array, behind: Line) -> _Tie | None:
    """Find the line that a piece continues from its first vertex."""
    row, col = piece[0].tolist()
    found: list[tuple[float, _Tie]] = []
    for index, line in enumerate(lines):
        if line.closed or not behind or not line.passes_near(behind[0], ANCHOR_REACH):
            continue
        back, off = line.project_point(behind[0])
        away = [float(np.linalg.norm(line.points[n] - piece[0])) for n in (0, -1)]
        along, aside = line.project_point((row, col))
        near = [last for last in (False, True) if away[last] <= ANCHOR_REACH]
        if near:
            at_last = min(near, key=lambda last: abs((line.length if last else 0.0) - back))
            room = min(2.0 * ANCHOR_REACH, 0.5 * line.length)
            begin = line.length - room if at_last else 0.0
            # it may reach beyond the end of the contour
            overlap = line.part_between(begin, begin + room).project_point((row, col))[0]
            found.append((off + aside, _Tie(index, at_last, begin + overlap)))
        elif aside <= ANCHOR_REACH and line.part_between(
            *sorted((along, line.length if along > back else 0.0))
        ).follows_path(piece, ANCHOR_REACH):
            found.append((off + aside, _Tie(index, along > back, along)))
        elif min(away) <= _JOINING_DISTANCE:
            last = away[1] < away[0]
            found.append((off + min(away), _Tie(index, last, line.length if last else 0.0)))
    return min(found)[1] if found else None


def _already_joins(line: PolygonalLine, piece: PolygonalLine, edit: HandEdit) -> bool:
    """Return whether a line runs along a piece and both contours that it joins, as after a run that closed the gap."""
    if not all(line.passes_near(behind, ANCHOR_REACH) for behind in (*edit.before, *edit.after)):
        return False
    begin, end = sorted(line.project_point(behind)[0] for behind in (*edit.before, *edit.after))
    between = [line.part_between(begin, end), *([line.part_between(end, begin + line.length)] if line.closed else [])]
    return any(piece.follows_path(part.path, _ALREADY_JOINED_DISTANCE) for part in between)


def _meets_side(lines: list[PolygonalLine], place: Array) -> bool:
    row, col = place.tolist()
    return any(line.passes_near((row, col), _SEARCH_DISTANCES[0]) for line in lines)
