"""Curves redrawn by hand: a stretch is pulled to another place, or replaced by a drawn path."""

from __future__ import annotations

import math

import numpy as np

from cpm_core.contours.contour import Curve
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Position, record
from cpm_core.reconstruction.by_hand.live_wire import LiveWire, snap_place_to_ridge

_LENGTH_TOLERANCE = 1e-3
"""Length along a curve that counts as none [px]."""

_MIN_PULLED_LENGTH = 8.0
"""Least length of a curve that is pulled on both sides of the held place [px]."""

_PULLED_LENGTH = 1.5
"""Length of a curve that is pulled on both sides of the held place, in lengths of the pull."""

_MAX_PULLED_SHARE = 0.4
"""Largest share of a curve that is pulled on one side of the held place."""

_PULL_SNAP_DISTANCE = 4.0
"""Distance from an edge within which a pulled stretch snaps to it [px]."""


@record
class CurvePlace:
    """A place on a curve, by the length along it [px]."""

    curve: Curve
    along: float

    @classmethod
    def from_nearest_place(cls, curve: Curve, place: Position) -> CurvePlace:
        """Return the place of a curve that is nearest to another place."""
        return cls(curve, polyline.project_point(curve.path, place))

    @property
    def place(self) -> Position:
        """Position (row, col) [px]."""
        return tuple(polyline.points_at_lengths(self.curve.path, np.array([self.along]))[0].tolist())

    def distance_to(self, place: Position) -> float:
        """Return the distance from another place [px]."""
        return math.dist(self.place, place)


@record
class RedrawnCurve(Curve):
    """A curve after a stretch of it, `drawn`, shape (K, 2) [px], has been drawn again."""

    drawn: Array


def replace_stretch(begin: CurvePlace, end: CurvePlace, path: Array) -> RedrawnCurve:
    """Replace the stretch between two places of one curve by a path; of a closed curve the stretch nearer to the path.

    Parameters
    ----------
    begin, end : CurvePlace
        Two places on the same curve.
    path : ndarray, shape (K, 2)
        Path from the first place to the second [px].
    """
    curve = begin.curve
    first, last = begin.along, end.along
    if first > last:
        first, last, path = last, first, path[::-1]
    if curve.closed:
        others = last, first + curve.length
        between, around = (_part_between(curve, *stretch) for stretch in ((first, last), others))
        if polyline.distances_to_path(path, around).mean() < polyline.distances_to_path(path, between).mean():
            (first, last), path = others, path[::-1]
    return _replace_part(curve, first, last, path)


def pull_curve(held: CurvePlace, to: Position, scale_field: ScaleField | None = None) -> RedrawnCurve:
    """Pull a stretch of a curve to a place.

    The farther it is pulled, the longer the stretch. With the fields of the image it snaps to the edges: it runs along
    the live wire through the edge nearest to the place. Without them it bends smoothly. The end of an open curve moves
    when it is held.
    """
    curve, whole = held.curve, held.curve.length
    hold = min(max(_MIN_PULLED_LENGTH, _PULLED_LENGTH * held.distance_to(to)), _MAX_PULLED_SHARE * whole)
    first, last = held.along - hold, held.along + hold
    if curve.closed:
        first, last = first % whole, first % whole + 2.0 * hold
    else:
        first, last = max(first, 0.0), min(last, whole)
    stretch = _part_between(curve, first, last)
    if scale_field is None:
        path = polyline.resample_path(stretch, 1.0)
        middle = hold if curve.closed else held.along - first
        share = np.clip((polyline.lengths_along(path) - middle) / hold, -1.0, 1.0)[:, None]
        path = path + (0.5 + 0.5 * np.cos(np.pi * share)) * np.subtract(to, held.place)
    else:
        target = snap_place_to_ridge(to, scale_field, _PULL_SNAP_DISTANCE)
        begin, end = (tuple(stretch[n].tolist()) for n in (0, -1))
        wire = LiveWire(scale_field, target, [stretch], [begin, end])
        moves_first, moves_last = (
            not curve.closed and abs(held.along - at) <= _LENGTH_TOLERANCE for at in (0.0, whole)
        )
        before = np.array([target]) if moves_first else wire.path_to(begin)[::-1]
        path = before if moves_last else np.concatenate([before, wire.path_to(end)[1:]])
    return _replace_part(curve, first, last, path)


def _part_between(curve: Curve, first: float, last: float) -> Array:
    """Return the vertices between two lengths along a curve; on a closed one the second may go once around."""
    path = np.concatenate([curve.path, curve.path[1:]]) if curve.closed else curve.path
    along = polyline.lengths_along(path)
    inner = along[(along > first + _LENGTH_TOLERANCE) & (along < last - _LENGTH_TOLERANCE)]
    return polyline.points_at_lengths(path, np.concatenate([[first], inner, [last]]))


def _replace_part(curve: Curve, first: float, last: float, path: Array) -> RedrawnCurve:
    """Replace the part between two lengths along a curve by a path; see `_part_between`."""
    whole = curve.length
    if curve.closed:
        back = whole if last > whole else 0.0
        rest = _part_between(curve, last - back, first + whole - back)
        return RedrawnCurve(np.concatenate([rest, path[1:-1]]), True, path)
    head = _part_between(curve, 0.0, first)[:-1] if first > _LENGTH_TOLERANCE else path[:0]
    tail = _part_between(curve, last, whole)[1:] if last < whole - _LENGTH_TOLERANCE else path[:0]
    return RedrawnCurve(np.concatenate([head, path, tail]), False, path)
