"""A closed curve under tension, rigidity and a force of the image: the motion that all snakes share.

The points r of a curve follow ``gamma dr/dt = alpha r'' - beta r'''' + F(r)``. A step takes the forces of the curve
itself at its end and that of the image at its beginning, so that it is stable for any tension and rigidity (Kass,
Witkin and Terzopoulos 1988, appendix A). The matrix is circulant: it is inverted by Fourier transforms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from cpm_core.numerics.polyline import length, resampled
from cpm_core.numerics.segments import SegmentTree
from cpm_core.numerics.types import Array
from cpm_core.objects.methods.states import CurveState

Force = Callable[[Array], Array]
"""Force at positions, shape (N, 2), shape (N, 2)."""

_FARTHEST = 1.0
"""Largest distance that a point moves along an axis in a step [px]."""

_LEAST_POINTS, _LEAST_LENGTH = 8, 8.0
"""Points and length [px] under which a curve has collapsed."""

_UNEVEN = (0.5, 1.5)
"""Distances of neighbors, in units of the wanted one, beyond which the points of a curve are placed again."""

_EVERY, _REST = 20, 0.1
"""A curve is at rest when within so many steps it has not moved farther than this [px]."""


@dataclass(frozen=True)
class Elasticity:
    """What a curve does by itself.

    Attributes
    ----------
    alpha, beta : float
        Tension and rigidity.
    gamma : float
        Resistance to motion.
    spacing : float
        Distance at which the points are kept [px]; at 0 they stay the same points, however far apart.
    """

    alpha: float
    beta: float
    gamma: float
    spacing: float


def moved(curve: Array, force: Force, elasticity: Elasticity, shape: tuple[int, ...]) -> Array:
    """A closed curve, shape (N, 2) [px], after one step, within an image of this shape."""
    wave = 2.0 - 2.0 * np.cos(2.0 * np.pi * np.arange(len(curve) // 2 + 1) / len(curve))
    matrix = elasticity.alpha * wave + elasticity.beta * wave**2 + elasticity.gamma
    right = elasticity.gamma * curve + force(curve)
    wanted = np.fft.irfft(np.fft.rfft(right, axis=0) / matrix[:, None], n=len(curve), axis=0)
    after: Array = curve + _FARTHEST * np.tanh(wanted - curve)
    return np.clip(after, 0.0, np.array(shape) - 1.0)


def evolution(
    curves: tuple[Array, ...], force: Force, elasticity: Elasticity, shape: tuple[int, ...], most_steps: int
) -> Iterator[CurveState]:
    """States of closed curves until all are at rest or have collapsed."""
    before = curves
    yield CurveState(curves=curves)
    for step in range(1, most_steps + 1):
        curves = tuple(_evened(moved(curve, force, elasticity, shape), elasticity.spacing) for curve in curves)
        left = tuple(curve for curve in curves if not _collapsed(curve))
        reason, rest = "", False
        if not left:
            reason = "the curve has collapsed"
        elif step % _EVERY == 0:
            rest = len(left) == len(before) and all(map(_close, left, before))
            reason, before = "the curve is at rest" if rest else "", left
        if step == most_steps and not reason:
            reason = f"stopped after {step} steps"
        curves = left
        yield CurveState(step, reason, rest, curves)
        if reason:
            return


def _evened(curve: Array, spacing: float) -> Array:
    """The curve with points at equal distances where they have become uneven."""
    if spacing <= 0.0:
        return curve
    path = np.concatenate([curve, curve[:1]])
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    if steps.min() >= _UNEVEN[0] * spacing and steps.max() <= _UNEVEN[1] * spacing:
        return curve
    return resampled(path, spacing)[:-1]


def _collapsed(curve: Array) -> bool:
    return len(curve) < _LEAST_POINTS or length(np.concatenate([curve, curve[:1]])) < _LEAST_LENGTH


def _close(curve: Array, before: Array) -> bool:
    """Whether all points of a curve lie near the line of another."""
    return bool(SegmentTree(before, np.roll(before, -1, axis=0)).distances(curve).max() < _REST)
