"""Inputs: images of many objects, and particles along curves."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array, Pixels

HAND = (398, 548)
"""Size of a radiograph of a hand, as in the publication [px]."""

_CELL = 72
"""Side of the square cell around each object [px]."""

_PITCH = 1.5
"""Distance of neighbors along a curve, as at the end of a run [px]."""

_ON_A_CURVE = 400
"""Particles on one closed curve."""


def objects(shape: tuple[int, int], seed: int = 0) -> Array:
    """Image (H, W) of bright objects of several sizes on an uneven background, with a little noise.

    Gray levels are from about 30 to 230. A larger image has more objects of the same sizes.
    """
    random = np.random.default_rng(seed)
    row, col = np.indices(shape, dtype=float)
    values = 45.0 + 25.0 * col / shape[1] + random.normal(0.0, 2.0, shape)
    for top in range(0, shape[0] - _CELL + 1, _CELL):
        for left in range(0, shape[1] - _CELL + 1, _CELL):
            here = (slice(top, top + _CELL), slice(left, left + _CELL))
            tall, wide = random.uniform(14.0, 28.0, 2)
            across = np.hypot((row[here] - top - 36.2) / tall, (col[here] - left - 35.7) / wide)
            values[here] += random.uniform(60.0, 140.0) * np.clip((1.0 - across) * min(tall, wide) + 0.5, 0.0, 1.0)
    return values


def tiled(side: int) -> Pixels:
    """Image of objects that repeat every 500 px, made without more memory than it takes."""
    tile = objects((500, 500)) - np.linspace(0.0, 25.0, 500, endpoint=False)
    return np.tile(tile.astype(np.uint8), (-(-side // 500),) * 2)[:side, :side]


def ring(side: int) -> Pixels:
    """Volume with a bright ring around its middle, in the plane of rows and columns; gray levels from 20 to 220."""
    volume = np.empty((side, side, side), np.uint8)
    row, col = (axis - 0.5 * (side - 1) for axis in np.ogrid[:side, :side])
    for plane in range(side):
        tube = np.hypot(np.hypot(row, col) - 0.28 * side, plane - 0.5 * (side - 1))
        volume[plane] = 20.5 + 200.0 * np.clip(0.125 * side - tube + 0.5, 0.0, 1.0)
    return volume


def one_object(shape: tuple[int, int]) -> tuple[float, float]:
    """Center (row, col) of an object of `objects` near the middle of the image [px]."""
    row, col = ((n // _CELL // 2) * _CELL for n in shape)
    return row + 36.2, col + 35.7


def along_curves(count: int, seed: int = 0) -> Array:
    """About `count` particles (N, 2) [px] as at the end of a run: along closed curves, with small random offsets."""
    curves = max(1, count // _ON_A_CURVE)
    each = count // curves
    radius = _PITCH * each / (2.0 * np.pi)
    angle = 2.0 * np.pi * np.arange(each) / each
    curve = radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    side = int(np.ceil(np.sqrt(curves)))
    centers = 2.5 * radius * np.stack(np.divmod(np.arange(curves), side), axis=1)
    points = (centers[:, None] + curve).reshape(-1, 2)
    return points + np.random.default_rng(seed).normal(0.0, 0.1, points.shape)
