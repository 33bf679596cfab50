"""Particles in space: little balls, each in a color of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.model.display.space.camera import Seen
from app.model.display.space.picture import ROWS, Colors, Picture
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share


def draw_balls(picture: Picture, seen: Seen, colors: Colors, radius: float) -> None:
    """Draw balls of a radius [px] at places in a picture, in their colors (N, 3)."""

    def some(begin: int, end: int) -> None:
        _draw(seen, colors, np.float32(radius), picture.colors, picture.depths, begin, end)

    share(some, picture.size[0], ROWS)


@compiled
def _draw(
    seen: Seen,
    colors: Colors,
    radius: np.float32,
    shown: Colors,
    depths: NDArray[np.float32],
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
