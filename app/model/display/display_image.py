"""Display images: an image or an overlay with one byte a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Array

DisplayImage = NDArray[np.uint8]

_ROWS = 64
"""Rows that are processed at once: few enough for the processor's cache, which is several times faster."""

_CODES = 1 << 12
"""Entries of the table of the gamma curve."""


@dataclass(frozen=True, slots=True)
class IntensityWindow:
    """Range of gray values: those up to `low` are black, those from `high` on white.

    `gamma` is the exponent in between; more than 1 darkens it.
    """

    low: float
    high: float
    gamma: float = 1.0


def display_of_image(values: Array) -> DisplayImage:
    """Gray values from the smallest, 0, to the largest, 255."""
    return apply_window(values, IntensityWindow(float(values.min()), float(values.max())))


def apply_window(values: Array, window: IntensityWindow) -> DisplayImage:
    """Display image of an intensity window, ``255 ((v - low) / (high - low))^gamma``, rounded and clipped.

    It has the shape of the gray values, (H, W), and is made from them directly, so that the narrowest window has 256
    gray values.
    """
    shown = np.empty(values.shape, np.uint8)
    top = 255.0 if window.gamma == 1.0 else _CODES - 1.0
    factor = top / max(window.high - window.low, 1e-300)
    curve = np.rint(255.0 * np.linspace(0.0, 1.0, _CODES) ** window.gamma).astype(np.uint8)
    work = np.empty((min(_ROWS, len(values)), values.shape[1]))
    for begin in range(0, len(values), _ROWS):
        part = values[begin : begin + _ROWS]
        codes = work[: len(part)]
        np.subtract(part, window.low, out=codes)
        np.multiply(codes, factor, out=codes)
        np.clip(codes, 0.0, top, out=codes)
        np.rint(codes, out=codes)
        shown[begin : begin + _ROWS] = codes if window.gamma == 1.0 else curve[codes.astype(np.intp)]
    return shown


def percentile_window(values: Array, percent: float) -> tuple[float, float]:
    """Ends of the range of gray values without `percent` per cent of the pixels at either end.

    `percent` is from 0 to less than 50; the result is the whole range where both ends are the same.
    """
    low, high = np.percentile(values, [percent, 100.0 - percent]) if percent > 0 else (values.min(), values.max())
    if low == high:
        low, high = values.min(), values.max()
    return float(low), float(high)


def display_of_edge_map(edge_map: Array) -> DisplayImage:
    """Edge strengths from zero, 0, to the largest, 255; the square root makes weak edges visible."""
    return _bytes(255.0 * np.sqrt(np.clip(edge_map / max(float(edge_map.max()), 1e-300), 0.0, 1.0)))


def _bytes(values: Array) -> DisplayImage:
    return np.rint(values).astype(np.uint8)


_OUTLIERS = 0.5
"""Percentage of the pixels at either end that the display image of a potential leaves out."""


def display_of_potential(potential: Array) -> DisplayImage:
    """Potentials from the lowest, 0, to the highest, 255, without a few pixels at either end."""
    return apply_window(potential, IntensityWindow(*percentile_window(potential, _OUTLIERS)))
