"""What a slice of a volume shows of a shape, and the lines that show it in space."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field, replace

import numpy as np

from cpm_app.model.volume.slices import Slice
from cpm_app.model.volume.surface_section import boundary_in
from cpm_core.field import RADIUS
from cpm_core.numerics import Array, Position
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Line, Sides, frozen
from cpm_core.shapes import (
    Barrier,
    Box,
    BoxGrid,
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
    WithoutOutline,
)
from cpm_core.shapes.path import SMALLEST

NEAR = 1.0
"""Distance from a slice up to which it shows a point, in sides of the smallest voxel."""

_IN = 0.5
"""Distance from a slice up to which a place lies in it [voxels]."""


@frozen
class StartSection:
    """Where a slice cuts a start: a line or an area, with the handles and particles that the start has in the slice."""

    line: Ellipse | Polygon | Grid
    held: Line
    particles: Array = field(compare=False)

    @property
    def outline(self) -> Array:
        """The line, shape (K, 2)."""
        return self.line.outline

    def handles(self) -> Line:
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


@frozen
class RegionSection(Region):
    """Where a slice cuts a region of interest; `held` are its handles."""

    held: Line = ()

    def handles(self) -> Line:
        """Those that the shape has in this slice."""
        return self.held


@frozen
class RegionElsewhere(Region):
    """A region of interest that a slice does not cut: nothing of the slice lies in it."""

    points: Line = ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))

    @property
    def outline(self) -> Array:
        """Empty, shape (0, 2)."""
        return np.empty((0, 2))

    def handles(self) -> Line:
        """Empty."""
        return ()

    def distance(self, position: Position) -> float:
        """Infinite."""
        return math.inf


@frozen
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


def sections(shape: Shape, here: Slice, sides: Sides = (1.0, 1.0, 1.0)) -> tuple[Section, ...]:
    """The sections of a shape by a slice; empty where the slice does not show it.

    `sides` are those of a voxel in the smallest of them. Shapes in the plane belong to no volume and are not shown.
    """
    found = tuple(_sections(shape, here, sides))
    return (RegionElsewhere(),) if not found and isinstance(shape, Interest) else found


def _sections(shape: Shape, here: Slice, sides: Sides) -> Iterator[Section]:
    if isinstance(shape, Sphere):
        circle = circle_in(shape, here)
        if circle is not None:
            near = _near(shape.seeds(), here, NEAR / shape.sides[here.axis])
            yield StartSection(circle, circle.handles()[:4], _spread(near))
    elif isinstance(shape, Everywhere):
        yield shape
    elif isinstance(shape, Cuboid):
        yield from _of_box(shape, here)
    elif isinstance(shape, Extruded):
        yield from _of_extruded(shape, here)
    elif isinstance(shape, EnclosedRegion | EnclosingWall):
        for line in boundary_in(shape.surface, here):
            yield RegionSection(line) if isinstance(shape, EnclosedRegion) else Barrier((*line, line[0]))
    elif isinstance(shape, Charge) and len(shape.position) == 3:
        away = abs(shape.position[here.axis] - here.index) * sides[here.axis]
        if away <= RADIUS:
            down, right = here.within(sides)
            yield ChargeSection(here.within(shape.position), shape.strength, away, (down, right))
    elif isinstance(shape, Stroke | Polygon) and len(shape.points[0]) == 3:
        if all(abs(place[here.axis] - here.index) <= _IN for place in shape.points):
            yield replace(shape, points=tuple(map(here.within, shape.points)))
        else:
            yield from _of_particles(shape.seeds(), here)
    elif isinstance(shape, Points) and len(shape.positions[0]) == 3:
        yield from _of_particles(shape.seeds(), here)


def _of_particles(seeds: Array, here: Slice) -> Iterator[Points]:
    near = _near(seeds, here, NEAR)
    if len(near):
        yield Points(as_line(near))


def _near(seeds: Array, here: Slice, reach: float) -> Array:
    """Particles so many voxels from a slice, as places in it."""
    return here.flattened(seeds[np.abs(seeds[:, here.axis] - here.index) <= reach])


def circle_in(sphere: Sphere, here: Slice) -> Ellipse | None:
    """The circle in which a slice cuts a sphere; None where it does not."""
    square = sphere.radius**2 - ((here.index - sphere.center[here.axis]) * sphere.sides[here.axis]) ** 2
    return _circle(sphere, here, math.sqrt(square)) if square > 0.0 else None


def _circle(sphere: Sphere, here: Slice, radius: float) -> Ellipse:
    down, right = here.within(sphere.sides)
    return Ellipse(here.within(sphere.center), (max(radius / right, SMALLEST), max(radius / down, SMALLEST)))


def _of_box(box: Cuboid, here: Slice) -> Iterator[Section]:
    if not box.first[here.axis] - _IN <= here.index <= box.last[here.axis] + _IN:
        return
    (top, left), (bottom, right) = here.within(box.first), here.within(box.last)
    corners = ((top, left), (top, right), (bottom, right), (bottom, left))
    row, col = 0.5 * (top + bottom), 0.5 * (left + right)
    held = (*corners, (top, col), (row, right), (bottom, col), (row, left))
    if isinstance(box, Box):
        yield StartSection(Polygon(corners), held, _spread(_near(box.seeds(), here, max(NEAR, 0.6 * box.apart))))
    elif isinstance(box, BoxGrid):
        reach = max(NEAR, 0.5 * box.spacing) / box.sides[here.axis]
        yield StartSection(Grid(corners, box.spacing), held, _near(box.seeds(), here, reach))
    elif isinstance(box, BoxThreshold):
        yield Threshold(corners, box.fraction)
    else:
        yield RegionSection(corners, held=held)


def _spread(places: Array) -> Array:
    """One of the places in each pixel of the slice: more of them would hide each other by their rims."""
    _, first = np.unique(np.round(places), axis=0, return_index=True)
    return places[np.sort(first)]


def _of_extruded(shape: Extruded, here: Slice) -> Iterator[Shape]:
    """The line itself in the slices that it was drawn in.

    In others a strip for each stretch inside what is closed, a line for each place where a line is cut.
    """
    if here.axis == shape.axis:
        if shape.first - _IN <= here.index <= shape.last + _IN:
            flat = shape.flat(shape.points)
            yield RegionSection(flat.points, held=flat.handles()) if isinstance(flat, Region) else flat
        return
    if shape.last <= shape.first:
        return
    other = 3 - here.axis - shape.axis
    # places along the other axis where the line lies in the slice, in order: a corner in the slice lies on one side of
    # it, so that each side of the line is cut once or not at all
    corners = shape.flat(shape.points).outline[:, :: 1 if here.axis < other else -1]
    above = corners[:, 0] >= here.index
    cut = above[1:] != above[:-1]
    starts, way = corners[:-1][cut], np.diff(corners, axis=0)[cut]
    cuts = sorted((starts[:, 1] + (here.index - starts[:, 0]) / way[:, 0] * way[:, 1]).tolist())

    def turned(*places: Position) -> Line:
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


_ARM = 2.0
"""Half the size of the cross that marks a point, in sides of the smallest voxel."""

_MOST_EDGES = 24
"""Corners of a drawn line that are joined from its first to its last slice."""


def wires(shape: Shape, sides: Sides) -> Array:
    """The ends of straight lines, shape (N, 2, 3) [voxels]; none for shapes in the plane.

    `sides` are those of a voxel, in the smallest of them.
    """
    if isinstance(shape, Sphere | EnclosedRegion | EnclosingWall):
        return _through_middle(shape)
    if isinstance(shape, Cuboid):
        return _drawn_through(shape.outline[[0, 1, 3, 2, 0], 1:], 0, shape.first[0], shape.last[0])
    if isinstance(shape, Extruded):
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
    pieces = [np.empty((0, 2, 3))]
    for axis, at in enumerate(shape.center):
        here, place = Slice(axis, round(at)), at if isinstance(shape, Sphere) else round(at)
        cuts = [_circle(shape, here, shape.radius)] if isinstance(shape, Sphere) else _sections(shape, here, ())
        pieces += [_pieces_of(np.insert(cut.outline, axis, place, axis=1)) for cut in cuts]
    return np.concatenate(pieces)


def _pieces_of(path: Array) -> Array:
    """The pieces of a path, shape (K, 3)."""
    return np.stack([path[:-1], path[1:]], axis=1)


def _crosses(places: Array, sides: Sides) -> Array:
    """Three lines at each place, shape (N, 3)."""
    arms = np.diag(_ARM / np.array(sides))
    return (places[:, None, None] + np.stack([-arms, arms], axis=1)).reshape(-1, 2, 3)


def _drawn_through(line: Array, axis: int, first: float, last: float) -> Array:
    """A line in its first and its last slice, and edges from one to the other."""
    ends = [np.insert(line, axis, at, axis=1) for at in (first, last)]
    chosen = sorted({*range(0, len(line), -(-len(line) // _MOST_EDGES)), len(line) - 1})
    return np.concatenate([*map(_pieces_of, ends), np.stack([end[chosen] for end in ends], axis=1)])
