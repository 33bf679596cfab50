"""Curves of files as vertices that are nowhere farther than a fiftieth of a pixel from them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array

_NEAR = 0.005
"""Largest distance of the vertices' line from the curve [unit of the file; px in most]."""

_MOST = 2000
"""Most vertices of one arc or curve."""

_FEWEST = 128
"""Fewest vertices of a whole ellipse."""


def ellipse(
    center: Sequence[float] | Array,
    first: Sequence[float] | Array,
    second: Sequence[float] | Array,
    start: float = 0.0,
    sweep: float = 2.0 * math.pi,
) -> Array:
    """Vertices of an ellipse with two half axes as vectors, shape (K, 2).

    From the angle `start` over `sweep`, both ends included; the end of a whole ellipse is left out.
    """
    one, other = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    radius = max(float(np.linalg.norm(one)), float(np.linalg.norm(other)), _NEAR)
    turn = 2.0 * math.acos(1.0 - min(_NEAR / radius, 0.5))
    count = int(min(_MOST, max(_FEWEST * abs(sweep) / (2.0 * math.pi), abs(sweep) / turn, 1.0))) + 1
    whole = abs(sweep) >= 2.0 * math.pi - 1e-9
    angle = start + sweep * np.arange(count + (not whole)) / count
    return np.asarray(center, dtype=float) + np.outer(np.cos(angle), one) + np.outer(np.sin(angle), other)


def rectangle(corner: Sequence[float] | Array, opposite: Sequence[float] | Array) -> Array:
    """The corners of an upright rectangle of which two opposite ones are given."""
    (top, left), (bottom, right) = corner, opposite
    return np.array([(top, left), (top, right), (bottom, right), (bottom, left)], dtype=float)


def bezier(*corners: Array) -> Array:
    """Vertices of a Bézier curve of degree two or three, without its first one."""
    if len(corners) == 3:
        start, middle, end = corners
        corners = (start, start + 2.0 / 3.0 * (middle - start), end + 2.0 / 3.0 * (middle - end), end)
    start, one, two, end = corners
    bend = 6.0 * max(float(np.linalg.norm(start - 2.0 * one + two)), float(np.linalg.norm(one - 2.0 * two + end)))
    count = int(min(_MOST, math.sqrt(bend / (8.0 * _NEAR)))) + 1
    along = (np.arange(1, count + 1) / count)[:, None]
    left = 1.0 - along
    inner = 3.0 * left * along * (left * one + along * two)
    return np.asarray(left**3 * start + inner + along**3 * end)


def bulged(start: Array, end: Array, bulge: float) -> Array:
    """Vertices of a circular arc without its first one; `bulge` is the tangent of a quarter of its angle."""
    if abs(bulge) < 1e-9 or np.array_equal(start, end):
        return end[None]
    chord = end - start
    # from the middle of the chord to the center, along the normal to the left of the chord
    normal = np.array([-chord[1], chord[0]])
    center = 0.5 * (start + end) + normal * (1.0 - bulge * bulge) / (4.0 * bulge)
    first = start - center
    return ellipse(center, first, np.array([-first[1], first[0]]), 0.0, 4.0 * math.atan(bulge))[1:]


def spline(degree: int, knots: Sequence[float], controls: Array, weights: Sequence[float] = ()) -> Array:
    """Vertices of a B-spline, rational where there are weights, shape (K, 2)."""
    weight = np.asarray(weights if len(weights) == len(controls) else np.ones(len(controls)), dtype=float)
    curve = scipy.interpolate.BSpline(
        np.asarray(knots, dtype=float), np.column_stack([controls * weight[:, None], weight]), degree
    )
    low, high = knots[degree], knots[len(controls)]
    count = 8 * max(1, len(controls) - degree)
    while True:
        values = curve(np.linspace(low, high, 2 * count + 1))
        places = values[:, :2] / values[:, 2:]
        sag = np.linalg.norm(places[1::2] - 0.5 * (places[:-1:2] + places[2::2]), axis=1).max()
        if sag < _NEAR or count > _MOST:
            return np.asarray(places[::2])
        count *= 2


def nested(curves: Sequence[Array]) -> list[tuple[Array, bool]]:
    """The curves around one area, with which of them are holes: those that an odd number of the others encloses."""
    around = [
        sum(bool(polyline.inside(other, curve[:1])[0]) for other in curves if other is not curve) for curve in curves
    ]
    return [(curve, count % 2 == 1) for curve, count in zip(curves, around, strict=True)]
