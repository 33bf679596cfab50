"""Display images: an image or an overlay with one byte a pixel and channel, at full size and reduced."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import PIL.Image
import scipy

from cpm_core import Image
from cpm_core.image.gray_levels import sample_values
from cpm_core.numerics import Array
from cpm_core.numerics.grids import run_in_bands
from cpm_core.numerics.types import Extent, Mask, Pixels, frozen, record

_VALUES_PER_BAND = 1 << 16
"""Gray values that are processed at once: few enough for the processor's cache, which makes it several times faster."""

_OVERVIEW_SIDE = 256
"""Longest side of the smallest level [px]."""

_PREVIEW_SIDE = 1024
"""Longest side of the finest level of a preview [px]."""

_GAMMA_TABLE_SIZE = 1 << 12
"""Entries of the table of the gamma curve."""


@frozen
class IntensityWindow:
    """Range of gray values: those up to `low` are black, those from `high` on white.

    `gamma` is the exponent in between; more than 1 darkens it.
    """

    low: float
    high: float
    gamma: float = 1.0


@record
class FileLevel:
    """Shades of a level that is read from a file, or computed, only where it is visible."""

    values: Any
    window: IntensityWindow

    @property
    def shape(self) -> Extent:
        """Rows and columns."""
        shape: Extent = self.values.shape
        return shape

    def __getitem__(self, part: tuple[slice, slice]) -> Pixels:
        """Return the shades of a part, shape (h, w)."""
        return apply_window(self.values[part], self.window)


@record
class DisplayImage:
    """Shades for the canvas at full size and reduced, so that a view draws about as many pixels as it shows.

    Attributes
    ----------
    levels : tuple of ndarray
        The shades, and each time the means of two by two pixels of the level before. A pixel ``(i, j)`` of level k
        covers the pixels from ``(i, j) 2^k`` up to ``(i + 1, j + 1) 2^k``; at the end there may be fewer.
    finest : int
        Level of the first of them: 0, more for a preview, which lacks the finer ones, or less where a file has finer
        ones, of which only the visible part is read.
    size : tuple of int
        Rows and columns of level 0, where that is not the first of them; else empty.
    """

    levels: tuple[Pixels | FileLevel, ...]
    finest: int = 0
    size: Extent = ()

    @staticmethod
    def from_shades(shades: Pixels, halve: Callable[[Pixels], Pixels] | None = None) -> DisplayImage:
        """Reduce shades, shape (H, W) or (H, W, 3), until the longest side is short, by default to their means."""
        levels = [np.ascontiguousarray(shades)]
        while max(levels[-1].shape[:2]) > _OVERVIEW_SIDE:
            levels.append((halve or _halve_shades)(levels[-1]))
        return DisplayImage(tuple(levels))

    @staticmethod
    def from_labels(shades: Pixels) -> DisplayImage:
        """Reduce shades that stand for labels, shape (H, W), by taking every other one, as means would be others."""
        return DisplayImage.from_shades(shades, lambda finer: np.ascontiguousarray(finer[::2, ::2]))

    @staticmethod
    def from_image(image: Image, window: IntensityWindow, channel: str = "luminance") -> DisplayImage:
        """Return the shades of a channel of an image in an intensity window."""
        whole = DisplayImage.from_shades(
            apply_window(image.stored if image.colors is None else image.gray_levels(channel), window)
        )
        finer = tuple(FileLevel(level, window) for level in image.finer)
        return DisplayImage((*finer, *whole.levels), -len(finer), image.shape) if finer else whole

    @staticmethod
    def from_subsample(values: Array, window: IntensityWindow) -> DisplayImage:
        """Return the shades of every n-th gray value along each axis, to show at once until all have been computed.

        `values` are gray values, shape (H, W).
        """
        finest = max(0, math.ceil(math.log2(max(values.shape) / _PREVIEW_SIDE)))
        some = values[:: 2**finest, :: 2**finest]
        return replace(DisplayImage.from_shades(apply_window(some, window)), finest=finest, size=values.shape)

    @staticmethod
    def from_visible(image: Image, window: IntensityWindow) -> DisplayImage:
        """Return the shades of a gray image, computed only where they are visible, of every n-th pixel."""
        count = max(0, math.ceil(math.log2(max(image.shape) / _OVERVIEW_SIDE))) + 1
        levels = (*image.finer, *(image.stored[:: 2**level, :: 2**level] for level in range(count)))
        return DisplayImage(tuple(FileLevel(level, window) for level in levels), -len(image.finer), image.shape)

    @property
    def shades(self) -> Pixels:
        """The shades at full size, or the finest that there are in memory."""
        shades = self.levels[max(-self.finest, 0)]
        assert isinstance(shades, np.ndarray)
        return shades

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns at full size."""
        rows, cols = self.size or self.shades.shape[:2]
        return rows, cols


def _halve_shades(shades: Pixels) -> Pixels:
    """Return the means of two by two pixels."""
    rows, cols, *channels = shades.shape
    half = np.empty((-(-rows // 2), -(-cols // 2), *channels), np.uint8)

    def halve_rows(first: int, end: int) -> None:
        half[first:end] = PIL.Image.fromarray(shades[2 * first : 2 * end]).reduce(2)

    run_in_bands(halve_rows, len(half))
    return half


@record
class DisplayVolume:
    """Shades of a volume, shape (P, R, C), of which a slice at a time is shown."""

    shades: Pixels


def build_display_image(image: Image) -> DisplayImage:
    """Build the display image of an image: its colors, or its gray values in the range that is shown."""
    if image.colors is not None:
        return DisplayImage.from_shades(image.colors.samples)
    return DisplayImage.from_image(image, IntensityWindow(*image.shown_range))


def apply_window(values: Array, window: IntensityWindow) -> Pixels:
    """Return the shades of an intensity window, ``255 ((v - low) / (high - low))^gamma``, rounded and clipped.

    It has the shape of the gray values, (H, W) or (P, H, W), and is made from them directly, so that the narrowest
    window still has 256 shades.
    """
    shown = np.empty(values.shape, np.uint8)
    top = 255.0 if window.gamma == 1.0 else _GAMMA_TABLE_SIZE - 1.0
    factor = top / max(window.high - window.low, 1e-300)
    curve = np.rint(255.0 * np.linspace(0.0, 1.0, _GAMMA_TABLE_SIZE) ** window.gamma).astype(np.uint8)
    rows = max(1, _VALUES_PER_BAND // max(1, values[:1].size))

    def shade_rows(first: int, end: int) -> None:
        codes = np.rint(np.clip((values[first:end] - window.low) * factor, 0.0, top))
        shown[first:end] = codes if window.gamma == 1.0 else curve[codes.astype(np.intp)]

    run_in_bands(shade_rows, len(values), rows)
    return shown


def compute_color_curve(window: IntensityWindow, white: float) -> Pixels:
    """Return the curve of an intensity window for each channel of a color image, shape (256,).

    `white` is the gray level that a byte of 255 stands for.
    """
    levels = np.linspace(0.0, white, 256)[np.newaxis]
    return apply_window(levels, window)[0]


def percentile_window(values: Array, percent: float) -> tuple[float, float]:
    """Return the ends of the range of gray values without `percent` per cent of the pixels at either end.

    `values` are gray values of any shape, and `percent` is from 0 to less than 50. The result is the whole range where
    both ends are the same. Of many pixels, only every n-th along each axis counts.
    """
    low, high = np.percentile(sample_values(values), [percent, 100.0 - percent])
    if percent == 0.0 or low == high:
        low, high = values.min(), values.max()
    return float(low), float(high)


def shade_edge_map(edge_map: Array) -> Pixels:
    """Shade edge strengths (H, W) from zero, 0, to the largest, 255; the square root makes weak edges visible."""
    return apply_window(edge_map, IntensityWindow(0.0, float(edge_map.max()), 0.5))


INSIDE_SHADE = 128
"""Shade of the pixels in an area, apart from those at its rim."""


def shade_area(area: Mask) -> Pixels:
    """Shade an area, shape (H, W): 0 outside, `INSIDE_SHADE` inside, and 255 at the rim."""
    shades = np.where(area, np.uint8(255), np.uint8(0))
    shades[scipy.ndimage.binary_erosion(area, border_value=1)] = INSIDE_SHADE
    return shades


@lru_cache(maxsize=1)
def measure_area_share(shown: DisplayImage) -> float:
    """Return the share of an image, from 0 to 1, that an area shaded by `shade_area` covers."""
    return float((np.asarray(shown.levels[0]) > 0).mean())


_POTENTIAL_OUTLIERS = 0.5
"""Percentage of the pixels at either end that the display image of a potential leaves out."""


def shade_potential(potential: Array) -> Pixels:
    """Shade potentials (H, W) from the lowest, 0, to the highest, 255, without a few pixels at either end."""
    return apply_window(potential, IntensityWindow(*percentile_window(potential, _POTENTIAL_OUTLIERS)))
