"""The motion of level sets: one step of the equation that geometric active contours share, and signed distances.

A function phi is above 0 inside the contour. It follows::

    dphi/dt = a kappa |grad phi| + b |grad phi| - v . grad phi

with the curvature ``kappa = div(grad phi / |grad phi|)``, weights a and b, and a velocity v on the pixels. The first
term takes central differences, the second those of Godunov, the third those from where v comes (Osher and Sethian 1988,
doi:10.1016/0021-9991(88)90002-2).

Only pixels near the contour are visited (Adalsteinsson and Sethian 1995, doi:10.1006/jcph.1995.1098): the pixels of a
band, row by row. `first` holds for each row, and for the row after the last, the place of its first pixel in `cols`.
What is computed is to the bit what a visit to all pixels gives: a pixel moves only within `BAND` of the contour, where
its neighbors lie within `FARTHEST`, and distances up to there depend on nearer pixels alone.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array

Indices = NDArray[np.int64]

BAND = 6.0
"""Distance from the contour within which the function moves [px]."""

FARTHEST = BAND + 2.0
"""Distance at which the function is cut [px]."""

REACH = math.ceil(FARTHEST * math.sqrt(2.0))
"""Steps from pixel to neighbor, from the contour, within which all pixels of a distance below `FARTHEST` lie."""

_FAR = 1e9


@compiled
def moved(
    phi: Array, first: Indices, cols: Indices, curvature: Array, pressure: Array, velocity: Array, time: float
) -> Array:
    """The function after a time, at the pixels of a band, shape (N,).

    `curvature` and `pressure` are the weights a and b, shape (H, W), `velocity` is v, shape (2, H, W) [px]. Beyond the
    border the function continues with its outermost values.
    """
    rows, width = phi.shape
    out = np.empty(len(cols))
    for row in range(rows):
        up, down = max(row - 1, 0), min(row + 1, rows - 1)
        for place in range(first[row], first[row + 1]):
            col = cols[place]
            here = phi[row, col]
            out[place] = here
            if abs(here) > BAND:
                continue
            left, right = max(col - 1, 0), min(col + 1, width - 1)
            to_up, to_down = here - phi[up, col], phi[down, col] - here
            to_left, to_right = here - phi[row, left], phi[row, right] - here
            change = 0.0
            weight = curvature[row, col]
            if weight != 0.0:
                by_row, by_col = 0.5 * (to_up + to_down), 0.5 * (to_left + to_right)
                square = by_row * by_row + by_col * by_col
                if square > 1e-12:
                    mixed = 0.25 * (phi[down, right] - phi[down, left] - phi[up, right] + phi[up, left])
                    second = (to_down - to_up) * by_col * by_col + (to_right - to_left) * by_row * by_row
                    # a curvature above 1/px is that of noise on the grid
                    length = np.sqrt(square)
                    bend = (second - 2.0 * mixed * by_row * by_col) / (square * length)
                    change += weight * min(max(bend, -1.0), 1.0) * length
            push = pressure[row, col]
            if push > 0.0:  # the contour grows: the function rises, from where it is higher
                steep = max(-to_up, 0.0) ** 2 + max(to_down, 0.0) ** 2
                steep += max(-to_left, 0.0) ** 2 + max(to_right, 0.0) ** 2
                change += push * np.sqrt(steep)
            elif push < 0.0:
                steep = max(to_up, 0.0) ** 2 + max(-to_down, 0.0) ** 2
                steep += max(to_left, 0.0) ** 2 + max(-to_right, 0.0) ** 2
                change += push * np.sqrt(steep)
            drift_row, drift_col = velocity[0, row, col], velocity[1, row, col]
            change -= drift_row * (to_up if drift_row > 0.0 else to_down)
            change -= drift_col * (to_left if drift_col > 0.0 else to_right)
            out[place] = here + time * change
    return out


@compiled
def signed_distance(phi: Array, first: Indices, cols: Indices, reach: int) -> tuple[Array, Indices, Indices]:
    """Distance from the zero of a function, shape (H, W), with its sign, cut at `FARTHEST` [px], and its band.

    The zero is looked for at the pixels of the given band and beside them; the new one has all pixels within `reach`
    steps from it. Beside the zero the distance is that of a straight contour through the pixels between which the sign
    changes; elsewhere it solves ``|grad d| = 1`` by sweeps in four directions (Zhao 2005,
    doi:10.1090/S0025-5718-04-01678-3).
    """
    rows, width = phi.shape
    out = np.full(phi.shape, _FAR)
    fixed = _beside_zero(phi, first, cols, out)
    near, places = _band_around(fixed, first, cols, reach)
    for sweep in range(4):
        for i in range(rows):
            row = i if sweep % 2 == 0 else rows - 1 - i
            begin, end = near[row], near[row + 1]
            for j in range(end - begin):
                col = places[begin + j] if sweep < 2 else places[end - 1 - j]
                if fixed[row, col]:
                    continue
                a = min(out[max(row - 1, 0), col], out[min(row + 1, rows - 1), col])
                b = min(out[row, max(col - 1, 0)], out[row, min(col + 1, width - 1)])
                onward = min(a, b) + 1.0
                if onward > max(a, b):
                    onward = 0.5 * (a + b + np.sqrt(2.0 - (a - b) * (a - b)))
                out[row, col] = min(out[row, col], onward)
    for row in range(rows):
        for col in range(width):
            size = min(out[row, col], FARTHEST)
            out[row, col] = size if phi[row, col] > 0.0 else -size
    return out, near, places


@compiled
def _beside_zero(phi: Array, first: Indices, cols: Indices, out: Array) -> NDArray[np.bool_]:
    """The pixels of a band between which the sign changes; their distance from its zero is written to `out` [px]."""
    rows, width = phi.shape
    fixed = np.zeros(phi.shape, dtype=np.bool_)
    for row in range(rows):
        for place in range(first[row], first[row + 1]):
            col = cols[place]
            here = phi[row, col]
            by_row = by_col = _FAR
            for other in (row - 1, row + 1):
                if 0 <= other < rows and (phi[other, col] > 0.0) != (here > 0.0):
                    by_row = min(by_row, abs(here) / max(abs(here - phi[other, col]), 1e-12))
            for other in (col - 1, col + 1):
                if 0 <= other < width and (phi[row, other] > 0.0) != (here > 0.0):
                    by_col = min(by_col, abs(here) / max(abs(here - phi[row, other]), 1e-12))
            if by_row < _FAR and by_col < _FAR:
                out[row, col] = by_row * by_col / max(np.sqrt(by_row * by_row + by_col * by_col), 1e-12)
            else:
                out[row, col] = min(by_row, by_col)
            fixed[row, col] = out[row, col] < _FAR
    return fixed


@compiled
def _band_around(fixed: NDArray[np.bool_], first: Indices, cols: Indices, reach: int) -> tuple[Indices, Indices]:
    """The band of the pixels within so many steps, along rows and columns, of the chosen pixels of another band."""
    rows, width = fixed.shape
    taken = np.zeros(fixed.shape, dtype=np.bool_)
    queue = np.empty(fixed.size, dtype=np.int64)
    count = 0
    for row in range(rows):
        for place in range(first[row], first[row + 1]):
            if fixed[row, cols[place]]:
                taken[row, cols[place]] = True
                queue[count] = row * width + cols[place]
                count += 1
    begin = 0
    for _ in range(reach):
        end = count
        for place in range(begin, end):
            row, col = queue[place] // width, queue[place] % width
            for turn in range(4):
                r, c = row + (turn == 0) - (turn == 1), col + (turn == 2) - (turn == 3)
                if 0 <= r < rows and 0 <= c < width and not taken[r, c]:
                    taken[r, c] = True
                    queue[count] = r * width + c
                    count += 1
        if end == count:
            break
        begin = end
    return _by_rows(taken, count)


@compiled
def _by_rows(taken: NDArray[np.bool_], count: int) -> tuple[Indices, Indices]:
    """The band of the pixels that are taken."""
    rows, width = taken.shape
    first, cols = np.empty(rows + 1, dtype=np.int64), np.empty(count, dtype=np.int64)
    found = 0
    for row in range(rows):
        first[row] = found
        for col in range(width):
            if taken[row, col]:
                cols[found] = col
                found += 1
    first[rows] = found
    return first, cols
