"""What a person has chosen to see in space, and the view that comes of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.model.display.space.picture import Colors
from app.model.display.space.projection import Shaded
from app.model.display.space.slices import Slice
from app.model.display.space.triangles import Cut, Mesh
from app.model.display.space.view_in_space import Particles, ViewInSpace


@dataclass(frozen=True, slots=True)
class ShownParts:
    """The parts that are shown; `cut_axis` is None for no cut, `cut_at` from 0 to 1 along that axis."""

    particles: bool = True
    surface: bool = True
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
    shaded : Shaded
        The volume with one byte a voxel.
    spacing : tuple of float
        Size of a voxel along each axis, in `unit`.
    unit : str or None
        Unit of length, None when it is not known.
    table : ndarray of uint8, shape (256, 3)
        Color of each byte.
    particles, mesh
        What a run has found, None before it has.
    crosshair : tuple of int
        Voxel in which the three slices meet.
    """

    shaded: Shaded
    spacing: tuple[float, ...]
    unit: str | None
    table: Colors
    particles: Particles | None = None
    mesh: Mesh | None = None
    crosshair: tuple[int, int, int] = (0, 0, 0)

    def view(self, shown: ShownParts) -> ViewInSpace:
        """The view of the parts that are shown."""
        voxels = self.shaded.voxels
        slices = tuple(
            Slice(axis, index, self.table[np.take(voxels, index, axis)]) for axis, index in enumerate(self.crosshair)
        )
        return ViewInSpace(
            voxels.shape,
            self.spacing,
            self.particles if shown.particles else None,
            self.mesh if shown.surface else None,
            slices if shown.slices else (),
            self.shaded if shown.projection else None,
            self.table,
            shown.opacity,
            self._cut(shown),
            shown.box,
        )

    def _cut(self, shown: ShownParts) -> Cut | None:
        """The side of the first voxels is taken away, which is the one that is seen first."""
        axis = shown.cut_axis
        if axis is None:
            return None
        normal = tuple(-1.0 if one == axis else 0.0 for one in range(3))
        length = (self.shaded.voxels.shape[axis] - 1) * self.spacing[axis]
        return Cut((normal[0], normal[1], normal[2]), -shown.cut_at * length)
