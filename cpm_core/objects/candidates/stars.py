"""Stars: closed lines around a start that have one distance in each direction, along the clearest step of gray levels.

The radii are found by dynamic programming in polar coordinates (Timp & Karssemeijer 2004, DOI 10.1118/1.1688039), with
logarithms of radii, so that large and small outlines are alike. Such a line is smooth: it does not follow a streak or a
neighbor that hangs together with the object, as a flood does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.objects.candidates.appearance import Appearance
from cpm_core.objects.candidates.grids import Box

DIRECTIONS = 72

_STEP = 0.05
"""Step of the logarithm of the radius."""

_SHELLS = 3
"""Steps before and behind a radius whose mean gray levels are compared there."""

_TURN, _MOST_TURN = 0.05, 2
"""Price of a change of the radius from one direction to the next, times its square [steps]; and the largest change."""

_HALF = 0.35
"""Step of gray levels that counts a half, in standard deviations of the image: stronger ones count little more."""

_WIDTH, _SHIFT = 3.0, 1.6
"""Ratio of the largest to the smallest radius of a line, and that between the smallest radii of those looked for."""

_COARSE = 0.05
"""Distance of the pixels of the resolution that is looked at, in radii, at most."""

_LEAST_STEPS = 5

_ANGLES = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_UNIT = np.stack([np.sin(_ANGLES), np.cos(_ANGLES)], axis=1)


class Star(NamedTuple):
    """A closed line around a place.

    Attributes
    ----------
    row, col : float
        The place [px].
    radii : ndarray, shape (`DIRECTIONS`,)
        Its distance in each direction [px].
    support : float
        Mean of how clear the step of gray levels is along it, 0 to 1.
    """

    row: float
    col: float
    radii: Array
    support: float

    @property
    def box(self) -> Box:
        """A box that holds it."""
        rows, cols = self.row + self.radii * _UNIT[:, 0], self.col + self.radii * _UNIT[:, 1]
        return int(rows.min()) - 1, int(rows.max()) + 2, int(cols.min()) - 1, int(cols.max()) + 2

    def within(self, rows: Index, cols: Index) -> Mask:
        """Which pixels of these rows and columns it encloses."""
        return _within(rows, cols, self.row, self.col, self.radii)


def stars(
    look: Appearance,
    place: tuple[float, float],
    limits: tuple[float, float],
    count: int,
) -> list[Star]:
    """The clearest lines around a place, from light to dark and from dark to light.

    Parameters
    ----------
    look : Appearance
        The image.
    place : (float, float)
        Row and column.
    limits : (float, float)
        Limits of the radii [px].
    count : int
        Lines of each of the two kinds, at most.
    """
    least, most = limits
    number = int(math.log(max(most / least, 1.0)) / _STEP) + 1
    radii = least * np.exp(_STEP * np.arange(number))
    scale = np.clip(np.log2(np.maximum(_COARSE * radii, 1.0)), 0, len(look.resolutions) - 1).astype(np.int64)
    grays = tuple(each.gray for each in look.resolutions)
    steps = _steps(grays, np.array(look.level.shape), *place, radii, scale, _UNIT, _HALF * look.deviation)
    width, shift = int(math.log(_WIDTH) / _STEP), int(math.log(_SHIFT) / _STEP)
    found = []
    for sign in (1.0, -1.0):
        lines: dict[bytes, Star] = {}
        for first in range(0, max(number - width // 2, 1), shift):
            last = min(first + width, number)
            if last - first >= _LEAST_STEPS:
                line, support = _line(steps, sign, first, last)
                lines[line.tobytes()] = Star(*place, radii[line], support)
        found += sorted(lines.values(), key=lambda star: -star.support)[:count]
    return found


@compiled
def _steps(
    grays: tuple[Single, ...],
    shape: Index,
    row: float,
    col: float,
    radii: Array,
    scale: Index,
    unit: Array,
    half: float,
) -> Array:
    """How clear the step of gray levels is at each radius in each direction, -1 to 1; 0 outside the image."""
    count, number = len(unit), len(radii)
    plain, known = np.zeros((count, number)), np.zeros((count, number), np.bool_)
    for a in range(count):
        for k in range(number):
            r, c = row + radii[k] * unit[a, 0], col + radii[k] * unit[a, 1]
            known[a, k] = 0.0 <= r <= shape[0] - 1 and 0.0 <= c <= shape[1] - 1
            plain[a, k] = _gray(grays[scale[k]], r, c, float(1 << scale[k]))
    smooth, found = np.zeros(number + 1), np.zeros((count, number))
    for a in range(count):
        for k in range(number):
            near = plain[a - 1, k] + plain[(a + 1) % count, k]
            far = plain[a - 2, k] + plain[(a + 2) % count, k]
            smooth[k + 1] = smooth[k] + (6.0 * plain[a, k] + 4.0 * near + far) / 16.0
        for k in range(1, number):
            first, last = max(k - _SHELLS, 0), min(k + _SHELLS, number)
            if known[a, k]:
                inner, outer = (smooth[k] - smooth[first]) / (k - first), (smooth[last] - smooth[k]) / (last - k)
                found[a, k] = (outer - inner) / (abs(outer - inner) + half)
    return found


@compiled
def _gray(gray: Single, r: float, c: float, stride: float) -> float:
    """Gray level at a place of the image, between the middles of the blocks of a resolution."""
    rows, cols = gray.shape
    y = min(max((r + 0.5) / stride - 0.5, 0.0), rows - 1.0)
    x = min(max((c + 0.5) / stride - 0.5, 0.0), cols - 1.0)
    i, j = min(int(y), max(rows - 2, 0)), min(int(x), max(cols - 2, 0))
    below, right = min(i + 1, rows - 1), min(j + 1, cols - 1)
    v, u = y - i, x - j
    upper = (1.0 - u) * gray[i, j] + u * gray[i, right]
    lower = (1.0 - u) * gray[below, j] + u * gray[below, right]
    return float((1.0 - v) * upper + v * lower)


@compiled
def _line(steps: Array, sign: float, first: int, last: int) -> tuple[Index, float]:
    """The best radius in each direction, between two of them; and the mean step along the line.

    The way goes around twice, and the second half of the first turn with the first half of the second is the line.
    """
    count, number = len(steps), last - first
    best, before = np.zeros(number), np.zeros(number)
    back = np.zeros((2 * count, number), np.int8)
    for a in range(2 * count):
        best, before = before, best
        for k in range(number):
            highest, turn = 0.0, 0
            if a > 0:
                highest = -np.inf
                for j in range(max(-_MOST_TURN, -k), min(_MOST_TURN, number - 1 - k) + 1):
                    value = before[k + j] - _TURN * j * j
                    if value > highest:
                        highest, turn = value, j
            best[k] = highest + sign * steps[a % count, first + k]
            back[a, k] = turn
    line, support = np.zeros(count, np.int64), 0.0
    k = int(np.argmax(best))
    for a in range(2 * count - 1, -1, -1):
        if count // 2 <= a < count + count // 2:
            line[a % count] = first + k
            support += sign * steps[a % count, first + k]
        k += back[a, k]
    return line, support / count


@compiled
def _within(rows: Index, cols: Index, row: float, col: float, radii: Array) -> Mask:
    count = len(radii)
    found = np.zeros((len(rows), len(cols)), np.bool_)
    nearest, farthest = radii.min(), radii.max()
    for i in range(len(rows)):
        for j in range(len(cols)):
            y, x = rows[i] - row, cols[j] - col
            square = y * y + x * x
            if square <= nearest * nearest:
                found[i, j] = True
            elif square <= farthest * farthest:
                turn = math.atan2(y, x) / (2.0 * np.pi) * count
                number = math.floor(turn)
                part = turn - number
                limit = (1.0 - part) * radii[number % count] + part * radii[(number + 1) % count]
                found[i, j] = square <= limit * limit
    return found
