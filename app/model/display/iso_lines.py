"""Lines of equal potential."""

from __future__ import annotations

import math

import numpy as np

from cpm_core.numerics.types import Array

LINES = 12
"""Lines between the extremes."""

_LONGEST = 512
"""Longest side of the grid on which lines are found: they are smooth, and a finer grid would take long."""


def iso_lines(values: Array) -> Array:
    """Lines at evenly spaced quantiles of values, shape (H, W).

    The result, shape (M, 2), holds the vertices (row, col) of all lines, with a row of NaN after each line.
    """
    from skimage.measure import find_contours

    stride = max(1, math.ceil(max(values.shape) / _LONGEST))
    coarse = values[::stride, ::stride]
    levels = np.quantile(coarse, (np.arange(LINES) + 1.0) / (LINES + 1.0))
    gap = np.full((1, 2), np.nan)
    lines = [line for level in np.unique(levels) for line in find_contours(coarse, level)]  # type: ignore[no-untyped-call]
    pieces = [piece for line in lines for piece in (line, gap)]
    return np.asarray(np.concatenate([np.empty((0, 2)), *pieces]) * stride)
