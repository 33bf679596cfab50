"""The lines in which a slice cuts a surface."""

from __future__ import annotations

import numpy as np

from app.model.volume.slices import Slice
from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import Measures
from cpm_core.contours.surface import Surface
from cpm_core.numerics.types import Array, Index


def section(surface: Surface, cut: Slice) -> tuple[Contour, ...]:
    """Where a slice cuts a surface: closed contours in the slice, and open ones where the surface has a rim."""
    heights = surface.vertices[:, cut.axis] - cut.index
    above = heights >= 0.0  # a vertex in the slice lies on one side, so that each triangle is cut once or not at all
    sides = above[surface.faces]
    halves = sides.sum(axis=1)
    crossing = (halves == 1) | (halves == 2)
    if not crossing.any():
        return ()
    faces, alone = surface.faces[crossing], np.where(halves[crossing] == 1, sides[crossing].T, ~sides[crossing].T).T
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
