"""Lines drawn over an image: trails of particles, and lines of equal potential."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator

import numpy as np

from cpm_core.numerics import Array, Index

_STILL = 0.05
"""Distance below which a segment is not drawn [px of the image]."""


class Trails:
    """Segments of the paths of particles between recorded steps, over the last `length` of them.

    Particles are matched by identity: a particle inserted or deleted in between has no segment.
    """

    def __init__(self, length: int) -> None:
        self._segments: deque[Array] = deque(maxlen=length)
        self._identity: Index = np.empty(0, np.int64)
        self._position: Array = np.empty((0, 2))
        self._step: int | None = None

    def __iter__(self) -> Iterator[Array]:
        """Segments (row, col) from and to, shape (M, 2, 2), newest first."""
        return reversed(self._segments)

    def __len__(self) -> int:
        return len(self._segments)

    def keep(self, length: int) -> None:
        """Change the number of steps that are kept."""
        self._segments = deque(self._segments, maxlen=length)

    def forget(self) -> None:
        """Remove all segments."""
        self._segments.clear()
        self._step = None

    def add(self, step: int, identity: Index, position: Array) -> None:
        """Add the positions, shape (N, 2) [px of the image], of particles by identity, shape (N,).

        A step that does not follow the last one removes all earlier segments.
        """
        if self._step == step:
            return
        if self._step is None or step < self._step:
            self._segments.clear()
        if self._step is not None and step > self._step:
            _, before, now = np.intersect1d(self._identity, identity, return_indices=True)
            pairs = np.stack([self._position[before], position[now]], axis=1)
            moves = np.abs(pairs[:, 1] - pairs[:, 0]).max(axis=1, initial=0.0) > _STILL
            self._segments.append(pairs[moves])
        self._step, self._identity, self._position = step, identity, position


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
