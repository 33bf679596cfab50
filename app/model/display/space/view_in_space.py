"""What the view in space shows, as one frozen value, and its picture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from app.model.display.space.camera import Camera
from app.model.display.space.discs import draw_balls
from app.model.display.space.lines import draw_lines
from app.model.display.space.picture import Colors, Picture
from app.model.display.space.projection import Shaded, draw_projection
from app.model.display.space.slices import ShownSlice, draw_slice
from app.model.display.space.triangles import Cut, Mesh, draw_mesh
from cpm_core.numerics.types import Array

Color = tuple[int, int, int]

AXIS_COLORS: tuple[Color, Color, Color] = ((70, 120, 255), (60, 180, 75), (230, 70, 60))
"""Colors of the axes: plane, row, column."""

_PLANE, _ROW, _COLUMN = np.eye(3)

DIRECTIONS = tuple(map(np.array, ((_COLUMN, _ROW, _PLANE), (_COLUMN, _PLANE, -_ROW), (_ROW, _PLANE, _COLUMN))))
"""How a camera looks at the slices across each axis of a volume that does not tell how it lies."""

_NEARER = 2.0
"""How much nearer objects are drawn than they are [smallest sides of a voxel]."""

_OVER = 1.5
"""The same, at least [radii of a particle]."""


@dataclass(frozen=True, slots=True)
class Look:
    """Colors of what has none of its own, and the radius of a particle [px]."""

    background: Color = (24, 26, 30)
    edges: Color = (120, 126, 136)
    outside: Color = (214, 164, 120)
    inside: Color = (120, 150, 200)
    radius: float = 2.0


@dataclass(frozen=True, eq=False, slots=True)
class Particles:
    """Positions (N, 3) [voxels] and colors (N, 3); `size` is a factor for their radius."""

    positions: Array
    colors: Colors
    size: float = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class Wires:
    """Ends of straight lines, shape (N, 2, 3) [voxels], and their colors, shape (N, 3)."""

    ends: Array
    colors: Colors


@dataclass(frozen=True, eq=False, slots=True)
class ColoredMesh:
    """A surface in a color of its own."""

    mesh: Mesh
    color: Color


@dataclass(frozen=True, eq=False, slots=True)
class ViewInSpace:
    """All that is seen of a volume.

    Attributes
    ----------
    shape : tuple of int
        Planes, rows and columns.
    spacing : tuple of float
        Size of a voxel along each axis, in units of length.
    particles, mesh, slices, projection
        What is shown; None or empty for what is not.
    table : ndarray of uint8, shape (256, 3)
        Colors of the projection.
    opacity : float
        Of the surface and the objects, from 0 to 1.
    cut : Cut or None
        Plane beyond which nothing of surface and particles is shown.
    box : bool
        Whether the edges of the volume and its axes are shown.
    wires : Wires or None
        What is drawn in the volume.
    objects : tuple of ColoredMesh
        Objects that have been selected.
    directions : tuple of ndarray
        How a camera looks at the slices across each axis: to the right, down and away.
    front : int
        The axis along which the volume is seen first.
    """

    shape: tuple[int, ...]
    spacing: tuple[float, ...]
    particles: Particles | None = None
    mesh: Mesh | None = None
    slices: tuple[ShownSlice, ...] = ()
    projection: Shaded | None = None
    table: Colors | None = None
    opacity: float = 1.0
    cut: Cut | None = None
    box: bool = True
    wires: Wires | None = None
    objects: tuple[ColoredMesh, ...] = ()
    directions: tuple[Array, ...] = DIRECTIONS
    front: int = 0

    @property
    def lengths(self) -> tuple[float, ...]:
        """Sides of the volume between the centers of its outermost voxels, in units of length."""
        return tuple((count - 1) * size for count, size in zip(self.shape, self.spacing, strict=True))

    def drawn(self, camera: Camera, size: tuple[int, int], look: Look) -> Picture:
        """Draw it in a picture of so many rows and columns."""
        picture = Picture.blank(size, look.background)
        if self.projection is not None and self.table is not None:
            draw_projection(picture, self.projection, camera, self.spacing, self.table)
        for shown in self.slices:
            draw_slice(picture, shown.place, shown.colors, camera, self.spacing)
        if self.box:
            self._draw_box(picture, camera, look)
        if self.wires is not None:
            places = self.wires.ends.reshape(-1, 3) * np.array(self.spacing)
            draw_lines(picture, camera.seen(places, size), self.wires.colors)
        if self.particles is not None:
            self._draw_particles(picture, self.particles, camera, look)
        if self.opacity > 0.0:
            self._draw_surfaces(picture, camera, look)
        return picture

    def _draw_particles(self, picture: Picture, particles: Particles, camera: Camera, look: Look) -> None:
        places, colors = particles.positions * np.array(self.spacing), particles.colors
        if self.cut is not None:
            kept = self.cut.beyond(places) <= 0.0
            places, colors = places[kept], colors[kept]
        draw_balls(picture, camera.seen(places, picture.size), colors, particles.size * look.radius)

    def _draw_surfaces(self, picture: Picture, camera: Camera, look: Look) -> None:
        """The objects and the surface, all of the same opacity: an object often is the surface."""
        opaque = self.opacity >= 1.0
        nearest = picture if opaque else Picture.blank(picture.size, look.background)
        for each in self.objects:
            # a little nearer than the surface of the run, whose triangles they share, and than its particles
            by = max(_NEARER * min(self.spacing), _OVER * look.radius / camera.scale)
            nearer = replace(camera, center=camera.center + by * camera.axes[2])
            draw_mesh(nearest, each.mesh, nearer, each.color, each.color, self.cut)
        if self.mesh is not None:
            draw_mesh(nearest, self.mesh, camera, look.outside, look.inside, self.cut)
        if not opaque:
            picture.covered_by(nearest, self.opacity)

    def _draw_box(self, picture: Picture, camera: Camera, look: Look) -> None:
        """Twelve edges; the three at the first voxel are the axes, in their own colors."""
        ends, colors = [], []
        for corner in product((0, 1), repeat=3):
            for axis in range(3):
                if not corner[axis]:
                    other = tuple(1 if k == axis else corner[k] for k in range(3))
                    ends += [corner, other]
                    colors.append(look.edges if any(corner) else AXIS_COLORS[axis])
        places = np.array(ends) * np.array(self.lengths)
        draw_lines(picture, camera.seen(places, picture.size), np.array(colors, np.uint8))
