"""A picture of the view in space: color and depth of each pixel, and drawing of lines and balls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image

from cpm_core.numerics import compiled, run_in_parallel
from cpm_core.numerics.types import Pixels, Single, record

EMPTY_DEPTH = np.float32(3e38)
"""Depth of pixels that show nothing."""

_MIN_BAND_ROWS = 32
"""Smallest number of rows that a thread fills."""


@record
class Picture:
    """Colors, shape (H, W, 3), and depths behind the picture's plane [px], shape (H, W)."""

    colors: Pixels
    depths: Single

    @staticmethod
    def blank(size: tuple[int, int], color: tuple[int, int, int]) -> Picture:
        """Return a picture of one color, with nothing in it."""
        colors = np.empty((*size, 3), np.uint8)
        colors[:] = color
        return Picture(colors, np.full(size, EMPTY_DEPTH, np.float32))

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, cols = self.depths.shape
        return rows, cols

    def copy(self) -> Picture:
        """Return a copy to draw in."""
        return Picture(self.colors.copy(), self.depths.copy())

    def overlay_picture(self, other: Picture, opacity: float) -> None:
        """Blend another picture of the same size over this one, where what it shows is nearer."""
        own = Image.fromarray(self.colors)
        mixed = Image.blend(own, Image.fromarray(other.colors), opacity)
        self.colors[:] = np.asarray(Image.composite(mixed, own, Image.fromarray(other.depths < self.depths)))

    def draw_in_bands(self, kernel: Callable[..., None], *drawn: Any) -> None:
        """Call a compiled function with `drawn` for bands of rows, on several threads."""

        def draw_band(begin: int, end: int) -> None:
            kernel(*drawn, self.colors, self.depths, begin, end)

        run_in_parallel(draw_band, self.size[0], _MIN_BAND_ROWS)


def draw_lines(picture: Picture, seen: Single, colors: Pixels) -> None:
    """Draw lines one pixel wide between points 0 and 1, 2 and 3, ..., of `seen` (N, 3), in `colors` (N / 2, 3)."""
    _draw_lines(seen, colors, picture.colors, picture.depths)


@compiled
def _draw_lines(seen: Single, colors: Pixels, shown: Pixels, depths: Single) -> None:
    height, width = depths.shape
    for i in range(seen.shape[0] // 2):
        start = seen[2 * i].astype(np.float64)
        way = seen[2 * i + 1] - start
        steps = max(abs(way[0]), abs(way[1]), 1e-6)
        begin, end = clip_line(start[0], way[0], width, 0.0, 1.0)
        begin, end = clip_line(start[1], way[1], height, begin, end)
        for step in range(int(np.ceil(begin * steps)), int(np.floor(end * steps)) + 1):
            at = start + step / steps * way
            col, row, depth = int(np.rint(at[0])), int(np.rint(at[1])), np.float32(at[2])
            if 0 <= col < width and 0 <= row < height and depth < depths[row, col]:
                depths[row, col] = depth
                shown[row, col] = colors[i]


@compiled
def clip_line(start: float, way: float, size: int, begin: float, end: float) -> tuple[float, float]:
    """Clip a line to the extent of a picture or a volume along one axis.

    Parameters
    ----------
    start, way : float
        The line is ``start + t way`` along the axis.
    size : int
        Number of pixels or voxels; the extent is from -0.5 to ``size - 0.5``.
    begin, end : float
        Range of t so far.

    Returns
    -------
    tuple of float
        Range of t that lies in the extent too; empty, with its begin above its end, where there is none.
    """
    if abs(way) < 1e-9:
        return (begin, end) if -0.5 <= start < size - 0.5 else (1.0, 0.0)
    one, other = (-0.5 - start) / way, (size - 0.5 - start) / way
    return max(begin, min(one, other)), min(end, max(one, other))


def draw_balls(picture: Picture, seen: Single, colors: Pixels, radius: float) -> None:
    """Draw balls of a radius [px] at points of a picture, `seen` (N, 3), in `colors` (N, 3)."""
    picture.draw_in_bands(_draw_balls, seen, colors, np.float32(radius))


@compiled
def _draw_balls(
    seen: Single,
    colors: Pixels,
    radius: np.float32,
    shown: Pixels,
    depths: Single,
    begin: int,
    end: int,
) -> None:
    width, square = depths.shape[1], radius * radius
    one = np.float32(1.0)
    for i in range(seen.shape[0]):
        x, y, z = seen[i, 0], seen[i, 1], seen[i, 2]
        if not (-radius < x < width + radius and begin - radius < y < end + radius):
            continue
        for row in range(max(int(np.ceil(y - radius)), begin), min(int(np.floor(y + radius)) + 1, end)):
            for col in range(max(int(np.ceil(x - radius)), 0), min(int(np.floor(x + radius)) + 1, width)):
                off = (row - y) ** 2 + (col - x) ** 2
                if off <= square:
                    height = np.sqrt(square - off)
                    if z - height < depths[row, col]:
                        depths[row, col] = z - height
                        shade = np.float32(0.5) + np.float32(0.5) * height / max(radius, one)
                        for channel in range(3):
                            shown[row, col, channel] = np.uint8(shade * colors[i, channel])
