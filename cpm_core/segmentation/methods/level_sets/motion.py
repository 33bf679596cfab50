"""The motion of level sets: one step of the equation that geometric active contours share, and signed distances.

A function phi is above 0 inside the contour. It follows::

    dphi/dt = a kappa |grad phi| + b |grad phi| - v . grad phi

with the curvature ``kappa = div(grad phi / |grad phi|)``, weights a and b, and a velocity v on the pixels. The first
term takes central differences, the second those of Godunov, the third those from where v comes (Osher and Sethian 1988,
doi:10.1016/0021-9991(88)90002-2).
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array

BAND = 6.0
"""Distance from the contour within which the function moves [px]."""

_FAR = 1e9


@compiled
def moved(phi: Array, curvature: Array, pressure: Array, velocity: Array, time: float) -> Array:
    """The function after a time, shape (H, W).

    `curvature` and `pressure` are the weights a and b, shape (H, W), `velocity` is v, shape (2, H, W) [px]. Beyond the
    border the function continues with its outermost values.
    """
    rows, cols = phi.shape
    out = phi.copy()
    for row in range(rows):
        up, down = max(row - 1, 0), min(row + 1, rows - 1)
        for col in range(cols):
            here = phi[row, col]
            if abs(here) > BAND:
                continue
            left, right = max(col - 1, 0), min(col + 1, cols - 1)
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
            out[row, col] = here + time * change
    return out


@compiled
def signed_distance(phi: Array) -> Array:
    """Distance from the zero of a function, shape (H, W) [px], with its sign.

    Beside the zero the distance is that of a straight contour through the pixels between which the sign changes;
    elsewhere it solves ``|grad d| = 1`` by sweeps in four directions (Zhao 2005, doi:10.1090/S0025-5718-04-01678-3).
    """
    rows, cols = phi.shape
    out = _beside_zero(phi)
    fixed = out < _FAR
    for sweep in range(4):
        for i in range(rows):
            row = i if sweep % 2 == 0 else rows - 1 - i
            for j in range(cols):
                col = j if sweep < 2 else cols - 1 - j
                if fixed[row, col]:
                    continue
                a = min(out[max(row - 1, 0), col], out[min(row + 1, rows - 1), col])
                b = min(out[row, max(col - 1, 0)], out[row, min(col + 1, cols - 1)])
                reach = min(a, b) + 1.0
                if reach > max(a, b):
                    reach = 0.5 * (a + b + np.sqrt(2.0 - (a - b) * (a - b)))
                out[row, col] = min(out[row, col], reach)
    return np.where(phi > 0.0, out, -out)


@compiled
def _beside_zero(phi: Array) -> Array:
    """Distance of the pixels between which the sign changes from its zero, shape (H, W); `_FAR` elsewhere [px]."""
    rows, cols = phi.shape
    out = np.full((rows, cols), _FAR)
    for row in range(rows):
        for col in range(cols):
            here = phi[row, col]
            by_row = by_col = _FAR
            for other in (row - 1, row + 1):
                if 0 <= other < rows and (phi[other, col] > 0.0) != (here > 0.0):
                    by_row = min(by_row, abs(here) / max(abs(here - phi[other, col]), 1e-12))
            for other in (col - 1, col + 1):
                if 0 <= other < cols and (phi[row, other] > 0.0) != (here > 0.0):
                    by_col = min(by_col, abs(here) / max(abs(here - phi[row, other]), 1e-12))
            if by_row < _FAR and by_col < _FAR:
                out[row, col] = by_row * by_col / max(np.sqrt(by_row * by_row + by_col * by_col), 1e-12)
            else:
                out[row, col] = min(by_row, by_col)
    return out
