"""Content of the view in space, as one frozen value, and its picture."""

from __future__ import annotations

from dataclasses import field, replace
from itertools import product

import numpy as np

from cpm_app.model.display.display_image import apply_window
from cpm_app.model.space.camera import Camera
from cpm_app.model.space.picture import Picture, draw_balls, draw_lines
from cpm_app.model.space.triangles import CutPlane, SurfaceMesh, draw_mesh
from cpm_app.model.space.voxels import ShadedVolume, draw_projection, draw_slice
from cpm_app.model.volume.slices import Slice, Slices
from cpm_core import Image
from cpm_core.numerics import Array
from cpm_core.numerics.types import Pixels, frozen, record

RgbColor = tuple[int, int, int]
"""Red, green and blue, from 0 to 255."""

AXIS_COLORS = ((70, 120, 255), (60, 180, 75), (230, 70, 60))
"""Colors of the axes: plane, row, column."""

GRAY_TABLE = np.repeat(np.arange(256, dtype=np.uint8)[:, np.newaxis], 3, axis=1)
"""Color table that shows shades as they are."""

_OBJECT_OFFSET_VOXELS = 2.0
"""Distance that objects are drawn nearer than they are [smallest sides of a voxel]."""

_OBJECT_OFFSET_RADII = 1.5
"""Smallest distance that objects are drawn nearer than they are [radii of a particle]."""


BACKGROUND_COLOR: RgbColor = (0x14, 0x16, 0x1A)
"""Color behind everything: that of the canvas."""

_EDGE_COLOR: RgbColor = (120, 126, 136)
"""Color of the edges of the box that are no axes."""

_OUTSIDE_COLOR: RgbColor = (214, 164, 120)
"""Color of the surface of a run from outside."""

_INSIDE_COLOR: RgbColor = (120, 150, 200)
"""Color of the surface of a run from inside, where it is cut open."""

_PARTICLE_RADIUS = 2.0
"""Radius of a particle [px of the screen]."""

_MIN_PARTICLE_RADIUS = 0.6
"""Smallest radius of a particle in a coarse picture [px of the picture]."""


@frozen
class ShownParts:
    """Visible parts; `cut_axis` is None for no cut, `cut_at` from 0 to 1 along that axis."""

    particles: bool = True
    surface: bool = True
    objects: bool = True
    slices: bool = False
    projection: bool = False
    box: bool = True
    opacity: float = 1.0
    cut_axis: int | None = None
    cut_at: float = 0.5


@record
class ShownParticles:
    """Positions (N, 3) [voxels] and colors (N, 3); `size` is a factor for their radius."""

    positions: Array
    colors: Pixels
    size: float = 1.0


@record
class Wires:
    """Ends of straight lines, shape (N, 2, 3) [voxels], and their colors, shape (N, 3)."""

    ends: Array
    colors: Pixels


@record
class ColoredMesh:
    """A surface in colors of its own, outside and where it is cut open; `opacity` is from 0 to 1."""

    mesh: SurfaceMesh
    color: RgbColor
    inside: RgbColor
    opacity: float = 1.0


@record
class Overlay:
    """A volume over another: the color of each shade, times its opacity, and the opacity, (256, 4); light, (256, 3)."""

    shaded: ShadedVolume
    table: Pixels

    def blend(self, colors: Pixels, shades: Pixels) -> None:
        """Blend shades, shape (H, W), into colors, shape (H, W, 3), in place; light is added up to white."""
        over = self.table[shades]
        clear = 1.0 - over[..., 3:].sum(axis=-1, keepdims=True, dtype=np.float32) / 255.0
        colors[:] = np.rint(np.minimum(over[..., :3] + clear * colors, 255.0))


@record
class ViewInSpace:
    """Everything that could be seen of a volume, and which of it is shown.

    Attributes
    ----------
    image : Image
        The volume.
    shaded : ShadedVolume
        Its shades.
    slices : Slices
        The slices that are shown next to the view.
    particles, mesh
        Particles and surface of a run, None before there are any.
    wires : Wires or None
        The shapes that the user has drawn.
    table : ndarray of uint8, shape (256, 3)
        Color of each shade.
    overlays : tuple of Overlay
        Other channels and the second image; slices and brightest voxels show them over those of the volume.
    objects : tuple of ColoredMesh
        Accepted objects, and proposals.
    truth : tuple of ColoredMesh
        The ground truth, where one is known and shown.
    shown : ShownParts
        Which of this is shown.
    """

    image: Image
    shaded: ShadedVolume
    slices: Slices
    particles: ShownParticles | None = None
    mesh: SurfaceMesh | None = None
    wires: Wires | None = None
    table: Pixels = field(default_factory=lambda: GRAY_TABLE)
    overlays: tuple[Overlay, ...] = ()
    objects: tuple[ColoredMesh, ...] = ()
    truth: tuple[ColoredMesh, ...] = ()
    shown: ShownParts = field(default_factory=ShownParts)

    @property
    def lengths(self) -> tuple[float, ...]:
        """Sides of the volume between the centers of its outermost voxels, in units of length."""
        return tuple((count - 1) * size for count, size in zip(self.image.shape, self.image.spacing, strict=True))

    @property
    def cut(self) -> CutPlane | None:
        """Plane before which surface and particles are hidden: the side of the first voxels is removed."""
        axis = self.shown.cut_axis
        return None if axis is None else CutPlane(axis, self.shown.cut_at * self.lengths[axis])

    def render_picture(self, camera: Camera, size: tuple[int, int], coarseness: int = 1) -> Picture:
        """Draw everything that is shown in a picture of `size` rows and columns.

        `coarseness` is the size of a pixel of the picture [px of the screen].
        """
        picture, shown, spacing = Picture.blank(size, BACKGROUND_COLOR), self.shown, self.image.spacing
        if shown.projection:
            draw_projection(picture, self.shaded, camera, spacing, self.table)
            for overlay in self.overlays:
                brightest = Picture.blank(size, (0, 0, 0))
                draw_projection(brightest, overlay.shaded, camera, spacing, GRAY_TABLE)
                overlay.blend(picture.colors, brightest.colors[..., 0])
        if shown.slices:
            for place in map(self.slices.slice_across, range(3)):
                colors = self.table[_shade_slice(place, self.shaded)]
                for overlay in self.overlays:
                    overlay.blend(colors, _shade_slice(place, overlay.shaded))
                draw_slice(picture, place, colors, camera, spacing)
        if shown.box:
            self._draw_box(picture, camera)
        if self.wires is not None:
            places = self.wires.ends.reshape(-1, 3) * np.array(spacing)
            draw_lines(picture, camera.project(places, size), self.wires.colors)
        self.draw_particles(picture, self.particles, camera, coarseness)
        self._draw_surfaces(picture, camera, coarseness)
        return picture

    @property
    def is_translucent(self) -> bool:
        """Whether anything is seen through a surface."""
        return any(each.opacity < 1.0 for each in self._shown_surfaces)

    def draw_particles(
        self, picture: Picture, particles: ShownParticles | None, camera: Camera, coarseness: int = 1
    ) -> None:
        """Draw particles into a picture, if they are shown; see `render_picture`."""
        if particles is not None and self.shown.particles:
            places, colors, cut = particles.positions * np.array(self.image.spacing), particles.colors, self.cut
            if cut is not None:
                kept = cut.distance_before(places) <= 0.0
                places, colors = places[kept], colors[kept]
            radius = particles.size * _find_particle_radius(coarseness)
            draw_balls(picture, camera.project(places, picture.size), colors, radius)

    @property
    def _shown_surfaces(self) -> list[ColoredMesh]:
        """The surface of the run, and then the objects and the truth, with the opacity that they are seen with."""
        found = [*(self.objects if self.shown.objects else ()), *self.truth]
        if self.mesh is not None and self.shown.surface:
            found.insert(0, ColoredMesh(self.mesh, _OUTSIDE_COLOR, _INSIDE_COLOR))
        return [replace(each, opacity=each.opacity * self.shown.opacity) for each in found]

    def _draw_surfaces(self, picture: Picture, camera: Camera, coarseness: int) -> None:
        """Draw the opaque surfaces, and over them the others, from the farthest front to the nearest."""
        # a little nearer than the surface of the run, whose triangles they share, and than its particles
        radius = _find_particle_radius(coarseness) / camera.scale
        by = max(_OBJECT_OFFSET_VOXELS * min(self.image.spacing), _OBJECT_OFFSET_RADII * radius)
        nearer = replace(camera, center=camera.center + by * camera.axes[2])
        layers: list[tuple[float, int, Camera, ColoredMesh]] = []
        for each in self._shown_surfaces:
            seen_by = camera if each.mesh is self.mesh else nearer
            if each.opacity >= 1.0:
                draw_mesh(picture, each.mesh, seen_by, each.color, each.inside, self.cut)
            elif each.opacity > 0.0:
                front = camera.project(each.mesh.positions, picture.size)[:, 2].min(initial=np.inf)
                layers.append((-float(front), len(layers), seen_by, each))
        for *_, seen_by, each in sorted(layers):
            layer = Picture.blank(picture.size, BACKGROUND_COLOR)
            draw_mesh(layer, each.mesh, seen_by, each.color, each.inside, self.cut)
            picture.overlay_picture(layer, each.opacity)

    def _draw_box(self, picture: Picture, camera: Camera) -> None:
        """Draw twelve edges; the three at the first voxel are the axes, in their own colors."""
        corners = np.array(list(product((0.0, 1.0), repeat=3)))
        first = np.stack([corners[corners[:, axis] == 0.0] for axis in range(3)])
        ends = np.stack([first, first + np.eye(3)[:, None]], axis=2).reshape(-1, 3)
        colors = np.tile(_EDGE_COLOR, (12, 1))
        colors[::4] = AXIS_COLORS
        draw_lines(picture, camera.project(ends * self.lengths, picture.size), colors.astype(np.uint8))


def _shade_slice(place: Slice, volume: ShadedVolume) -> Pixels:
    return apply_window(place.slice_array(volume.values), volume.window)


def _find_particle_radius(coarseness: int) -> float:
    """Return the radius of a particle in a picture [px of the picture]."""
    return max(_PARTICLE_RADIUS / coarseness, _MIN_PARTICLE_RADIUS)
