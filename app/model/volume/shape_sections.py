"""What a slice of a volume shows of a shape, and the lines that show it in space."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.model.volume.slices import Slice
from app.model.volume.surface_section import section
from cpm_core.field import RADIUS
from cpm_core.numerics import Array, Position
from cpm_core.shapes import (
    Barrier,
    Box,
    BoxGrid,
    BoxRegion,
    BoxThreshold,
    Charge,
    Cuboid,
    Ellipse,
    EnclosedRegion,
    EnclosingWall,
    Everywhere,
    Extruded,
    Grid,
    Interest,
    Points,
    Polygon,
    PrismRegion,
    Region,
    Shape,
    Sphere,
    Stroke,
    Threshold,
    Wall,
    WithoutOutline,
)
from cpm_core.shapes.path import SMALLEST

NEAR = 1.0
"""Distance from a slice up to which it shows a point, in sides of the smallest voxel."""

_IN = 0.5
"""Distance from a slice up to which a place lies in it [voxels]."""


@dataclass(frozen=True, slots=True)
class StartSection:
    """Where a slice cuts a start: a line or an area, with the handles and particles that the start has in the slice."""

    line: Ellipse | Polygon | Grid
    held: tuple[Position, ...]
    particles: Array = field(compare=False)

    @property
    def outline(self) -> Array:
        """The line, shape (K, 2)."""
        return self.line.outline

    def handles(self) -> tuple[Position, ...]:
        """Those of the start that lie in the slice."""
        return self.held

    def seeds(self) -> Array:
        """The particles of the start that lie near the slice, shape (N, 2)."""
        return self.particles

    def distance(self, position: Position) -> float:
        """Distance of a position from the line [px]."""
        return self.line.distance(position)

    def encloses(self, position: Position) -> bool:
        """Whether a position lies inside."""
        return self.line.encloses(position)


@dataclass(frozen=True, slots=True)
class RegionSection(Region):
    """Where a slice cuts a region of interest; `held` are its handles."""

    held: tuple[Position, ...] = ()

    def handles(self) -> tuple[Position, ...]:
        """Those that the shape has in this slice."""
        return self.held


@dataclass(frozen=True, slots=True)
class RegionElsewhere(Region):
    """A region of interest that a slice does not cut: nothing of the slice lies in it."""

    points: tuple[Position, ...] = ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))

    @property
    def outline(self) -> Array:
        """Empty, shape (0, 2)."""
        return np.empty((0, 2))

    def handles(self) -> tuple[Position, ...]:
        """Empty."""
        return ()

    def distance(self, position: Position) -> float:
        """Infinite."""
        return math.inf


@dataclass(frozen=True, slots=True)
class ChargeSection(WithoutOutline):
    """A charge that acts in a slice.

    Attributes
    ----------
    position : tuple of float
        The nearest position in the slice.
    strength : float
        As that of the charge.
    away : float
        Distance of the charge from the slice, in sides of the smallest voxel.
    sides : tuple of float
        Sides of a voxel in the slice, in the smallest side of a voxel.
    """

    position: Position
    strength: float
    away: float
    sides: tuple[float, float]

    @property
    def in_slice(self) -> bool:
        """Whether the charge itself lies in the slice."""
        return self.away <= NEAR

    def ring(self, radius: float) -> Array:
        """Where the slice cuts a sphere around the charge, shape (K, 2); empty where it does not."""
        cut = math.sqrt(max(radius**2 - self.away**2, 0.0))
        if cut < SMALLEST:
            return np.empty((0, 2))
        down, right = self.sides
        return Ellipse(self.position, (max(cut / right, SMALLEST), max(cut / down, SMALLEST))).outline

    def distance(self, position: Position) -> float:
        """Distance of a position from the charge [px]; infinite where it is only its effect that the slice shows."""
        return math.dist(self.position, position) if self.in_slice else math.inf


Section = Shape | StartSection | ChargeSection


def sections(shape: Shape, axis: int, index: float, sides: Sequence[float] = (1.0, 1.0, 1.0)) -> tuple[Section, ...]:
    """The sections of a shape by a slice; empty where the slice does not show it.

    `index` is the place of the slice along `axis` [voxels], `sides` are those of a voxel in the smallest of them.
    Shapes in the plane belong to no volume and are not shown.
    """
    found = tuple(_sections(shape, axis, index, sides))
    return (RegionElsewhere(),) if not found and isinstance(shape, Interest) else found


def _sections(shape: Shape, axis: int, index: float, sides: Sequence[float]) -> Iterator[Section]:
    if isinstance(shape, Sphere):
        yield from _of_sphere(shape, axis, index)
    elif isinstance(shape, Everywhere):
        yield shape
    elif isinstance(shape, Box | BoxRegion | BoxGrid | BoxThreshold):
        yield from _of_box(shape, axis, index)
    elif isinstance(shape, PrismRegion | Wall):
        yield from _of_extruded(shape, axis, index)
    elif isinstance(shape, EnclosedRegion | EnclosingWall):
        for line in section(shape.surface.surface, Slice(axis, round(index))):
            corners = tuple((row, col) for row, col in line.points.tolist())
            if line.closed and len(set(corners)) > 2:
                yield RegionSection(corners) if isinstance(shape, EnclosedRegion) else Barrier((*corners, corners[0]))
    elif isinstance(shape, Charge) and len(shape.position) == 3:
        away = abs(shape.position[axis] - index) * sides[axis]
        if away <= RADIUS:
            down, right = _flat(sides, axis)
            yield ChargeSection(_flat(shape.position, axis), shape.strength, away, (down, right))
    elif isinstance(shape, Stroke | Polygon) and len(shape.points[0]) == 3:
        if all(abs(place[axis] - index) <= _IN for place in shape.points):
            yield replace(shape, points=tuple(_flat(place, axis) for place in shape.points))
        else:  # its particles near the slice
            yield from _of_points(shape.seeds().tolist(), axis, index)
    elif isinstance(shape, Points) and len(shape.positions[0]) == 3:
        yield from _of_points(shape.positions, axis, index)


def _flat(place: Sequence[float], axis: int) -> Position:
    return tuple(place[:axis]) + tuple(place[axis + 1 :])


def _of_points(places: Sequence[Sequence[float]], axis: int, index: float) -> Iterator[Points]:
    near = tuple(_flat(place, axis) for place in places if abs(place[axis] - index) <= NEAR)
    if near:
        yield Points(near)


def _of_sphere(sphere: Sphere, axis: int, index: float) -> Iterator[StartSection]:
    off = (index - sphere.center[axis]) * sphere.sides[axis]
    if abs(off) >= sphere.radius:
        return
    radius = math.sqrt(sphere.radius**2 - off**2)
    center, (down, right) = (_flat(values, axis) for values in (sphere.center, sphere.sides))
    line = Ellipse(center, (max(radius / right, SMALLEST), max(radius / down, SMALLEST)))
    near = _seeds_near(sphere, axis, index, NEAR / sphere.sides[axis])
    yield StartSection(line, line.handles()[:4], _spread(near))


def _seeds_near(start: Sphere | Box | BoxGrid, axis: int, index: float, reach: float) -> Array:
    """The particles of a start so many voxels from a slice, as places in it."""
    seeds = start.seeds()
    return np.delete(seeds[np.abs(seeds[:, axis] - index) <= reach], axis, axis=1)


def _of_box(box: Cuboid, axis: int, index: float) -> Iterator[Section]:
    if not box.first[axis] - _IN <= index <= box.last[axis] + _IN:
        return
    (top, left), (bottom, right) = _flat(box.first, axis), _flat(box.last, axis)
    corners = ((top, left), (top, right), (bottom, right), (bottom, left))
    row, col = 0.5 * (top + bottom), 0.5 * (left + right)
    held = (*corners, (top, col), (row, right), (bottom, col), (row, left))
    if isinstance(box, Box):
        yield StartSection(Polygon(corners), held, _spread(_seeds_near(box, axis, index, max(NEAR, 0.6 * box.apart))))
    elif isinstance(box, BoxGrid):
        reach = max(NEAR, 0.5 * box.spacing) / box.sides[axis]
        yield StartSection(Grid(corners, box.spacing), held, _seeds_near(box, axis, index, reach))
    elif isinstance(box, BoxThreshold):
        yield Threshold(corners, box.fraction)
    else:
        yield RegionSection(corners, held=held)


def _spread(places: Array) -> Array:
    """One of the places in each pixel of the slice: more of them would hide each other by their rims."""
    _, first = np.unique(np.round(places), axis=0, return_index=True)
    return places[np.sort(first)]


def _of_extruded(shape: Extruded, axis: int, index: float) -> Iterator[Shape]:
    """The line itself in the slices that it was drawn in.

    In others a strip for each stretch inside what is closed, a line for each place where a line is cut.
    """
    if axis == shape.axis:
        if shape.first - _IN <= index <= shape.last + _IN:
            flat = shape.flat(shape.points)
            yield RegionSection(flat.points, held=flat.handles()) if isinstance(flat, Region) else flat
        return
    if shape.last <= shape.first:
        return
    other = next(one for one in range(3) if one not in (axis, shape.axis))
    cuts = _crossings(shape, axis, index, other)

    def turned(*places: Position) -> tuple[Position, ...]:
        """Places along the range and the other axis, of which the first one runs down."""
        return places if shape.axis < other else tuple((right, down) for down, right in places)

    if isinstance(shape, PrismRegion):
        for begin, end in zip(cuts[::2], cuts[1::2], strict=False):
            if end - begin > 1e-6:
                ends = ((shape.first, begin), (shape.first, end), (shape.last, end), (shape.last, begin))
                middle = 0.5 * (begin + end)
                yield RegionSection(turned(*ends), held=turned((shape.first, middle), (shape.last, middle)))
    else:
        for at in cuts:
            yield Barrier(turned((shape.first, at), (shape.last, at)))


def _crossings(shape: Extruded, axis: int, index: float, other: int) -> list[float]:
    """Places along the other axis where the line lies in a slice, in order."""
    corners = shape.flat(shape.points).outline
    here, there = (sorted((axis, other)).index(one) for one in (axis, other))
    # a corner in the slice lies on one side of it, so that each side of the line is cut once or not at all
    above = corners[:, here] >= index
    cut = above[1:] != above[:-1]
    begin, end = corners[:-1][cut], corners[1:][cut]
    share = (index - begin[:, here]) / (end[:, here] - begin[:, here])
    found: list[float] = sorted((begin[:, there] + share * (end - begin)[:, there]).tolist())
    return found


_ARM = 2.0
"""Half the size of the cross that marks a point, in sides of the smallest voxel."""

_MOST_EDGES = 24
"""Corners of a drawn line that are joined from its first to its last slice."""


def wires(shape: Shape, sides: tuple[float, ...]) -> Array:
    """The ends of straight lines, shape (N, 2, 3) [voxels]; none for shapes in the plane.

    `sides` are those of a voxel, in the smallest of them.
    """
    if isinstance(shape, Sphere | EnclosedRegion | EnclosingWall):
        return _through_middle(shape)
    if isinstance(shape, Box | BoxRegion | BoxGrid | BoxThreshold):
        return _drawn_through(shape.outline[[0, 1, 3, 2, 0], 1:], 0, shape.first[0], shape.last[0])
    if isinstance(shape, PrismRegion | Wall):
        return _drawn_through(shape.flat(shape.points).outline, shape.axis, shape.first, shape.last)
    if isinstance(shape, Charge) and len(shape.position) == 3:
        ball = _through_middle(Sphere(shape.position, RADIUS, sides))
        return np.concatenate([ball, _crosses(np.array([shape.position]), sides)])
    if isinstance(shape, Stroke | Polygon) and len(shape.points[0]) == 3:
        return _pieces_of(shape.outline) if len(shape.points) > 1 else _crosses(shape.outline, sides)
    if isinstance(shape, Points) and len(shape.positions[0]) == 3:
        return _crosses(shape.seeds(), sides)
    return np.empty((0, 2, 3))


def _through_middle(shape: Sphere | EnclosedRegion | EnclosingWall) -> Array:
    """The lines in which slices through its middle, one across each axis, cut a shape."""
    paths = (
        np.insert(cut.outline, axis, at, axis=1)
        for axis, at in enumerate(shape.center if isinstance(shape, Sphere) else map(round, shape.center))
        for cut in _sections(shape, axis, at, ())
    )
    return np.concatenate([np.empty((0, 2, 3)), *map(_pieces_of, paths)])


def _pieces_of(path: Array) -> Array:
    """The pieces of a path, shape (K, 3)."""
    return np.stack([path[:-1], path[1:]], axis=1)


def _crosses(places: Array, sides: tuple[float, ...]) -> Array:
    """Three lines at each place, shape (N, 3)."""
    arms = np.diag(_ARM / np.array(sides))
    return (places[:, None, None] + np.stack([-arms, arms], axis=1)).reshape(-1, 2, 3)


def _drawn_through(line: Array, axis: int, first: float, last: float) -> Array:
    """A line in its first and its last slice, and edges from one to the other."""
    ends = [np.insert(line, axis, at, axis=1) for at in (first, last)]
    chosen = sorted({*range(0, len(line), -(-len(line) // _MOST_EDGES)), len(line) - 1})
    return np.concatenate([*map(_pieces_of, ends), np.stack([end[chosen] for end in ends], axis=1)])
