"""Edits of contours by hand: join, close, merge, cut, delete, pull, redraw, draw.

Each function returns edits for `cpm_core.contours.hand_edits.apply_hand_edits`; none changes a contour itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, groupby

import numpy as np

from cpm_core.contours.contour import Contour, Contours
from cpm_core.contours.hand_edits import HandEdit
from cpm_core.contours.polygonal_line import PolygonalLine
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Line, Position, record
from cpm_core.reconstruction.by_hand.live_wire import LiveWire, snap_place_to_ridge

_ANCHOR_DISTANCE = 8.0
"""Length along a contour from the end of a piece to the place that identifies the contour later [px]."""

_PLACE_DECIMALS = 3
"""Decimals of the places of an edit [px]; contours are accurate to about a tenth."""

_END_TOLERANCE = 1e-3
"""Distance from an end of a contour up to which a place on it is that end [px]."""

_MIN_PULLED_LENGTH = 8.0
"""Least length of contour that is pulled on both sides of the held place [px]."""

_PULLED_LENGTH = 1.5
"""Length of contour that is pulled on both sides of the held place, in lengths of the pull."""

_PULL_SNAP_DISTANCE = 4.0
"""Distance from an edge within which a pulled stretch snaps to it [px]."""


@record
class Contact:
    """A place on a contour, by the length along it [px]."""

    line: PolygonalLine
    along: float

    @classmethod
    def from_nearest_place(cls, contour: Contour, place: Position) -> Contact:
        """Return the place of a contour that is nearest to another place."""
        line = PolygonalLine.from_contour(contour)
        return cls(line, line.project_point(place)[0])

    @classmethod
    def from_contour_ends(cls, contour: Contour) -> tuple[Contact, ...]:
        """Return both ends of an open contour; none of a closed one."""
        line = PolygonalLine.from_contour(contour)
        return () if contour.closed else (cls(line, 0.0), cls(line, line.length))

    @property
    def place(self) -> Position:
        """Position (row, col) [px]."""
        return self.place_at_offset(0.0)

    @property
    def at_last(self) -> bool:
        """Whether it is the last end of an open contour."""
        return not self.line.closed and self.along >= self.line.length - _END_TOLERANCE

    @property
    def at_end(self) -> bool:
        """Whether it is an end of an open contour."""
        return self.at_last or (not self.line.closed and self.along <= _END_TOLERANCE)

    @property
    def behind(self) -> Line:
        """For an end, the place that identifies its contour later; none for any other place."""
        return (self.place_at_offset(-_ANCHOR_DISTANCE if self.at_last else _ANCHOR_DISTANCE),) if self.at_end else ()

    def place_at_offset(self, offset: float) -> Position:
        """Return the place at a distance along the contour, on an open one at most halfway to its other end [px]."""
        along, whole = self.along + offset, self.line.length
        if self.line.closed:
            along %= whole
        elif offset:
            along = max(along, 0.5 * self.along) if offset < 0.0 else min(along, 0.5 * (self.along + whole))
        return tuple(polyline.points_at_lengths(self.line.path, np.array([along]))[0].tolist())

    def is_on_same_contour(self, other: Contact) -> bool:
        """Return whether another place is on the same contour."""
        return self.line.source is other.line.source


def connect_by_path(path: Array, begin: Contact | None = None, end: Contact | None = None) -> tuple[HandEdit, ...]:
    """Return the edits that a drawn path stands for, by what its two ends touch.

    Between two ends it joins them, or closes their contour. From an end to the side of the same contour it closes the
    contour there, and the rest stays a contour of its own. Between two sides of one contour it replaces the stretch
    between them. Any other path is added, and continues the contour at whose end it begins or ends.

    Parameters
    ----------
    path : ndarray, shape (K, 2)
        The path, from the place of `begin` to that of `end` [px].
    begin, end : Contact, optional
        Places that its ends touch.
    """
    if begin is not None and end is not None and begin.is_on_same_contour(end):
        if not begin.at_end and not end.at_end:
            # in place of the stretch between the two, of a closed contour the nearer one
            if begin.along > end.along:
                begin, end, path = end, begin, path[::-1]
            line = begin.line
            stretch = line.part_between(begin.along, end.along)
            if line.closed:
                other = line.part_between(end.along, begin.along + line.length)
                if (
                    polyline.distances_to_path(path, other.path).mean()
                    < polyline.distances_to_path(path, stretch.path).mean()
                ):
                    stretch, begin, end, path = other, end, begin, path[::-1]
            return (_replace_stretch(stretch, path, begin, end),)
        if not end.at_end:
            begin, end, path = end, begin, path[::-1]
        if not begin.at_end:
            inward = min(_ANCHOR_DISTANCE, 0.5 * abs(end.along - begin.along))
            behind = begin.place_at_offset(inward if end.at_last else -inward)
            return HandEdit(removed=(_round_place(begin.place),)), HandEdit(
                (), round_path(path), False, (behind,), end.behind
            )
    before = begin.behind if begin is not None else ()
    after = end.behind if end is not None else ()
    return (HandEdit((), round_path(path), False, before, after),)


def chain_contours(scale_field: ScaleField, contours: Contours, closing: bool = False) -> tuple[HandEdit, ...]:
    """Join open contours into one by live wires between ends, the nearest first; with `closing` into a closed one."""
    ends = [(number, end) for number, contour in enumerate(contours) for end in Contact.from_contour_ends(contour)]
    apart = [(math.dist(ends[i][1].place, ends[j][1].place), i, j) for i, j in combinations(range(len(ends)), 2)]
    chains = list(range(len(contours)))  # of each contour the number of its chain
    free = set(range(len(ends)))
    edits: list[HandEdit] = []
    for ring in (False, True) if closing else (False,):
        for _, i, j in sorted(apart):
            (one, begin), (other, end) = ends[i], ends[j]
            if i in free and j in free and (ring or chains[one] != chains[other]):
                free -= {i, j}
                gone = chains[other]
                chains = [chains[one] if number == gone else number for number in chains]
                edits += connect_by_path(live_wire_from(scale_field, begin, contours).path_to(end.place), begin, end)
    return tuple(edits)


def live_wire_from(scale_field: ScaleField, begin: Contact, contours: Contours = ()) -> LiveWire:
    """Start a live wire at a place on a contour that does not run back along it, or along further contours."""
    avoided = [PolygonalLine.from_contour(contour) for contour in contours] or [begin.line]
    ends = [end.place for line in avoided if line.source is not None for end in Contact.from_contour_ends(line.source)]
    return LiveWire(scale_field, begin.place, [line.path for line in avoided], ends)


def cut_contour(at: Contact) -> HandEdit:
    """Cut a contour at a place."""
    return HandEdit(removed=(_round_place(at.place),))


def delete_stretch(one: Contact, other: Contact) -> HandEdit:
    """Delete the stretch of a contour between two places, of a closed one the shorter of the two."""
    first, last = sorted((one.along, other.along))
    line = one.line
    if line.closed and last - first > 0.5 * line.length:
        first, last = last, first + line.length
    return HandEdit(removed=round_path(line.part_between(first, last).points))


def pull_contour(held: Contact, to: Position, scale_field: ScaleField | None = None) -> HandEdit:
    """Pull a stretch of a contour to a place.

    The farther it is pulled, the longer the stretch. With the fields of the image it snaps to the edges: it runs along
    the live wire through the edge nearest to the place. Without them it bends smoothly.
    """
    line = held.line
    far = math.dist(to, held.place)
    hold = min(max(_MIN_PULLED_LENGTH, _PULLED_LENGTH * far), 0.4 * line.length)
    first, last = held.along - hold, held.along + hold
    if line.closed:
        first, last = first % line.length, first % line.length + 2.0 * hold
    else:
        first, last = max(first, 0.0), min(last, line.length)
    begin, end = Contact(line, first), Contact(line, last % line.length if line.closed else last)
    stretch = line.part_between(first, last)
    if scale_field is None:
        path = polyline.resample_path(stretch.points, 1.0)
        share = np.linspace(-1.0, 1.0, len(path))[:, None]
        path = path + (0.5 + 0.5 * np.cos(np.pi * share)) * np.subtract(to, held.place)
    else:
        target = snap_place_to_ridge(to, scale_field, _PULL_SNAP_DISTANCE)
        wire = LiveWire(scale_field, target, [stretch.points], [begin.place, end.place])
        path = np.concatenate([wire.path_to(begin.place)[::-1], wire.path_to(end.place)[1:]])
    return _replace_stretch(stretch, path, begin, end)


def round_path(path: Array) -> Line:
    """Round a path, shape (K, 2), to the places of an edit, none of them twice in a row."""
    rounded = [_round_place(place) for place in path.tolist()]
    kept = [place for place, _ in groupby(rounded)]
    return tuple(kept if len(kept) > 1 else rounded[:1] * 2)


def _replace_stretch(stretch: PolygonalLine, path: Array, begin: Contact, end: Contact) -> HandEdit:
    """Replace a stretch of a contour, which continues before its beginning and behind its end, by a path."""
    before = () if begin.at_end else (begin.place_at_offset(-_ANCHOR_DISTANCE),)
    after = () if end.at_end else (end.place_at_offset(_ANCHOR_DISTANCE),)
    return HandEdit(round_path(stretch.points), round_path(path), False, before, after)


def _round_place(place: Sequence[float]) -> Position:
    return round(place[0], _PLACE_DECIMALS), round(place[1], _PLACE_DECIMALS)
