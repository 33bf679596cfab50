"""Curves of files as vertices that are nowhere farther than a fiftieth of a pixel from them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array

_NEAR = 0.005
"""Largest distance of the vertices' line from the curve [unit of the file; px in most]."""

_MOST = 2000
"""Most vertices of one curve."""

_FEWEST = 128
"""Fewest vertices of an ellipse."""


def ellipse(
    center: Sequence[float] | Array,
    first: Sequence[float] | Array,
    second: Sequence[float] | Array,
) -> Array:
    """Vertices of an ellipse with two half axes as vectors, shape (K, 2)."""
    one, other = np.asarray(first, float), np.asarray(second, float)
    radius = max(float(np.linalg.norm(one)), float(np.linalg.norm(other)), _NEAR)
    turn = 2.0 * math.acos(1.0 - min(_NEAR / radius, 0.5))
    count = int(min(_MOST, max(_FEWEST, 2.0 * math.pi / turn))) + 1
    angle = 2.0 * math.pi * np.arange(count) / count
    return np.asarray(center, float) + np.outer(np.cos(angle), one) + np.outer(np.sin(angle), other)


def rectangle(corner: Sequence[float] | Array, opposite: Sequence[float] | Array) -> Array:
    """The corners of an upright rectangle of which two opposite ones are given."""
    (top, left), (bottom, right) = corner, opposite
    return np.array([(top, left), (top, right), (bottom, right), (bottom, left)], float)


def bezier(*corners: Sequence[float] | Array) -> Array:
    """Vertices of a Bézier curve of degree two or three, without its first one."""
    control = np.array([tuple(corner) for corner in corners], float)
    if len(control) == 3:
        start, middle, end = control
        control = np.array([start, start + 2.0 / 3.0 * (middle - start), end + 2.0 / 3.0 * (middle - end), end])
    bend = 6.0 * np.linalg.norm(np.diff(control, 2, axis=0), axis=1).max()
    count = int(min(_MOST, math.sqrt(bend / (8.0 * _NEAR)))) + 1
    along = np.arange(1, count + 1) / count
    shares = np.stack([(1 - along) ** 3, 3 * (1 - along) ** 2 * along, 3 * (1 - along) * along**2, along**3], axis=1)
    return shares @ control


def nested(curves: Sequence[Array]) -> list[tuple[Array, bool]]:
    """The curves around one area, with which of them are holes: those that an odd number of the others encloses."""
    around = [
        sum(bool(polyline.inside(other, curve[:1])[0]) for other in curves if other is not curve) for curve in curves
    ]
    return [(curve, count % 2 == 1) for curve, count in zip(curves, around, strict=True)]
