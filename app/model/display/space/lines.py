"""Lines in space: the edges of the volume and its axes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.model.display.space.camera import Seen
from app.model.display.space.picture import Colors, Picture
from cpm_core.numerics.jit import compiled


def draw_lines(picture: Picture, seen: Seen, colors: Colors) -> None:
    """Draw lines one pixel wide between places 0 and 1, 2 and 3, ..., each in its color, shape (N / 2, 3)."""
    _draw(seen, colors, picture.colors, picture.depths)


@compiled
def _draw(seen: Seen, colors: Colors, shown: Colors, depths: NDArray[np.float32]) -> None:
    height, width = depths.shape
    for i in range(seen.shape[0] // 2):
        x, y, z = np.float64(seen[2 * i, 0]), np.float64(seen[2 * i, 1]), np.float64(seen[2 * i, 2])
        d_x, d_y, d_z = seen[2 * i + 1, 0] - x, seen[2 * i + 1, 1] - y, seen[2 * i + 1, 2] - z
        steps = max(abs(d_x), abs(d_y), 1e-6)
        begin, end = _inside(x, d_x, width, 0.0, 1.0)
        begin, end = _inside(y, d_y, height, begin, end)
        for step in range(int(np.ceil(begin * steps)), int(np.floor(end * steps)) + 1):
            part = step / steps
            col, row = int(np.rint(x + part * d_x)), int(np.rint(y + part * d_y))
            depth = np.float32(z + part * d_z)
            if 0 <= col < width and 0 <= row < height and depth < depths[row, col]:
                depths[row, col] = depth
                for channel in range(3):
                    shown[row, col, channel] = colors[i, channel]


@compiled
def _inside(start: float, way: float, size: int, begin: float, end: float) -> tuple[float, float]:
    """The part of a line that lies in the picture, along one of its sides."""
    if abs(way) < 1e-9:
        return (begin, end) if -0.5 <= start <= size - 0.5 else (1.0, 0.0)
    one, other = (-0.5 - start) / way, (size - 0.5 - start) / way
    return max(begin, min(one, other)), min(end, max(one, other))
