"""What a person has chosen to see in space, and the view that comes of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from app.model.display.space.picture import Colors
from app.model.display.space.projection import Shaded
from app.model.display.space.slices import ShownSlice
from app.model.display.space.triangles import Cut, Mesh
from app.model.display.space.view_in_space import ColoredMesh, Particles, ViewInSpace, Wires
from app.model.volume.slices import Slices, directions_of, first_seen
from cpm_core.image.image import Image

GRAY: Colors = np.repeat(np.arange(256, dtype=np.uint8)[:, np.newaxis], 3, axis=1)
"""Shades as they are."""


@dataclass(frozen=True, slots=True)
class ShownParts:
    """The parts that are shown; `cut_axis` is None for no cut, `cut_at` from 0 to 1 along that axis."""

    particles: bool = True
    surface: bool = True
    objects: bool = True
    slices: bool = False
    projection: bool = False
    box: bool = True
    opacity: float = 1.0
    cut_axis: int | None = None
    cut_at: float = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class Contents:
    """All that could be shown of a volume.

    Attributes
    ----------
    image : Image
        The volume.
    shaded : Shaded
        Its shades.
    slices : Slices
        The slices that are shown beside the view.
    particles, mesh
        What a run has found, None before it has.
    wires : Wires or None
        What is drawn.
    table : ndarray of uint8, shape (256, 3)
        Color of each shade.
    objects : tuple of ColoredMesh
        Objects that have been selected, and those that are offered.
    truth : tuple of ColoredMesh
        The ground truth, where one is known and shown.
    """

    image: Image
    shaded: Shaded
    slices: Slices
    particles: Particles | None = None
    mesh: Mesh | None = None
    wires: Wires | None = None
    table: Colors = field(default_factory=lambda: GRAY)
    objects: tuple[ColoredMesh, ...] = ()
    truth: tuple[ColoredMesh, ...] = ()

    def view(self, shown: ShownParts) -> ViewInSpace:
        """The view of the parts that are shown."""
        return ViewInSpace(
            self.image.shape,
            self.image.spacing,
            self.particles if shown.particles else None,
            self.mesh if shown.surface else None,
            tuple(self._slice(axis) for axis in range(3)) if shown.slices else (),
            self.shaded if shown.projection else None,
            self.table,
            shown.opacity,
            self._cut(shown),
            shown.box,
            self.wires,
            (*(self.objects if shown.objects else ()), *self.truth),
            directions_of(self.image),
            first_seen(self.image),
        )

    def _slice(self, axis: int) -> ShownSlice:
        return ShownSlice(self.slices.across(axis), self.shaded, self.table)

    def _cut(self, shown: ShownParts) -> Cut | None:
        """The side of the first voxels is taken away, which is the one that is seen first."""
        axis = shown.cut_axis
        if axis is None:
            return None
        normal = tuple(-1.0 if one == axis else 0.0 for one in range(3))
        length = (self.image.shape[axis] - 1) * self.image.spacing[axis]
        return Cut((normal[0], normal[1], normal[2]), -shown.cut_at * length)
