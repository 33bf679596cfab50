"""Lines that show a shape of a volume in space."""

from __future__ import annotations

from itertools import product

import numpy as np

from app.model.volume.slices import Slice
from app.model.volume.surface_section import section
from cpm_core.field.placed_charges import RADIUS
from cpm_core.numerics.types import Array
from cpm_core.shapes import (
    Box,
    BoxGrid,
    BoxRegion,
    BoxThreshold,
    Charge,
    EnclosedRegion,
    EnclosingWall,
    Points,
    Polygon,
    PrismRegion,
    Shape,
    Sphere,
    Stroke,
    Wall,
)
from cpm_core.shapes.volume_limits import Extruded

_TURN = np.linspace(0.0, 2.0 * np.pi, 49)
_ARM = 2.0
"""Half the size of the cross that marks a point, in sides of the smallest voxel."""

_MOST_EDGES = 24
"""Corners of a drawn line that are joined from its first to its last slice."""


def wires(shape: Shape, sides: tuple[float, ...]) -> Array:
    """The ends of straight lines, shape (N, 2, 3) [voxels]; none for shapes in the plane.

    `sides` are those of a voxel, in the smallest of them.
    """
    if isinstance(shape, Sphere):
        return _circles(shape.center, shape.radius, shape.sides)
    if isinstance(shape, Box | BoxRegion | BoxGrid | BoxThreshold):
        return np.asarray(shape.outline[_EDGES])
    if isinstance(shape, PrismRegion | Wall):
        return _drawn_through(shape)
    if isinstance(shape, EnclosedRegion | EnclosingWall):
        return _around(shape)
    if isinstance(shape, Charge) and len(shape.position) == 3:
        ball = _circles(shape.position, RADIUS, sides)
        return np.concatenate([ball, _crosses(np.array([shape.position]), sides)])
    if isinstance(shape, Stroke | Polygon) and len(shape.points[0]) == 3:
        return _along(shape.outline) if len(shape.points) > 1 else _crosses(shape.outline, sides)
    if isinstance(shape, Points) and len(shape.positions[0]) == 3:
        return _crosses(shape.seeds(), sides)
    return np.empty((0, 2, 3))


def _around(shape: EnclosedRegion | EnclosingWall) -> Array:
    """The lines in which slices through its middle, one across each axis, cut a surface."""
    cuts = (Slice(axis, round(at)) for axis, at in enumerate(shape.center))
    paths = (
        np.insert(line.path, cut.axis, cut.index, axis=1)
        for cut in cuts
        for line in section(shape.surface.surface, cut)
    )
    return np.concatenate([np.empty((0, 2, 3)), *map(_along, paths)])


def _along(path: Array) -> Array:
    """The pieces of a path, shape (K, 3)."""
    return np.stack([path[:-1], path[1:]], axis=1)


def _circles(center: tuple[float, ...], radius: float, sides: tuple[float, ...]) -> Array:
    """The circles of a sphere across the three axes."""
    circle = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1) * radius
    turned = (np.array(center) + np.insert(circle, axis, 0.0, axis=1) / np.array(sides) for axis in range(3))
    return np.concatenate([_along(path) for path in turned])


def _crosses(places: Array, sides: tuple[float, ...]) -> Array:
    """Three lines at each place, shape (N, 3)."""
    arms = np.diag(_ARM / np.array(sides))
    return (places[:, None, None] + np.stack([-arms, arms], axis=1)).reshape(-1, 2, 3)


_CORNERS = list(product((0, 1), repeat=3))
_EDGES = np.array(
    [
        (one, other)
        for other in range(8)
        for one in range(other)
        if sum(a != b for a, b in zip(_CORNERS[one], _CORNERS[other], strict=True)) == 1
    ]
)
"""Numbers of the corners of a box that its twelve edges join."""


def _drawn_through(shape: Extruded) -> Array:
    """The line in its first and its last slice, and edges from one to the other."""
    line = shape.flat(shape.points).outline
    first, last = (np.insert(line, shape.axis, at, axis=1) for at in (shape.first, shape.last))
    every = -(-len(line) // _MOST_EDGES)
    chosen = sorted({*range(0, len(line), every), len(line) - 1})
    return np.concatenate([_along(first), _along(last), np.stack([first[chosen], last[chosen]], axis=1)])
