"""Polygonal lines that can be taken apart and joined, and remember which of their segments were drawn by hand."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour, Curve
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Mask, Position, record

_LENGTH_TOLERANCE = 1e-6
"""Length below which a part of a line counts as empty [px]."""

_PATH_SAMPLING = 0.5
"""Distance between the samples along a line that are compared with a path [px]."""


@record
class PolygonalLine(Curve):
    """A line through vertices; lengths along it begin at its first vertex.

    Attributes
    ----------
    points : ndarray, shape (K, 2)
        Vertices (row, col) [px].
    closed : bool
        Whether the last vertex is joined to the first.
    drawn : ndarray of bool, shape (K - 1,) or (K,) when closed
        Which segments were drawn by hand.
    junctions : tuple of two bool
        Whether its ends lie on a junction.
    source : Contour or None
        The contour that it is, unchanged; None for any other.
    """

    drawn: Mask
    junctions: tuple[bool, bool] = (False, False)
    source: Contour | None = field(default=None, repr=False)

    @classmethod
    def from_contour(cls, contour: Contour) -> PolygonalLine:
        """Convert a contour to a line."""
        drawn = np.zeros(len(contour.path) - 1, bool)
        return cls(contour.points, contour.closed, drawn, contour.junctions, contour)

    @classmethod
    def from_drawn_points(cls, points: Array, closed: bool = False) -> PolygonalLine:
        """Build a line through vertices, shape (K, 2) [px], that is drawn by hand as a whole."""
        return cls(points, closed, np.ones(len(points) - (not closed), bool))

    @cached_property
    def lengths(self) -> Array:
        """Length along the line up to each vertex of `path` [px]."""
        return polyline.lengths_along(self.path)

    @property
    def length(self) -> float:
        """Length of the line [px]."""
        return float(self.lengths[-1])

    def passes_near(self, place: Position, reach: float) -> bool:
        """Return whether the line passes within reach of a place [px]."""
        return self.project_point(place)[1] <= reach

    @cached_property
    def _line(self) -> Any:
        """The line for shapely, which needs two vertices."""
        import shapely  # noqa: PLC0415 - needed for few edits

        return shapely.LineString(np.concatenate([self.path, self.path[-1:]]))

    def project_point(self, place: Position) -> tuple[float, float]:
        """Return the length along the line up to its place nearest to another one, and the distance of the two [px]."""
        import shapely  # noqa: PLC0415

        point = shapely.Point(place)
        return float(self._line.project(point)), float(self._line.distance(point))

    def part_between(self, first: float, last: float) -> PolygonalLine:
        """Return the open line between two lengths along it; on a closed line the second may go once around."""
        path, drawn, lengths = self.path, self.drawn, self.lengths
        if self.closed:
            path = np.concatenate([path, path[1:]])
            drawn = np.concatenate([drawn, drawn])
            lengths = np.concatenate([lengths, lengths[1:] + self.length])
        inner = lengths[(lengths > first + _LENGTH_TOLERANCE) & (lengths < last - _LENGTH_TOLERANCE)]
        at = np.concatenate([[first], inner, [last]])
        points = np.stack([np.interp(at, lengths, axis) for axis in path.T], axis=1)
        segment = np.searchsorted(lengths, 0.5 * (at[1:] + at[:-1]), side="right") - 1
        whole = not self.closed
        begins, ends = whole and first <= _LENGTH_TOLERANCE, whole and last >= self.length - _LENGTH_TOLERANCE
        junctions = (begins and self.junctions[0], ends and self.junctions[1])
        return PolygonalLine(points, False, drawn[np.clip(segment, 0, len(drawn) - 1)], junctions)

    def split_at(self, cuts: Iterable[float]) -> list[PolygonalLine]:
        """Split the line at lengths along it; without any a closed line stays whole, one opens it."""
        at = sorted(set(cuts))
        if self.closed:
            ends = [*at, *(cut + self.length for cut in at[:1])]
        else:
            ends = [0.0, *(cut for cut in at if _LENGTH_TOLERANCE < cut < self.length - _LENGTH_TOLERANCE), self.length]
            if len(ends) == 2:
                return [self]
        found = [self.part_between(a, b) for a, b in pairwise(ends) if b - a > _LENGTH_TOLERANCE]
        return found or [self]

    def follows_path(self, path: Array, reach: float) -> bool:
        """Return whether all of the line lies within reach of a path, shape (K, 2) [px]."""
        samples = np.concatenate([self.path[[0, -1]], polyline.sample_path(self.path, _PATH_SAMPLING)])
        return bool((polyline.distances_to_path(path, samples) <= reach).all())

    def reversed(self) -> PolygonalLine:
        """Reverse the direction of the line; the segment that closes it stays the last."""
        drawn = np.concatenate([self.drawn[-2::-1], self.drawn[-1:]]) if self.closed else self.drawn[::-1]
        return replace(self, points=self.points[::-1], drawn=drawn, junctions=self.junctions[::-1])

    def to_contour(self) -> Contour:
        """Convert the line to a contour: its source, or a new one without strength and contrast."""
        if self.source is not None:
            return self.source
        change = np.flatnonzero(np.diff(self.drawn)) + 1
        bounds = [0, *change.tolist(), len(self.drawn)]
        drawn = tuple(self.path[a : b + 1] for a, b in pairwise(bounds) if b > a and self.drawn[a])
        return Contour(self.points, self.closed, junctions=self.junctions, by_hand=drawn)


def join_lines(first: PolygonalLine, second: PolygonalLine) -> PolygonalLine:
    """Join two open lines, the end of the first to the beginning of the second; the gap counts as drawn by hand."""
    touching = _are_coincident(first.points[-1], second.points[0])
    points = np.concatenate([first.points, second.points[touching:]])
    drawn = np.concatenate([first.drawn, [] if touching else [True], second.drawn]).astype(bool)
    return PolygonalLine(points, False, drawn, (first.junctions[0], second.junctions[1]))


def close_line(line: PolygonalLine) -> PolygonalLine:
    """Close an open line of three vertices or more; the segment between its ends counts as drawn by hand."""
    if _are_coincident(line.points[-1], line.points[0]):
        return PolygonalLine(line.points[:-1], True, line.drawn)
    return PolygonalLine(line.points, True, np.append(line.drawn, True))


def _are_coincident(a: Array, b: Array) -> bool:
    return float(np.linalg.norm(a - b)) <= _LENGTH_TOLERANCE
