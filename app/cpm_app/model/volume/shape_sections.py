"""Cuts of shapes by a slice of a volume, and the lines that show shapes in space."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field, replace

import numpy as np

from cpm_app.model.volume.slices import Slice
from cpm_app.model.volume.surface_section import cut_region
from cpm_core.field import CHARGE_RADIUS
from cpm_core.numerics import Array, Position, polyline
from cpm_core.numerics.polyline import as_line, pair_neighbors
from cpm_core.numerics.types import NO_POINTS, Line, Sides, record
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
    Interest,
    Measure,
    Points,
    Polygon,
    PrismRegion,
    Shape,
    Sphere,
    Stroke,
    Threshold,
    Wall,
)
from cpm_core.shapes.path import MIN_SIZE

NEAR_SLICE_DISTANCE = 1.0
"""Largest distance of a point that a slice shows, in smallest sides of a voxel."""

_IN_SLICE_DISTANCE = 0.5
"""Largest distance of a point that lies in a slice [voxels]."""


@record
class Cut:
    """What a slice shows of a shape of a volume.

    Attributes
    ----------
    shape : Shape
        The shape.
    outline : ndarray, shape (K, 2)
        Line in the slice, of a charge its position; empty where the slice shows only the effect of the shape.
    held : tuple of tuple of float
        Handles of the shape in the slice.
    particles : ndarray, shape (N, 2)
        Particles of the shape near the slice.
    """

    shape: Shape
    outline: Array
    held: Line = ()
    particles: Array = field(default_factory=lambda: NO_POINTS)

    def handles(self) -> Line:
        """Return the handles of the shape in the slice."""
        return self.held

    def seeds(self) -> Array:
        """Return the particles of the shape near the slice, shape (N, 2)."""
        return self.particles

    def distance_to(self, position: Position) -> float:
        """Return the distance of a position from the line [px]; infinite without one."""
        return polyline.distance_to_path(self.outline, position) if len(self.outline) else math.inf

    def encloses(self, position: Position) -> bool:
        """Tell whether a position lies inside."""
        return len(self.outline) > 2 and bool(polyline.points_inside(self.outline, np.array([position]))[0])


Section = Shape | Cut


def whole_shape(section: Section | None) -> Shape | None:
    """Return the shape that a section is a cut of, or the shape itself."""
    return section.shape if isinstance(section, Cut) else section


def cut_shape(shape: Shape, here: Slice, sides: Sides = (1.0, 1.0, 1.0)) -> tuple[Section, ...]:
    """Cut a shape by a slice; empty where the slice does not show it.

    `sides` are the sides of a voxel in units of the smallest. Shapes in the plane belong to no volume and are not
    shown.
    """
    found = tuple(_iterate_cuts(shape, here, sides))
    # nothing in the slice lies inside a region of interest that it does not cut
    return (Cut(shape, NO_POINTS),) if not found and isinstance(shape, Interest) else found


def _iterate_cuts(shape: Shape, here: Slice, sides: Sides) -> Iterator[Section]:
    if isinstance(shape, Sphere):
        circle = cut_sphere(shape, here)
        if circle is not None:
            near = _select_near(shape.seeds(), here, NEAR_SLICE_DISTANCE / shape.sides[here.axis])
            yield Cut(shape, circle.outline, circle.handles()[:4], _keep_one_per_pixel(near))
    elif isinstance(shape, Everywhere):
        yield shape
    elif isinstance(shape, Box | BoxGrid | BoxThreshold | BoxRegion):
        yield from _cut_box(shape, here)
    elif isinstance(shape, PrismRegion | Wall):
        sections = _cut_extruded(shape, here)
        yield from map(_transpose_section, sections) if here.transposed else sections
    elif isinstance(shape, EnclosedRegion | EnclosingWall):
        for line in cut_region(shape.region, here):
            yield Cut(shape, _close_line(line)) if isinstance(shape, EnclosedRegion) else Barrier((*line, line[0]))
    elif isinstance(shape, Charge) and len(shape.position) == 3:
        away = abs(shape.position[here.axis] - here.index) * sides[here.axis]
        if away <= CHARGE_RADIUS:
            places = [here.drop_axis(shape.position)] if away <= NEAR_SLICE_DISTANCE else []
            yield Cut(shape, np.array(places, float).reshape(-1, 2))
    elif isinstance(shape, Stroke | Polygon) and len(shape.points[0]) == 3:
        if all(abs(place[here.axis] - here.index) <= _IN_SLICE_DISTANCE for place in shape.points):
            yield replace(shape, points=tuple(map(here.drop_axis, shape.points)))
        else:
            yield from _cut_particles(shape.seeds(), here)
    elif isinstance(shape, Points) and len(shape.positions[0]) == 3:
        yield from _cut_particles(shape.seeds(), here)
    elif isinstance(shape, Measure) and shape.outline.shape[1] == 3:
        yield from _cut_measure(shape, here)


def _cut_measure(shape: Measure, here: Slice) -> Iterator[Cut]:
    """Yield a measure in the slice that it lies in, else in all from its first to its last point.

    Only handles in the slice are held.
    """
    along, flat = shape.outline[:, here.axis], np.ptp(shape.outline, axis=0) <= _IN_SLICE_DISTANCE
    if (
        flat[here.axis] or not flat.any()
    ) and along.min() - _IN_SLICE_DISTANCE <= here.index <= along.max() + _IN_SLICE_DISTANCE:
        held = (at for at in shape.handles() if abs(at[here.axis] - here.index) <= _IN_SLICE_DISTANCE)
        yield Cut(shape, here.project_points(shape.outline), tuple(map(here.drop_axis, held)))


def _cut_particles(seeds: Array, here: Slice) -> Iterator[Points]:
    near = _select_near(seeds, here, NEAR_SLICE_DISTANCE)
    if len(near):
        yield Points(as_line(near))


def _select_near(seeds: Array, here: Slice, max_distance: float) -> Array:
    """Return the particles within `max_distance` voxels of a slice, as positions in it, shape (N, 2)."""
    return here.project_points(seeds[np.abs(seeds[:, here.axis] - here.index) <= max_distance])


def cut_sphere(sphere: Sphere, here: Slice) -> Ellipse | None:
    """Return the circle in which a slice cuts a sphere; None where it does not."""
    square = sphere.radius**2 - ((here.index - sphere.center[here.axis]) * sphere.sides[here.axis]) ** 2
    return _build_section_circle(sphere, here, math.sqrt(square)) if square > 0.0 else None


def _build_section_circle(sphere: Sphere, here: Slice, radius: float) -> Ellipse:
    down, right = here.drop_axis(sphere.sides)
    return Ellipse(here.drop_axis(sphere.center), (max(radius / right, MIN_SIZE), max(radius / down, MIN_SIZE)))


def _cut_box(box: Box | BoxGrid | BoxThreshold | BoxRegion, here: Slice) -> Iterator[Section]:
    if not box.first[here.axis] - _IN_SLICE_DISTANCE <= here.index <= box.last[here.axis] + _IN_SLICE_DISTANCE:
        return
    (top, left), (bottom, right) = here.drop_axis(box.first), here.drop_axis(box.last)
    corners = ((top, left), (top, right), (bottom, right), (bottom, left))
    row, col = 0.5 * (top + bottom), 0.5 * (left + right)
    held = (*corners, (top, col), (row, right), (bottom, col), (row, left))
    if isinstance(box, BoxThreshold):
        yield Threshold(corners, box.fraction)
        return
    near = NO_POINTS
    if isinstance(box, Box):
        reach = max(NEAR_SLICE_DISTANCE, 0.6 * box.particle_spacing)
        near = _keep_one_per_pixel(_select_near(box.seeds(), here, reach))
    elif isinstance(box, BoxGrid):
        reach = max(NEAR_SLICE_DISTANCE, 0.5 * box.spacing) / box.sides[here.axis]
        near = _select_near(box.seeds(), here, reach)
    yield Cut(box, _close_line(corners), held, near)


def _keep_one_per_pixel(places: Array) -> Array:
    """Keep one position in each pixel of the slice: more would hide one another by their rims."""
    _, first = np.unique(np.round(places), axis=0, return_index=True)
    return places[np.sort(first)]


def _cut_extruded(shape: PrismRegion | Wall, here: Slice) -> Iterator[Barrier | Cut]:
    """Yield the line itself in the slices that it was drawn in, and its cuts in others, in slices not transposed.

    A closed line gives a strip for each stretch inside, an open one a line at each crossing.
    """
    if here.axis == shape.axis:
        if shape.first - _IN_SLICE_DISTANCE <= here.index <= shape.last + _IN_SLICE_DISTANCE:
            flat = shape.flat(shape.points)
            yield flat if isinstance(flat, Barrier) else Cut(shape, flat.outline, flat.handles())
        return
    if shape.last <= shape.first:
        return
    other = 3 - here.axis - shape.axis
    # positions along the other axis where the line crosses the slice, in order; a corner in the slice counts as below
    # it, so that each side of the line is cut once or not at all
    corners = shape.flat(shape.points).outline[:, :: 1 if here.axis < other else -1]
    above = corners[:, 0] >= here.index
    cut = above[1:] != above[:-1]
    starts, way = corners[:-1][cut], np.diff(corners, axis=0)[cut]
    cuts = sorted((starts[:, 1] + (here.index - starts[:, 0]) / way[:, 0] * way[:, 1]).tolist())

    def order_axes(*positions: Position) -> Line:
        """Convert positions (range, other axis) to (row, col)."""
        return positions if shape.axis < other else tuple((right, down) for down, right in positions)

    if isinstance(shape, PrismRegion):
        for begin, end in zip(cuts[::2], cuts[1::2], strict=False):
            if end - begin > 1e-6:
                ends = ((shape.first, begin), (shape.first, end), (shape.last, end), (shape.last, begin))
                middle = 0.5 * (begin + end)
                held = order_axes((shape.first, middle), (shape.last, middle))
                yield Cut(shape, _close_line(order_axes(*ends)), held)
    else:
        for at in cuts:
            yield Barrier(order_axes((shape.first, at), (shape.last, at)))


def _transpose_section(section: Barrier | Cut) -> Barrier | Cut:
    """Exchange rows and columns of a section."""
    if isinstance(section, Barrier):
        return replace(section, points=_transpose_line(section.points))
    return replace(section, outline=section.outline[:, ::-1], held=_transpose_line(section.held))


def _transpose_line(line: Line) -> Line:
    return tuple((col, row) for row, col in line)


def _close_line(corners: Line) -> Array:
    """Return the vertices of a closed line, shape (K, 2), the first repeated at the end."""
    return np.array([*corners, corners[0]])


_CROSS_ARM = 2.0
"""Half the size of the cross that marks a point, in smallest sides of a voxel."""

_MAX_EXTRUDED_EDGES = 24
"""Largest number of edges between the first and the last slice of an extruded line."""


def build_shape_wires(shape: Shape, sides: Sides) -> Array:
    """Return the ends of straight lines that show a shape, shape (N, 2, 3) [voxels]; none for shapes in the plane.

    `sides` are the sides of a voxel in units of the smallest.
    """
    if isinstance(shape, Sphere | EnclosedRegion | EnclosingWall):
        return _outline_middle_cuts(shape)
    if isinstance(shape, Cuboid):
        return _extrude_line(shape.outline[[0, 1, 3, 2, 0], 1:], 0, shape.first[0], shape.last[0])
    if isinstance(shape, Extruded):
        return _extrude_line(shape.flat(shape.points).outline, shape.axis, shape.first, shape.last)
    if isinstance(shape, Charge) and len(shape.position) == 3:
        ball = _outline_middle_cuts(Sphere(shape.position, CHARGE_RADIUS, sides))
        return np.concatenate([ball, _build_crosses(np.array([shape.position]), sides)])
    if isinstance(shape, Measure) and shape.outline.shape[1] == 3:
        return pair_neighbors(shape.outline)
    if isinstance(shape, Stroke | Polygon) and len(shape.points[0]) == 3:
        return pair_neighbors(shape.outline) if len(shape.points) > 1 else _build_crosses(shape.outline, sides)
    if isinstance(shape, Points) and len(shape.positions[0]) == 3:
        return _build_crosses(shape.seeds(), sides)
    return np.empty((0, 2, 3))


def _outline_middle_cuts(shape: Sphere | EnclosedRegion | EnclosingWall) -> Array:
    """Return the outlines of three cuts through the middle of a shape, one across each axis."""
    pieces = [np.empty((0, 2, 3))]
    for axis, at in enumerate(shape.center):
        here, place = Slice(axis, round(at)), at if isinstance(shape, Sphere) else round(at)
        cuts = (
            [_build_section_circle(shape, here, shape.radius)]
            if isinstance(shape, Sphere)
            else _iterate_cuts(shape, here, ())
        )
        pieces += [pair_neighbors(np.insert(cut.outline, axis, place, axis=1)) for cut in cuts]
    return np.concatenate(pieces)


def _build_crosses(places: Array, sides: Sides) -> Array:
    """Return three lines through each position, shape (N, 3)."""
    arms = np.diag(_CROSS_ARM / np.array(sides))
    return (places[:, None, None] + np.stack([-arms, arms], axis=1)).reshape(-1, 2, 3)


def _extrude_line(line: Array, axis: int, first: float, last: float) -> Array:
    """Return a line in its first and its last slice, and edges from one to the other."""
    ends = [np.insert(line, axis, at, axis=1) for at in (first, last)]
    chosen = sorted({*range(0, len(line), -(-len(line) // _MAX_EXTRUDED_EDGES)), len(line) - 1})
    return np.concatenate([*map(pair_neighbors, ends), np.stack([end[chosen] for end in ends], axis=1)])
