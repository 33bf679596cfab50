"""Lines that show a shape of a volume in space."""

from __future__ import annotations

from itertools import product

import numpy as np

from cpm_core.field.placed_charges import RADIUS
from cpm_core.numerics.types import Array
from cpm_core.shapes import Box, BoxRegion, Charge, Points, Polygon, PrismRegion, Shape, Sphere, Stroke, Wall
from cpm_core.shapes.extruded import Extruded

_TURN = np.linspace(0.0, 2.0 * np.pi, 49)
_ARM = 2.0
"""Half the size of the cross that marks a point, in sides of the smallest voxel."""

_MOST_EDGES = 24
"""Corners of a drawn line that are joined from its first to its last slice."""


def wires(shape: Shape, sides: tuple[float, ...]) -> list[Array]:
    """Paths, each of shape (K, 3) [voxels]; none for shapes in the plane.

    `sides` are those of a voxel, in the smallest of them.
    """
    if isinstance(shape, Sphere):
        return _circles(shape.center, shape.radius, shape.sides)
    if isinstance(shape, Box | BoxRegion):
        return _edges(shape.outline)
    if isinstance(shape, PrismRegion | Wall):
        return _drawn_through(shape)
    if isinstance(shape, Charge) and len(shape.position) == 3:
        return [*_circles(shape.position, RADIUS, sides), *_cross(shape.position, sides)]
    if isinstance(shape, Stroke | Polygon) and len(shape.points[0]) == 3:
        return [shape.outline] if len(shape.points) > 1 else _cross(shape.points[0], sides)
    if isinstance(shape, Points) and len(shape.positions[0]) == 3:
        return [line for place in shape.positions for line in _cross(place, sides)]
    return []


def _circles(center: tuple[float, ...], radius: float, sides: tuple[float, ...]) -> list[Array]:
    """The circles of a sphere across the three axes."""
    round_about = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1) * radius
    return [np.array(center) + np.insert(round_about, axis, 0.0, axis=1) / np.array(sides) for axis in range(3)]


def _cross(place: tuple[float, ...], sides: tuple[float, ...]) -> list[Array]:
    arms = np.diag(_ARM / np.array(sides))
    return [np.array([place - arm, place + arm]) for arm in arms]


def _edges(corners: Array) -> list[Array]:
    """The twelve edges of a box, whose corners are in the order of `product`."""
    numbers = list(product((0, 1), repeat=3))
    pairs = ((a, b) for a in range(8) for b in range(a) if sum(map(int.__ne__, numbers[a], numbers[b])) == 1)
    return [corners[[a, b]] for a, b in pairs]


def _drawn_through(shape: Extruded) -> list[Array]:
    """The line in its first and its last slice, and edges from one to the other."""
    line = shape.flat(shape.points).outline
    first, last = (np.insert(line, shape.axis, at, axis=1) for at in (shape.first, shape.last))
    every = -(-len(line) // _MOST_EDGES)
    chosen = sorted({*range(0, len(line), every), len(line) - 1})
    return [first, last, *(np.array([first[k], last[k]]) for k in chosen)]
