"""Antialiased scenes whose boundaries are known exactly: what the runs of the model are measured against."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DARK, BRIGHT = 40.0, 200.0
_OVERSAMPLING = 8
"""Places along each side of a pixel; upright and level boundaries at multiples of 1/8 px are rendered exactly."""


@dataclass(frozen=True)
class Scene:
    """An image, the distance of any point to the true boundary, and points densely along that boundary."""

    values: Array
    distance: Callable[[Array], Array]
    boundary: Array


def antialiased(shape: tuple[int, int], inside: Callable[[Array, Array], NDArray[np.bool_]]) -> Array:
    """Image of what is inside, every pixel the mean over a grid of places within it."""
    n = _OVERSAMPLING
    fine = (np.arange(n) + 0.5) / n - 0.5
    row = (np.arange(shape[0])[:, None] + fine).ravel()
    col = (np.arange(shape[1])[:, None] + fine).ravel()
    covered = inside(row[:, None], col[None, :]).reshape(shape[0], n, shape[1], n).mean(axis=(1, 3))
    return DARK + (BRIGHT - DARK) * covered


def circle_points(center: tuple[float, float], radius: float, count: int) -> Array:
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([center[0] + radius * np.sin(angle), center[1] + radius * np.cos(angle)], axis=1)


def disk(shape: tuple[int, int], center: tuple[float, float], radius: float) -> Scene:
    values = antialiased(shape, lambda row, col: (row - center[0]) ** 2 + (col - center[1]) ** 2 < radius**2)
    return Scene(
        values,
        lambda points: np.abs(np.hypot(points[:, 0] - center[0], points[:, 1] - center[1]) - radius),
        circle_points(center, radius, int(8 * radius)),
    )


def ring(shape: tuple[int, int], center: tuple[float, float], inner: float, outer: float) -> Scene:
    def inside(row: Array, col: Array) -> NDArray[np.bool_]:
        away = np.hypot(row - center[0], col - center[1])
        return (away > inner) & (away < outer)

    def distance(points: Array) -> Array:
        away = np.hypot(points[:, 0] - center[0], points[:, 1] - center[1])
        return np.minimum(np.abs(away - inner), np.abs(away - outer))

    boundary = np.concatenate([circle_points(center, r, int(8 * r)) for r in (inner, outer)])
    return Scene(antialiased(shape, inside), distance, boundary)


def polygon_distance(points: Array, corners: Array) -> Array:
    """Distance of points to a closed polygon."""
    least = np.full(len(points), np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = b - a
        t = np.clip((points - a) @ along / (along @ along), 0.0, 1.0)
        least = np.minimum(least, np.linalg.norm(points - (a + t[:, None] * along), axis=1))
    return least


def polygon(shape: tuple[int, int], corners: Array) -> Scene:
    """Polygon with corners (row, col), filled by the even-odd rule."""
    corners = np.asarray(corners, dtype=float)

    def inside(row: Array, col: Array) -> NDArray[np.bool_]:
        odd = np.zeros(np.broadcast_shapes(row.shape, col.shape), bool)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            if a[0] == b[0]:
                continue
            between = (a[0] <= row) != (b[0] <= row)
            odd ^= between & (col < a[1] + (row - a[0]) * (b[1] - a[1]) / (b[0] - a[0]))
        return odd

    sides = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        count = max(2, int(4 * np.linalg.norm(b - a)))
        sides.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return Scene(antialiased(shape, inside), lambda points: polygon_distance(points, corners), np.concatenate(sides))


def square(shape: tuple[int, int], low: tuple[float, float], side: float) -> Scene:
    r, c = low
    return polygon(shape, np.array([(r, c), (r, c + side), (r + side, c + side), (r + side, c)]))


U_CORNERS: Array = np.array([(16, 20), (80, 20), (80, 76), (16, 76), (16, 58), (60, 58), (60, 38), (16, 38)]) + 0.375


def u_shape() -> Scene:
    """A U of 96 by 96 pixels, open to the top."""
    return polygon((96, 96), U_CORNERS)


def turned(points: Array, shape: tuple[int, int]) -> Array:
    """Where `numpy.rot90` of an image takes its points."""
    return np.stack([shape[1] - 1.0 - points[:, 1], points[:, 0]], axis=1)


def mirrored(points: Array, shape: tuple[int, int], axis: int) -> Array:
    """Where `numpy.flip` of an image along an axis takes its points."""
    out = points.copy()
    out[:, axis] = shape[axis] - 1.0 - out[:, axis]
    return out


def outline_distance(points: Array, paths: list[Array]) -> Array:
    """Distance of points to the nearest of some polygonal lines (first vertex repeated where they close)."""
    least = np.full(len(points), np.inf)
    for path in paths:
        for a, b in pairwise(path):
            along = b - a
            t = np.clip((points - a) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
            least = np.minimum(least, np.linalg.norm(points - (a + t[:, None] * along), axis=1))
    return least


def blob(shape: tuple[int, int], center: tuple[float, float]) -> Array:
    """Image of a smooth shape without any symmetry, about 36 px across."""

    def inside(row: Array, col: Array) -> NDArray[np.bool_]:
        angle = np.arctan2(row - center[0], col - center[1])
        radius = 18.0 + 2.5 * np.cos(2.0 * angle + 0.4) + 1.5 * np.cos(3.0 * angle - 1.1) + 0.6 * np.sin(5.0 * angle)
        return np.hypot(row - center[0], col - center[1]) < radius

    return antialiased(shape, inside)
