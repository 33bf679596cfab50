"""A picture of the view in space: a color for each pixel, and how far away is what it shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share

Colors = NDArray[np.uint8]
"""Red, green and blue, one byte each, in the last axis."""

FAR = np.float32(3e38)
"""Distance of what shows nothing."""

ROWS = 32
"""Rows that one thread fills at the least."""


@dataclass(frozen=True, eq=False, slots=True)
class Picture:
    """Colors, shape (H, W, 3), and distances behind the picture's plane [px], shape (H, W)."""

    colors: Colors
    depths: NDArray[np.float32]

    @staticmethod
    def blank(size: tuple[int, int], color: tuple[int, int, int]) -> Picture:
        """A picture of one color, with nothing in it."""
        colors = np.empty((*size, 3), np.uint8)
        colors[:] = color
        return Picture(colors, np.full(size, FAR, np.float32))

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, cols = self.depths.shape
        return rows, cols

    def covered_by(self, other: Picture, opacity: float) -> None:
        """Lay another picture of the same size over this one, with this opacity, where what it shows is nearer."""

        def some(begin: int, end: int) -> None:
            _cover(self.colors, self.depths, other.colors, other.depths, np.float32(opacity), begin, end)

        share(some, self.size[0], ROWS)


@compiled
def _cover(
    colors: Colors,
    depths: NDArray[np.float32],
    over: Colors,
    near: NDArray[np.float32],
    opacity: np.float32,
    begin: int,
    end: int,
) -> None:
    rest = np.float32(1.0) - opacity
    for row in range(begin, end):
        for col in range(depths.shape[1]):
            if near[row, col] < depths[row, col]:
                for channel in range(3):
                    mixed = rest * colors[row, col, channel] + opacity * over[row, col, channel]
                    colors[row, col, channel] = np.uint8(mixed + np.float32(0.5))
