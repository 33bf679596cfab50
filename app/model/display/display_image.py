"""Shades: what is shown of an image or of what lies over it, one byte a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Array

DisplayImage = NDArray[np.uint8]

_ROWS = 64
"""Rows that are worked on at once: few enough for the processor's cache, which makes it several times faster."""

_CODES = 1 << 12
"""Entries of the table by which shades are bent."""


@dataclass(frozen=True, slots=True)
class IntensityWindow:
    """Gray values that are told apart: all below are black, all above white.

    Attributes
    ----------
    low, high : float
        Gray values shown black and white.
    gamma : float
        Exponent of what lies between; more than 1 darkens it.
    """

    low: float
    high: float
    gamma: float = 1.0


def display_of_image(values: Array) -> DisplayImage:
    """Gray values from the least, 0, to the largest, 255."""
    return apply_window(values, IntensityWindow(float(values.min()), float(values.max())))


def apply_window(values: Array, window: IntensityWindow) -> DisplayImage:
    """Gray values in a window, made from the values themselves: however narrow it is, it holds 256 shades.

    Parameters
    ----------
    values : ndarray, shape (H, W)
        Gray values.
    window : IntensityWindow
        What is black and white, in the unit of the values.

    Returns
    -------
    ndarray of uint8, shape (H, W)
        ``255 ((v - low) / (high - low))^gamma``, rounded and clipped.
    """
    shown = np.empty(values.shape, np.uint8)
    top = 255.0 if window.gamma == 1.0 else _CODES - 1.0
    factor = top / max(window.high - window.low, 1e-300)
    bent = np.rint(255.0 * np.linspace(0.0, 1.0, _CODES) ** window.gamma).astype(np.uint8)
    work = np.empty((min(_ROWS, len(values)), values.shape[1]))
    for begin in range(0, len(values), _ROWS):
        part = values[begin : begin + _ROWS]
        codes = work[: len(part)]
        np.subtract(part, window.low, out=codes)
        np.multiply(codes, factor, out=codes)
        np.clip(codes, 0.0, top, out=codes)
        np.rint(codes, out=codes)
        shown[begin : begin + _ROWS] = codes if window.gamma == 1.0 else bent[codes.astype(np.intp)]
    return shown


def percentile_window(values: Array, percent: float) -> tuple[float, float]:
    """Ends of the range that leaves out so many per cent of the pixels below, and as many above.

    Parameters
    ----------
    values : ndarray
        Gray values.
    percent : float
        From 0, which leaves out nothing, to less than 50.

    Returns
    -------
    low, high : float
        Percentiles of the gray values; the whole range where they are the same.
    """
    low, high = np.percentile(values, [percent, 100.0 - percent]) if percent > 0 else (values.min(), values.max())
    if low == high:
        low, high = values.min(), values.max()
    return float(low), float(high)


def display_of_edge_map(edge_map: Array) -> DisplayImage:
    """Edge strengths from none, 0, to the largest, 255; the square root brings out weak edges, which a user judges."""
    return _bytes(255.0 * np.sqrt(np.clip(edge_map / max(float(edge_map.max()), 1e-300), 0.0, 1.0)))


def _bytes(values: Array) -> DisplayImage:
    return np.rint(values).astype(np.uint8)


_OUTLIERS = 0.5
"""Per cent of the pixels at either end that the shades of a potential leave out."""


def display_of_potential(potential: Array) -> DisplayImage:
    """Potentials from the lowest, 0, to the highest, 255, but for a few pixels at either end."""
    return apply_window(potential, IntensityWindow(*percentile_window(potential, _OUTLIERS)))
