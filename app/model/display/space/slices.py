"""Slices in space: three of them show where one is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from app.model.display.display_image import apply_window
from app.model.display.space.camera import Camera
from app.model.display.space.picture import ROWS, Colors, Picture
from app.model.display.space.projection import Shaded
from app.model.volume.slices import Slice
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array


@dataclass(frozen=True, eq=False)
class ShownSlice:
    """A slice of a volume, with the colors of its shades; they are made when it is drawn."""

    place: Slice
    volume: Shaded
    table: Colors

    @cached_property
    def colors(self) -> Colors:
        """Its colors (H, W, 3)."""
        return self.table[apply_window(self.place.of(self.volume.values), self.volume.window)]


def draw_slice(picture: Picture, place: Slice, colors: Colors, camera: Camera, spacing: tuple[float, ...]) -> None:
    """Draw a slice of a volume whose voxels have this size; nothing where it is seen from the side."""
    across = place.axis
    if abs(camera.axes[2, across]) < 1e-6:
        return
    down, right = (axis for axis in range(3) if axis != across)
    corner = camera.corner(picture.size)
    steps = camera.axes / camera.scale
    origin = np.array([place.index * spacing[across] - corner[across], corner[down], corner[right]])
    sides = np.array([[steps[k, axis] for axis in (across, down, right)] for k in range(3)])
    sizes = np.array([spacing[down], spacing[right]])

    def some(begin: int, end: int) -> None:
        _draw(colors, origin, sides, sizes, picture.colors, picture.depths, begin, end)

    share(some, picture.size[0], ROWS)


@compiled
def _draw(
    colors: Colors,
    origin: Array,
    sides: Array,
    sizes: Array,
    shown: Colors,
    depths: NDArray[np.float32],
    begin: int,
    end: int,
) -> None:
    """Each pixel's line of sight meets the plane once."""
    rows, cols = colors.shape[:2]
    for row in range(begin, end):
        for col in range(depths.shape[1]):
            depth = (origin[0] - col * sides[0, 0] - row * sides[1, 0]) / sides[2, 0]
            if depth >= depths[row, col]:
                continue
            at_row = (origin[1] + col * sides[0, 1] + row * sides[1, 1] + depth * sides[2, 1]) / sizes[0]
            at_col = (origin[2] + col * sides[0, 2] + row * sides[1, 2] + depth * sides[2, 2]) / sizes[1]
            if -0.5 <= at_row < rows - 0.5 and -0.5 <= at_col < cols - 0.5:
                depths[row, col] = np.float32(depth)
                i, j = int(at_row + 0.5), int(at_col + 0.5)
                for channel in range(3):
                    shown[row, col, channel] = colors[i, j, channel]
