"""Snakes: closed curves that forces of an image move and forces of their own keep smooth.

The points r of a curve follow ``gamma dr/dt = alpha r'' - beta r'''' + F(r)``. A step takes the forces of the curve
itself at its end and that of the image at its beginning, so that it is stable for any tension and rigidity (Kass,
Witkin and Terzopoulos 1988, appendix A). The matrix is circulant: it is inverted by Fourier transforms. The field of
gradient vector flow (Xu and Prince 1998) is the gradient of the edge map, extended into flat regions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from cpm_core.field.edge_map import gradient
from cpm_core.image.image import Image
from cpm_core.numerics.polyline import length, resampled
from cpm_core.numerics.segments import SegmentTree
from cpm_core.numerics.types import Array
from cpm_core.objects.methods.gray import sobel_edges, unit_edges
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import CurveState

_EXACT = 1e-9
"""Residual of the equation relative to its right side."""

_MOST_ROUNDS = 2000

_DAMPING, _SWEEPS, _COARSEST = 0.8, 2, 4
"""Of the relaxation on each grid: damping, sweeps before and after the coarser grids; pixels of the last grid."""

_NEGLIGIBLE = 1e-10
"""Length of a vector, relative to the longest, under which it has no direction."""


def gradient_vector_flow(edges: Array, mu: float) -> Array:
    """The field of gradient vector flow of an edge map.

    Parameters
    ----------
    edges : ndarray, shape (H, W)
        Edge map f with values from 0 to 1.
    mu : float
        Weight of the smoothness of the field, above 0.

    Returns
    -------
    ndarray, shape (2, H, W)
        The field v along rows and columns: the stationary solution of ``mu laplace(v) = |grad f|^2 (v - grad f)``,
        eq. (12) of Xu and Prince (1998), doi:10.1109/83.661186, that they approach by an iteration. The derivative
        across the border is 0.

    Notes
    -----
    The equation is linear and its matrix symmetric and positive definite. It is solved by conjugate gradients; the
    preconditioner is one cycle of a multigrid.
    """
    slope = gradient(edges, 0.0)
    weight = (slope**2).sum(axis=0)
    if not weight.any():
        return np.zeros_like(slope)
    preconditioner = _multigrid(weight, mu)
    operator = scipy.sparse.linalg.LinearOperator(
        (edges.size, edges.size), lambda v: _applied(v.reshape(edges.shape), weight, mu).ravel()
    )
    return np.stack([_solved(operator, preconditioner, weight * part) for part in slope])


def evened(field: Array, evenness: float = 1.0) -> Array:
    """A field, shape (2, H, W), whose longest vector has the length 1, with vectors of more equal lengths.

    An `evenness` of 0 leaves the ratios of their lengths, 1 makes all lengths 1, except where the field is negligible.
    """
    size = np.hypot(*field)
    most = float(size.max(initial=0.0))
    if most == 0.0:
        return np.zeros_like(field)
    return np.asarray(field / most * np.maximum(size / most, _NEGLIGIBLE) ** -evenness)


def _solved(operator: Any, preconditioner: Any, right: Array) -> Array:
    found, _ = scipy.sparse.linalg.cg(operator, right.ravel(), rtol=_EXACT, maxiter=_MOST_ROUNDS, M=preconditioner)
    return np.asarray(found).reshape(right.shape)


def _applied(v: Array, weight: Array, mu: float) -> Array:
    """``weight v - mu laplace(v)``, with the outermost pixels repeated beyond the border."""
    out: Array = weight * v
    for axis in range(2):
        step = mu * np.diff(v, axis=axis)
        first, last = (slice(None),) * axis, (slice(None),) * axis
        out[(*first, slice(None, -1))] -= step
        out[(*last, slice(1, None))] += step
    return out


def _multigrid(weight: Array, mu: float) -> Any:
    """About the inverse of ``weight v - mu laplace(v)``: a symmetric cycle over grids, each of half the size."""
    weights = [weight]
    while min(weights[-1].shape) > 1 and weights[-1].size > _COARSEST:
        weights.append(_summed(weights[-1]))

    def cycle(right: Array, level: int) -> Array:
        weight = weights[level]
        relaxation = _DAMPING / (weight + mu * _neighbors(weight.shape))
        v: Array = relaxation * right
        for _ in range(_SWEEPS - 1):
            v += relaxation * (right - _applied(v, weight, mu))
        if level + 1 < len(weights):
            coarse = cycle(_summed(right - _applied(v, weight, mu)), level + 1)
            v += np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)[: v.shape[0], : v.shape[1]]
        for _ in range(_SWEEPS):
            v += relaxation * (right - _applied(v, weight, mu))
        return v

    return scipy.sparse.linalg.LinearOperator(
        (weight.size, weight.size), lambda v: cycle(v.reshape(weight.shape), 0).ravel()
    )


def _summed(values: Array) -> Array:
    """Sums over blocks of two by two pixels; the last blocks of an odd side are smaller."""
    for axis in range(2):
        values = np.add.reduceat(values, np.arange(0, values.shape[axis], 2), axis=axis)
    return values


def _neighbors(shape: tuple[int, ...]) -> Array:
    """Number of neighbors of each pixel."""
    sides = [np.full(count, 2.0) for count in shape]
    for side in sides:
        side[0] -= 1.0
        side[-1] -= 1.0
    return np.asarray(sides[0][:, None] + sides[1][None, :])


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


_SNAKE_STEPS = 2500


@dataclass(frozen=True)
class SnakeSettings(Settings):
    """Parameters of the classical snake."""

    alpha: float = number(
        0.015, "α", "Tension", "Weight of the tension, which shortens the curve.",
        "More of it shrinks the curve faster, and also where there is no edge.",
        (0.0, 10.0), (0.0, 0.2), 0.005, equation="eq. (1)",
    )  # fmt: skip
    beta: float = number(
        0.1, "β", "Rigidity", "Weight of the rigidity, which keeps the curve from bending.",
        "More of it rounds corners and keeps the curve out of narrow bays.",
        (0.0, 1000.0), (0.0, 10.0), 0.05, equation="eq. (1)",
    )  # fmt: skip
    attraction: float = number(
        1.0, "w", "Attraction", "Weight of the force of the image, which pulls the curve to edges.",
        "More of it pulls harder, so that tension and rigidity count for less.",
        (0.0, 100.0), (0.0, 5.0), 0.1, equation="eq. (1)",
    )  # fmt: skip
    gamma: float = number(
        0.01, "γ", "Resistance", "How much the curve resists being moved.",
        "More of it makes the steps smaller.", (1e-4, 100.0), (0.001, 0.5), 0.001, advanced=True,
    )  # fmt: skip
    smoothing: float = number(
        2.0, "σ", "Smoothing", "Width of the Gaussian that smooths the image before its edges are found.",
        "More of it attracts the curve from farther away, and rounds corners.",
        (0.0, 50.0), (0.5, 10.0), 0.5, "px",
    )  # fmt: skip
    spacing: float = number(
        1.0, "h", "Spacing", "Distance at which the points of the curve are kept; at 0 they stay the same points.",
        "More of it gives a coarser curve.", (0.0, 20.0), (0.0, 5.0), 0.5, "px", advanced=True,
    )  # fmt: skip


def edge_force(edges: Array, attraction: float) -> Force:
    """The gradient of an edge map, shape (H, W), as a force: pieces of quadratic polynomials between the pixels."""
    rows, cols = edges.shape
    surface = scipy.interpolate.RectBivariateSpline(
        np.arange(rows), np.arange(cols), attraction * edges, kx=2, ky=2, s=0
    )

    def force(at: Array) -> Array:
        row, col = at.T
        return np.stack([surface(row, col, dx=1, grid=False), surface(row, col, dy=1, grid=False)], axis=1)

    return force


def _snake(image: Image, start: Start, settings: SnakeSettings) -> Iterator[CurveState]:
    force = edge_force(sobel_edges(image, settings.smoothing), settings.attraction)
    elasticity = Elasticity(settings.alpha, settings.beta, settings.gamma, settings.spacing)
    curves = start.curves(settings.spacing or 1.0)
    yield from evolution(curves, force, elasticity, image.shape, _SNAKE_STEPS)


SNAKE = ContourMethod(
    "snake",
    "Classical snake",
    "A closed curve that is pulled up the slope of the edge map, and that tension and rigidity keep short and smooth.",
    "Kass, Witkin and Terzopoulos (1988), doi:10.1007/BF00133570; the forces of scikit-image's active_contour",
    SnakeSettings,
    _snake,
    _SNAKE_STEPS,
)


_GVF_STEPS = 2000


@dataclass(frozen=True)
class GvfSnakeSettings(Settings):
    """Parameters of the GVF snake."""

    mu: float = number(
        0.02, "μ", "Smoothness of the field", "How much the field is smoothed, against how closely it follows edges.",
        "More of it carries the edges farther and evens out noise.",
        (1e-4, 100.0), (0.01, 1.0), 0.01, equation="gradient vector flow",
    )  # fmt: skip
    alpha: float = number(
        0.0, "α", "Tension", "Weight of the tension, which shortens the curve.",
        "More of it keeps the curve out of bays.", (0.0, 10.0), (0.0, 1.0), 0.01, equation="eq. (1)",
    )  # fmt: skip
    beta: float = number(
        0.0, "β", "Rigidity", "Weight of the rigidity, which keeps the curve from bending.",
        "More of it rounds corners.", (0.0, 1000.0), (0.0, 5.0), 0.05, equation="eq. (1)",
    )  # fmt: skip
    attraction: float = number(
        0.6, "κ", "Attraction", "Weight of the field, whose vectors all have the length 1.",
        "More of it moves the curve faster, and overcomes tension and rigidity.",
        (0.0, 100.0), (0.0, 3.0), 0.05,
    )  # fmt: skip
    smoothing: float = number(
        1.0, "σ", "Smoothing", "Width of the Gaussian that smooths the image before its edges are found.",
        "More of it removes noise and rounds corners.", (0.0, 50.0), (0.5, 8.0), 0.5, "px",
    )  # fmt: skip
    spacing: float = number(
        1.0, "h", "Spacing", "Distance at which the points of the curve are kept.",
        "More of it gives a coarser curve.", (0.2, 20.0), (0.5, 5.0), 0.5, "px", advanced=True,
    )  # fmt: skip


def field_force(field: Array, attraction: float) -> Force:
    """A field on the pixels, shape (2, H, W), as a force, linear between the pixels."""

    def force(at: Array) -> Array:
        parts = [scipy.ndimage.map_coordinates(part, at.T, order=1, mode="nearest") for part in field]
        return attraction * np.stack(parts, axis=1)

    return force


def _gvf_snake(image: Image, start: Start, settings: GvfSnakeSettings) -> Iterator[CurveState]:
    field = evened(gradient_vector_flow(unit_edges(image, settings.smoothing), settings.mu))
    elasticity = Elasticity(settings.alpha, settings.beta, 1.0, settings.spacing)
    force = field_force(field, settings.attraction)
    yield from evolution(start.curves(settings.spacing), force, elasticity, image.shape, _GVF_STEPS)


GVF_SNAKE = ContourMethod(
    "gvf",
    "GVF snake",
    "A closed curve in the field of gradient vector flow, which carries the edges far into flat regions.",
    "Xu and Prince (1998), doi:10.1109/83.661186",
    GvfSnakeSettings,
    _gvf_snake,
    _GVF_STEPS,
)
