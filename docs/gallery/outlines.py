"""Outlines of shapes: closed rings of points, from corners, curves, and the zero lines of signed distances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from itertools import pairwise

import numpy as np
import skimage
from numpy.typing import ArrayLike, NDArray

from cpm_core.numerics.types import Array

Distance = Callable[[Array], Array]
"""Signed distance of points, shape (..., 2), to the boundary of a shape [px]; negative inside."""

Rings = tuple[Array, ...]
"""Closed rings of points (row, col), each of shape (K, 2), the first point not repeated. A point is inside when an
odd number of them encloses it."""

_STEP = 0.5
"""Largest distance from point to point along a curved ring [px]: the chords leave a circle of 4 px by 0.008 px."""

_PROBE = 1e-4
_CORRECTIONS = 4


def disk(center: tuple[float, float], radius: float) -> Distance:
    """Disk."""
    return lambda points: np.hypot(points[..., 0] - center[0], points[..., 1] - center[1]) - radius


def limb(a: tuple[float, float], b: tuple[float, float], radius_a: float, radius_b: float | None = None) -> Distance:
    """Round-ended limb with the medial axis from `a` to `b`: union of disks whose radius changes linearly along it."""
    start, along = np.array(a, dtype=float), np.array(b, dtype=float) - a
    length = float(np.hypot(*along))
    taper = (radius_a - (radius_a if radius_b is None else radius_b)) / length
    lean = taper / np.sqrt(1.0 - taper * taper)

    def distance(points: Array) -> Array:
        off = points - start
        forth = off @ along / length
        aside = np.abs(off[..., 0] * along[1] - off[..., 1] * along[0]) / length
        at = np.clip(forth - aside * lean, 0.0, length)  # center of the nearest disk of the limb
        return np.asarray(np.hypot(forth - at, aside) - (radius_a - taper * at))

    return distance


def stroke(path: ArrayLike, width: float) -> Distance:
    """Points within half of `width` of a line through vertices."""
    points = np.asarray(path, dtype=float)
    return union(*(limb(tuple(a), tuple(b), 0.5 * width) for a, b in pairwise(points)))


def union(*parts: Distance) -> Distance:
    """Union of shapes; deep inside the values are not exact distances."""
    return lambda points: reduce(np.minimum, (part(points) for part in parts))


def without(shape: Distance, *holes: Distance) -> Distance:
    """Make a shape without holes."""
    return lambda points: np.maximum(shape(points), -union(*holes)(points))


def blended(radius: float, *parts: Distance) -> Distance:
    """Union of shapes whose inner corners are rounded within about `radius`.

    The zero line is exact; away from it the values are approximate distances.
    """

    def join(one: Array, other: Array) -> Array:
        near = np.maximum(radius - np.abs(one - other), 0.0)
        return np.minimum(one, other) - near * near / (4.0 * radius)

    return lambda points: reduce(join, (part(points) for part in parts))


def rings(distance: Distance, shape: tuple[int, int]) -> Rings:
    """Zero line of a signed distance in an image of this shape (rows, columns).

    One ring for each closed line, with a point at least every `_STEP`; each point is moved along the gradient to where
    the distance is zero. ValueError when the shape is empty or reaches out of the image.
    """
    axes = [np.arange(0.0, n - 1 + _STEP, _STEP) for n in shape]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    lines = [line * _STEP for line in skimage.measure.find_contours(distance(grid), 0.0)]  # type: ignore[no-untyped-call]
    if not lines or any((line[0] != line[-1]).any() for line in lines):
        raise ValueError("the shape is empty or reaches out of the image: make the image larger.")
    return tuple(_on_zero(line[:-1], distance) for line in lines)


def _on_zero(points: Array, distance: Distance) -> Array:
    """Points moved to the zero line by Newton's method along the gradient."""
    for _ in range(_CORRECTIONS):
        value = distance(points)
        slope = np.stack(
            [(distance(points + s) - distance(points - s)) / (2.0 * _PROBE) for s in _PROBE * np.eye(2)], axis=-1
        )
        points = points - value[:, None] * slope / np.maximum((slope * slope).sum(axis=-1, keepdims=True), 1e-12)
    return points


def polygon(corners: ArrayLike) -> Rings:
    """Straight-sided outline."""
    return (np.asarray(corners, dtype=float),)


def curve(
    center: tuple[float, float], radius: Callable[[Array], Array], squeeze: float = 1.0, turn: float = 0.0
) -> Rings:
    """Outline at the distance `radius` [px] from its center (row, col), as a function of the angle from 0 to 2π.

    The rows are scaled by `squeeze`, then the outline is turned from columns to rows by the angle `turn` [rad].
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    count = int(np.ceil(4.0 * np.pi * float(np.max(radius(angle))) / _STEP))
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    down, right = squeeze * radius(angle) * np.sin(angle), radius(angle) * np.cos(angle)
    rows = down * np.cos(turn) + right * np.sin(turn)
    return (np.stack([center[0] + rows, center[1] + right * np.cos(turn) - down * np.sin(turn)], axis=1),)


def ellipse(center: tuple[float, float], half_height: float, half_width: float, turn: float = 0.0) -> Rings:
    """Ellipse, turned by an angle [rad]."""
    return curve(center, lambda angle: np.full_like(angle, half_width), half_height / half_width, turn)


def round_ring(center: tuple[float, float], radius: float) -> Rings:
    """Circle."""
    return ellipse(center, radius, radius)


def coverage(outlines: Sequence[Array], shape: tuple[int, int], fineness: int = 16) -> Array:
    """Share of every pixel that is inside rings (see `Rings`), shape (H, W), from 0 to 1.

    Each row of pixels is divided into `fineness` lines, along which the shares are exact.
    """
    rows, cols = shape
    lines, crossings = _crossings(outlines, rows * fineness, fineness)
    order = np.lexsort((crossings, lines))
    lines, crossings = lines[order], np.clip(crossings[order] + 0.5, 0.0, cols)
    sign = np.where(np.arange(len(lines)) % 2 == 0, 1.0, -1.0)
    pixel = np.minimum(crossings.astype(int), cols - 1)
    covered = 1.0 - (crossings - pixel)
    change = np.zeros((rows, cols + 1))
    np.add.at(change, (lines // fineness, pixel), sign * covered)
    np.add.at(change, (lines // fineness, pixel + 1), sign * (1.0 - covered))
    return np.clip(np.cumsum(change, axis=1)[:, :cols] / fineness, 0.0, 1.0)


def _crossings(outlines: Sequence[Array], count: int, fineness: int) -> tuple[NDArray[np.intp], Array]:
    """Where horizontal lines cross the sides of rings: number of the line, and column; an even number on every line."""
    numbers, columns = [np.empty(0, np.intp)], [np.empty(0)]
    for ring in outlines:
        a, b = ring, np.roll(ring, -1, axis=0)
        # Line n lies at the row (n + 1/2) / fineness - 1/2; a side includes its upper end but not its lower one.
        low, high = ((np.minimum, np.maximum)[k](a[:, 0], b[:, 0]) for k in (0, 1))
        first, last = (np.ceil((end + 0.5) * fineness - 0.5).astype(int) for end in (low, high))
        first, last = np.clip(first, 0, count), np.clip(last, 0, count)
        times = last - first
        side = np.repeat(np.arange(len(ring)), times)
        line = np.arange(len(side)) - np.repeat(np.cumsum(times) - times, times) + first[side]
        t = ((line + 0.5) / fineness - 0.5 - a[side, 0]) / (b[side, 0] - a[side, 0])
        numbers.append(line)
        columns.append(a[side, 1] + t * (b[side, 1] - a[side, 1]))
    return np.concatenate(numbers), np.concatenate(columns)
