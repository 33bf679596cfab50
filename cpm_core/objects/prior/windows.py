"""Windows: the squares of an image that the network looks at, each brought to the same number of pixels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Index, Mask, Single

SIDE = 96
"""Pixels along each side of what the network looks at."""

LUMINANCE = np.array([0.299, 0.587, 0.114], np.float32)
"""Share of red, green and blue in the brightness that the network sees (ITU-R BT.601)."""

DARKEST, BRIGHTEST = 0.1, 99.9
"""Percentiles of the image that become 0 and 255."""

LEAST_DEVIATION = 8.0
"""What is added to the standard deviation of gray levels in a window, so that noise is not made an object."""

_MOST_COLOR = 0.5
"""Share of the standard deviation of differences of colors that counts where that of the brightness is smaller."""

SAMPLES = 100_000
"""About so many pixels by which the gray levels of an image are measured."""


@dataclass(frozen=True, eq=False)
class Window:
    """A square of an image.

    Attributes
    ----------
    middle : ndarray, shape (2,)
        Its middle (row, col) [px].
    side : float
        Length of its sides [px]; it may extend beyond the image.
    """

    middle: Array
    side: float

    @property
    def scale(self) -> float:
        """Pixels of the image for one of the window."""
        return self.side / SIDE

    @property
    def lines(self) -> tuple[Array, Array]:
        """Rows and columns of the image at its pixels, each of shape (SIDE,) [px]."""
        steps = (np.arange(SIDE) - SIDE / 2) * self.scale
        return self.middle[0] + steps, self.middle[1] + steps

    def holding(self, pixels: Index) -> Mask:
        """Its pixels that hold some of the image, shape (N, 2); shape (SIDE, SIDE)."""
        on = np.zeros((SIDE, SIDE), np.bool_)
        place = np.rint((pixels - self.middle) / self.scale + SIDE / 2).astype(np.int64)
        on[tuple(place[((place >= 0) & (place < SIDE)).all(axis=1)].T)] = True
        return on

    def of(self, values: Mask | Single) -> Single:
        """A map of the image, shape (H, W), in the window; zeros beyond the image."""
        return _sampled_within(values, *self.lines)

    def of_window(self, other: Window, seen: Single) -> Single:
        """The map of another window in this one; zeros beyond."""
        return _sampled_within(
            seen, *((line - m) / other.scale + SIDE / 2 for line, m in zip(self.lines, other.middle, strict=True))
        )

    def back(self, seen: Single, shape: tuple[int, ...]) -> tuple[tuple[slice, slice], Single]:
        """Rows and columns of an image of this shape that the window holds, and its map, shape (SIDE, SIDE), there."""
        lines = [np.arange(n) for n in shape]
        lines = [line[(line >= of[0]) & (line <= of[-1])] for line, of in zip(lines, self.lines, strict=True)]
        place = [(line - m) / self.scale + SIDE / 2 for line, m in zip(lines, self.middle, strict=True)]
        rows, cols = (slice(int(line[0]), int(line[-1]) + 1) if len(line) else slice(0, 0) for line in lines)
        return (rows, cols), sampled(seen[..., None], *place)[..., 0]


@dataclass(frozen=True, eq=False)
class Views:
    """An image as the network sees it.

    Attributes
    ----------
    values : ndarray, shape (H, W) or (H, W, 3)
        Gray levels, or colors.
    """

    values: NDArray[Any]

    def through(self, window: Window) -> Single:
        """Brightness and two differences of colors in a window, shape (3, SIDE, SIDE), of about unit variance."""
        coarsest = max(int(np.log2(min(self.values.shape[:2]) / SIDE)), 0)
        number = int(np.clip(np.log2(max(window.scale, 1.0)), 0, coarsest))
        level, coarseness = self._level(number), window.scale / 2**number
        rows, cols = ((line + 0.5) / 2**number - 0.5 for line in window.lines)
        top, left = (max(int(line[0]) - 3, 0) for line in (rows, cols))
        part = level[top : max(int(rows[-1]) + 5, top + 1), left : max(int(cols[-1]) + 5, left + 1)]
        if not part.size:
            return np.zeros((3, SIDE, SIDE), np.float32)
        if number == 0:
            part = self._normalized(part)
        if coarseness > 1.6:
            part = scipy.ndimage.gaussian_filter(part, (0.4 * coarseness, 0.4 * coarseness, 0), mode="nearest")
        seen = sampled(part, rows - top, cols - left)
        red, green, blue = np.moveaxis(np.broadcast_to(seen, (*seen.shape[:2], 3)), -1, 0)
        gray = np.asarray(np.tensordot(LUMINANCE, [red, green, blue], 1))
        colors = red - green, 0.5 * (red + green) - blue
        deviation = max(gray.std() + LEAST_DEVIATION, *(_MOST_COLOR * color.std() for color in colors))
        return np.stack([gray - gray.mean(), *colors]) / deviation

    def _level(self, number: int) -> NDArray[Any]:
        """The image for 0, shape (H, W, C); else normalized means of 2 x 2 pixels of the level before."""
        if number == 0:
            return self.values.reshape(*self.values.shape[:2], -1)
        if number not in self._known:
            finer = self._level(number - 1)
            height, width = finer.shape[0] // 2 * 2, finer.shape[1] // 2 * 2
            rows = np.add(finer[0:height:2], finer[1:height:2], dtype=np.float64 if number == 1 else np.float32)
            mean = 0.25 * (rows[:, 0:width:2] + rows[:, 1:width:2])
            self._known[number] = self._normalized(mean) if number == 1 else mean
        return self._known[number]

    def _normalized(self, values: NDArray[Any]) -> Single:
        """Gray levels from 0 to 255."""
        low, high = self._range
        return np.asarray((values - low) * (255.0 / max(high - low, 1e-300)), np.float32)

    @cached_property
    def _range(self) -> tuple[float, float]:
        """Gray levels that become 0 and 255."""
        step = max(int(np.sqrt(self.values.shape[0] * self.values.shape[1] / SAMPLES)), 1)
        low, high = np.percentile(self.values[::step, ::step], [DARKEST, BRIGHTEST]).tolist()
        return low, high

    @cached_property
    def _known(self) -> dict[int, Single]:
        """Levels that have been asked for."""
        return {}


def _sampled_within(values: Mask | Single, rows: Array, cols: Array) -> Single:
    """Samples of (H, W) at the crossings of rows and columns, bilinear; zeros beyond the border."""
    seen = sampled(values[..., None], rows, cols)[..., 0]
    for axis, line in enumerate((rows, cols)):
        within = (line >= -0.5) & (line <= values.shape[axis] - 0.5)
        seen = seen * np.expand_dims(within, 1 - axis)
    return seen


def sampled(values: Mask | Single, rows: Array, cols: Array) -> Single:
    """Samples of (H, W, C) at the crossings of rows and columns, bilinear; beyond the border as at the border."""
    seen = np.asarray(values)
    for axis, line in enumerate((rows, cols)):
        last = values.shape[axis] - 1
        inner = np.clip(line, 0, last)
        low = np.minimum(inner.astype(np.int64), max(last - 1, 0))
        part = (inner - low).astype(np.float32).reshape(-1, *[1] * (2 - axis))
        seen = seen.take(low, axis) * (1 - part) + seen.take(np.minimum(low + 1, last), axis) * part
    return np.asarray(seen)
