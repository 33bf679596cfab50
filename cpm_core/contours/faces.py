"""Faces: what contours enclose, alone or several that meet.

At a T or an X no contour is closed, yet the regions between them are. The contours are lines of a planar graph: where
lines end on or cross one another they are cut, and the pieces are walked around face by face.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contours
from cpm_core.numerics.polyline import repeat_indices
from cpm_core.numerics.segments import PathTree
from cpm_core.numerics.types import Array, Arrays, Integers, record
from cpm_core.parameters.formatting import format_count, format_repr

_CONTACT_DISTANCE = 0.1
"""Distance up to which the end of a contour lies on another [px]: contours are traced to 0.03 px, and files keep
hundredths. What is narrower lies between contours that run together, and is no face."""

_VERTEX_GRID = 2.0**-20
"""Spacing of the grid to which vertices are rounded, so that a vertex near a line is on it [px]."""


@record
class Face:
    """A region that contours enclose: one closed contour, or several that meet.

    Attributes
    ----------
    outer : ndarray of float64, shape (K, 2)
        Vertices (row, col) of its outer boundary in px of the image; the first is not repeated.
    holes : tuple of ndarray, each of shape (K, 2)
        Boundaries of what lies inside and is connected with it nowhere, likewise.
    contours : tuple of int
        Indices of the contours along its boundary.
    area : float
        Area without the holes [px²].
    area_in_units : float
        Area without the holes in the square of the unit of the image's spacing.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ring"), cpm.uniform_grid((64, 64)))
    >>> result.faces  # the ring, which both contours bound, and its hole
    (<Face 1,494.8 px², 1 hole, 2 contours>, <Face 309.6 px², 1 contour>)
    >>> len(result.faces[0].outer) == len(result.contours[0].points), result.faces[1].contours
    (True, (1,))
    """

    outer: Array
    holes: Arrays
    contours: Integers
    area: float
    area_in_units: float

    def __repr__(self) -> str:
        holes = format_count(len(self.holes), "hole") if self.holes else ""
        return format_repr("Face", f"{self.area:,.1f} px²", holes, format_count(len(self.contours), "contour"))


def find_faces(contours: Contours, spacing: Sequence[float] = (1.0, 1.0)) -> tuple[Face, ...]:
    """Find the faces of the net of contours, the largest first.

    Their insides are disjoint, and together they are all that the net encloses. A piece with a loose end in a face
    leaves it whole. The border of the image is no contour: what it cuts is not enclosed.

    Parameters
    ----------
    contours : sequence of Contour
        Contours in px of the image, open and closed.
    spacing : sequence of float
        Size of a pixel along (row, col), in any unit.
    """
    import shapely  # noqa: PLC0415 - takes long to load

    numbers = [number for number, contour in enumerate(contours) if len(contour.points) > 1]
    if not numbers:
        return ()
    paths = [contours[number].path for number in numbers]
    tree = PathTree(paths)
    lines = shapely.linestrings(np.concatenate(paths), indices=repeat_indices([len(path) for path in paths]))
    ends = np.concatenate([path[[0, -1]] for path in paths])
    end, path, away = tree.pairs_within(ends, _CONTACT_DISTANCE)
    off = (away > 0.0) & (path != end // 2)
    links = shapely.shortest_line(shapely.points(ends[end[off]]), lines[path[off]])
    closing = shapely.linestrings(ends.reshape(-1, 2, 2))
    closing = closing[shapely.length(closing) <= _CONTACT_DISTANCE]
    net = shapely.union_all(np.concatenate([lines, links, closing]), grid_size=_VERTEX_GRID)
    polygons = shapely.get_parts(shapely.polygonize([net]))
    area, around = shapely.area(polygons), shapely.length(polygons)
    order = np.argsort(-area, kind="stable")
    polygons = polygons[order[(2.0 * area > _CONTACT_DISTANCE * around)[order]]]
    if not len(polygons):
        return ()

    # each piece of the net lies on one contour, or on several that run together; its longest side tells on which
    points, piece = shapely.get_coordinates(shapely.get_parts(net), return_index=True)
    within = piece[1:] == piece[:-1]
    begin, end, piece = points[:-1][within], points[1:][within], piece[1:][within]
    order = np.lexsort((np.linalg.norm(end - begin, axis=1), piece))
    longest = order[np.append(np.diff(piece) > 0, True)]
    side, path, _ = tree.pairs_within(0.5 * (begin + end)[longest], 2.0 * _VERTEX_GRID)
    contours_at: dict[complex, set[int]] = {}
    for middle, number in zip(_middles(begin, end)[longest[side]].tolist(), path.tolist(), strict=True):
        contours_at.setdefault(middle, set()).add(numbers[number])

    found = []
    for polygon, own in zip(polygons, shapely.area(polygons).tolist(), strict=True):
        rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(polygon)]
        sides = (middle for ring in rings for middle in _middles(ring[:-1], ring[1:]).tolist())
        along = set().union(*(contours_at.get(middle, ()) for middle in sides))
        outer, *holes = (ring[:-1] for ring in rings)
        found.append(Face(outer, tuple(holes), tuple(sorted(along)), own, own * float(np.prod(spacing))))
    return tuple(found)


def _middles(begin: Array, end: Array) -> NDArray[np.complex128]:
    """Return twice the middle of sides, shape (N,), the same to the bit in both directions."""
    return np.ascontiguousarray(begin + end).view(np.complex128)[:, 0]
