"""Voxels of a volume in space: three slices, and the brightest voxel on each line of sight."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from PIL import Image

from cpm_app.model.display.display_image import IntensityWindow, apply_window
from cpm_app.model.space.camera import Camera
from cpm_app.model.space.picture import Picture, clip_line
from cpm_app.model.volume.slices import Slice
from cpm_core.numerics import Array, compiled
from cpm_core.numerics.types import Numbers, Pixels, Sides, Single, record

_MAXIMA_BLOCK_SIDE = 8
"""Side of the blocks whose maxima are stored [voxels]: blocks that cannot raise the maximum are skipped."""


@record
class ShadedVolume:
    """A volume with one byte a voxel, computed from its gray values on first use, since that takes a while."""

    values: Numbers
    window: IntensityWindow

    @cached_property
    def voxels(self) -> Pixels:
        """Shades of the window, in the shape of the volume."""
        return apply_window(self.values, self.window)

    @cached_property
    def maxima(self) -> Pixels:
        """The brightest voxel of each block."""
        found = self.voxels
        for axis in range(3):
            found = np.maximum.reduceat(found, np.arange(0, found.shape[axis], _MAXIMA_BLOCK_SIDE), axis=axis)
        return np.ascontiguousarray(found)


def draw_projection(picture: Picture, volume: ShadedVolume, camera: Camera, spacing: Sides, table: Pixels) -> None:
    """Draw the brightest voxels behind everything else in `table` (256, 3) colors; black ones are left out."""
    sizes = np.asarray(spacing, float)
    corner = camera.first_pixel_position(picture.size) / sizes
    right, down = (camera.axes[k] / camera.scale / sizes for k in range(2))
    away = camera.axes[2] / sizes
    away = away / np.abs(away).max()
    picture.draw_in_bands(_draw_projection, volume.voxels, volume.maxima, corner, right, down, away, table)


@compiled
def _draw_projection(
    voxels: Pixels,
    maxima: Pixels,
    corner: Array,
    right: Array,
    down: Array,
    away: Array,
    table: Pixels,
    shown: Pixels,
    depths: Single,
    begin: int,
    end: int,
) -> None:
    """Step along a line from each pixel, by one voxel along its longest component."""
    for row in range(begin, end):
        for col in range(depths.shape[1]):
            start = (
                corner[0] + col * right[0] + row * down[0],
                corner[1] + col * right[1] + row * down[1],
                corner[2] + col * right[2] + row * down[2],
            )
            near, far = -1e30, 1e30
            for axis in range(3):
                near, far = clip_line(start[axis], away[axis], voxels.shape[axis], near, far)
            z, y, x = start[0] + 0.5, start[1] + 0.5, start[2] + 0.5
            at, found = near + 1e-6, 0
            while at < far:
                i, j, k = int(z + at * away[0]), int(y + at * away[1]), int(x + at * away[2])
                if i >= voxels.shape[0] or j >= voxels.shape[1] or k >= voxels.shape[2]:
                    break
                if maxima[i // _MAXIMA_BLOCK_SIDE, j // _MAXIMA_BLOCK_SIDE, k // _MAXIMA_BLOCK_SIDE] <= found:
                    leave = min(
                        _find_block_exit(z, away[0], i),
                        _find_block_exit(y, away[1], j),
                        _find_block_exit(x, away[2], k),
                    )
                    at = max(leave, at) + 1e-3
                else:
                    found = max(found, voxels[i, j, k])
                    at += 1.0
            if found > 0:
                shown[row, col] = table[found]


@compiled
def _find_block_exit(start: float, away: float, index: int) -> float:
    """Return where a line leaves the block of a voxel along one axis."""
    if abs(away) < 1e-9:
        return 1e30
    block = index // _MAXIMA_BLOCK_SIDE + (1 if away > 0.0 else 0)
    return (block * _MAXIMA_BLOCK_SIDE - start) / away


def draw_slice(picture: Picture, cut: Slice, colors: Pixels, camera: Camera, spacing: Sides) -> None:
    """Draw a slice in `colors` (H, W, 3), in voxels of this size; nothing where it is seen edge-on."""
    across = cut.axis
    if abs(camera.axes[2, across]) < 1e-6:
        return
    down, right = cut.axes
    onto = camera.axes * camera.scale  # column, row and depth in the picture, for a unit along each axis
    origin = onto[:, across] * cut.index * spacing[across] - onto @ camera.first_pixel_position(picture.size)
    voxels = np.stack([onto[:, down] * spacing[down], onto[:, right] * spacing[right], origin], axis=1)
    back = np.linalg.inv(np.vstack([voxels[1::-1], (0.0, 0.0, 1.0)]))  # from row and column of the picture to the slice
    height, width = picture.size
    # Pillow counts columns before rows, from the corner of the first pixel
    onward = back[1::-1, 1::-1]
    places = np.column_stack([onward, back[1::-1, 2] + 0.5 - 0.5 * onward.sum(axis=1)])
    whole = Image.fromarray(np.ascontiguousarray(colors)).convert("RGBA")
    seen = np.asarray(whole.transform((width, height), Image.Transform.AFFINE, places.ravel().tolist()))
    by_row, by_col, first = voxels[2] @ back
    depths = (by_row * np.arange(height)[:, None] + by_col * np.arange(width) + first).astype(np.float32)
    shown = (seen[..., 3] > 0) & (depths < picture.depths)
    picture.colors[shown], picture.depths[shown] = seen[shown, :3], depths[shown]
