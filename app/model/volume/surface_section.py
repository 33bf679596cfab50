"""The lines in which a slice cuts a surface, and what is kept with a surface."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from app.model.volume.slices import Slice
from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import Measures
from cpm_core.contours.surface import Surface
from cpm_core.numerics.types import Array, Index

_Choice = TypeVar("_Choice", bound=Hashable)
_Made = TypeVar("_Made")

_MOST = 8
"""Number of choices for which something is kept beside one surface, such as the slices that cut it."""


def kept_with_surface(make: Callable[[Surface, _Choice], _Made]) -> Callable[[Surface, _Choice], _Made]:
    """Keep what a function makes of a surface and of the latest few choices.

    What it makes is never None, and does not refer to the surface, which it would keep otherwise.
    """
    kept: WeakKeyDictionary[Surface, dict[_Choice, _Made]] = WeakKeyDictionary()

    @wraps(make)
    def made(surface: Surface, choice: _Choice) -> _Made:
        beside = kept.setdefault(surface, {})
        found = beside.pop(choice, None)
        if found is None:
            found = make(surface, choice)
        for oldest in list(beside)[: max(len(beside) - _MOST + 1, 0)]:
            beside.pop(oldest, None)
        beside[choice] = found
        return found

    return made


@dataclass(frozen=True, eq=False, slots=True)
class _Extents:
    """The triangles of a surface along an axis, in the order in which they begin.

    A slice meets only those that begin before it, by no more than the tallest is tall.
    """

    order: Index
    lowest: Array
    tallest: float

    @classmethod
    def of(cls, surface: Surface, axis: int) -> _Extents:
        corners = surface.vertices[:, axis][surface.faces]
        lowest = corners.min(axis=1)
        order = np.argsort(lowest)
        return cls(order, lowest[order], float((corners.max(axis=1) - lowest).max(initial=0.0)))

    def near(self, index: float) -> Index:
        """Triangles that a slice may cut, in their own order."""
        begin, end = np.searchsorted(self.lowest, (index - self.tallest, index))
        return np.sort(self.order[begin:end])


_extents: WeakKeyDictionary[Surface, tuple[_Extents, ...]] = WeakKeyDictionary()


def prepare(surface: Surface) -> None:
    """Make ready for slices, which takes a while for large surfaces; call it on any thread."""
    _extents_of(surface)


def _extents_of(surface: Surface) -> tuple[_Extents, ...]:
    known = _extents.get(surface)
    if known is None:
        known = _extents[surface] = tuple(_Extents.of(surface, axis) for axis in range(3))
    return known


def section(surface: Surface, cut: Slice) -> tuple[Contour, ...]:
    """Where a slice cuts a surface: closed contours in the slice, and open ones where the surface has a rim."""
    faces = surface.faces[_extents_of(surface)[cut.axis].near(cut.index)]
    heights = surface.vertices[:, cut.axis] - cut.index
    sides = heights[faces] >= 0.0  # a vertex in the slice lies on one side, so that each triangle is cut once or never
    halves = sides.sum(axis=1)
    crossing = (halves == 1) | (halves == 2)
    if not crossing.any():
        return ()
    faces, alone = faces[crossing], np.where(halves[crossing] == 1, sides[crossing].T, ~sides[crossing].T).T
    corner, rows = alone.argmax(axis=1), np.arange(len(faces))
    tip = faces[rows, corner]
    ends = np.stack([tip, faces[rows, (corner + 1) % 3], tip, faces[rows, (corner + 2) % 3]], axis=1).reshape(-1, 2)
    edges, numbers = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    first, last = heights[edges[:, 0]], heights[edges[:, 1]]
    share = (first / (first - last))[:, None]
    places = surface.vertices[edges[:, 0]] * (1.0 - share) + surface.vertices[edges[:, 1]] * share
    return _lines(cut.flattened(places), numbers.reshape(-1, 2))


def _lines(points: Array, segments: Index) -> tuple[Contour, ...]:
    """Contours along segments between points, those with ends first."""
    at: list[list[int]] = [[] for _ in range(len(points))]
    for number, (one, other) in enumerate(segments.tolist()):
        at[one].append(number)
        at[other].append(number)
    ends: list[tuple[int, int]] = [(one, other) for one, other in segments.tolist()]
    free = [True] * len(ends)

    def walk(node: int) -> list[int]:
        path = [node]
        while (number := next((number for number in at[node] if free[number]), None)) is not None:
            free[number] = False
            one, other = ends[number]
            node = other if one == node else one
            path.append(node)
        return path

    starts = [node for node, found in enumerate(at) if len(found) == 1]
    starts += [one for one, _ in ends]
    paths = [path for node in starts if len(path := walk(node)) > 2]
    return tuple(
        Contour(points[path[:-1] if path[0] == path[-1] else path], closed=path[0] == path[-1]) for path in paths
    )


def unmeasured(contour: Contour, number: int) -> Measures:
    """Measures of a section, which is shown and not listed: only its number and length are known."""
    return Measures(
        number=number,
        label=0,
        name="",
        color="",
        closed=contour.closed,
        junctions=0,
        length=contour.length,
        area=0.0,
        strength=0.0,
        contrast=None,
        inside=0,
        length_in_units=0.0,
        area_in_units=0.0,
        net_area=0.0,
        net_area_in_units=0.0,
    )
