"""Snakes: closed curves that are moved by forces of an image and kept smooth by forces of their own.

The points r of a curve follow ``gamma dr/dt = alpha r'' - beta r'''' + F(r)``. A step is implicit in the internal
forces of the curve and explicit in the force of the image, so that it is stable for any tension and rigidity (Kass,
Witkin and Terzopoulos 1988, appendix A). The matrix is circulant: it is inverted by Fourier transforms. The field of
gradient vector flow (Xu and Prince 1998) is the gradient of the edge map, extended into flat regions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import scipy
import skimage

from cpm_core.contours.contour import Contour
from cpm_core.field.edge_map import smoothed_gradient
from cpm_core.image.image import Image
from cpm_core.methods.method import (
    ContourMethod,
    ContourState,
    Settings,
    Start,
    declare_setting,
    unit_edges,
    unit_gray,
)
from cpm_core.numerics.polyline import path_length, resample_path, step_lengths
from cpm_core.numerics.segments import SegmentTree
from cpm_core.numerics.types import Array, Arrays, Extent, frozen

_FIELD_TOLERANCE = 1e-9
"""Residual of the equation of the field relative to its right side."""

_MAX_FIELD_ITERATIONS = 2000
"""Iterations after which the solution of the field is ended."""

_NEGLIGIBLE_LENGTH = 1e-10
"""Length of a vector, relative to the longest, below which it has no direction."""


def gradient_vector_flow(edges: Array, mu: float) -> Array:
    """Solve for the field of gradient vector flow of an edge map.

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
    preconditioner has the mean weight everywhere, so that cosine transforms invert it.
    """
    slope = smoothed_gradient(edges, 0.0)
    weight = (slope**2).sum(axis=0)
    if not weight.any():
        return np.zeros_like(slope)
    waves = [2.0 - 2.0 * np.cos(np.pi * np.arange(count) / count) for count in edges.shape]
    spectrum = weight.mean() + mu * (waves[0][:, None] + waves[1])

    def apply_equation(flat: Array) -> Array:
        v = flat.reshape(edges.shape)
        out = weight * v
        for axis in range(2):
            out -= mu * np.diff(v, axis=axis, n=2, prepend=v.take([0], axis), append=v.take([-1], axis))
        return out.ravel()

    def precondition_field(flat: Array) -> Array:
        return scipy.fft.idctn(scipy.fft.dctn(flat.reshape(edges.shape)) / spectrum).ravel()

    operator, preconditioner = (
        scipy.sparse.linalg.LinearOperator((edges.size, edges.size), act)
        for act in (apply_equation, precondition_field)
    )
    return np.stack(
        [
            scipy.sparse.linalg.cg(
                operator,
                (weight * part).ravel(),
                rtol=_FIELD_TOLERANCE,
                maxiter=_MAX_FIELD_ITERATIONS,
                M=preconditioner,
            )[0].reshape(edges.shape)
            for part in slope
        ]
    )


def even_out_field(field: Array, evenness: float = 1.0) -> Array:
    """Even out the lengths of a field, shape (2, H, W), whose longest vector gets the length 1.

    An `evenness` of 0 leaves the ratios of their lengths, 1 makes all lengths 1, except where the field is negligible.
    """
    size = np.hypot(*field)
    most = size.max(initial=0.0)
    if most == 0.0:
        return np.zeros_like(field)
    return field / most * np.maximum(size / most, _NEGLIGIBLE_LENGTH) ** -evenness


Force = Callable[[Array], Array]
"""Force at positions, shape (N, 2), shape (N, 2)."""

SNAKE_SPACING = 1.0
"""Distance at which the points of a curve are kept [px]."""

_MAX_POINT_STEP = 1.0
"""Largest distance that a point moves along an axis in a step [px]."""

_MIN_CURVE_POINTS = 8
"""Number of points below which a curve has collapsed."""

_MIN_CURVE_LENGTH = 8.0
"""Length below which a curve has collapsed [px]."""

_SPACING_RANGE = (0.5, 1.5)
"""Distances of neighbors, in units of the wanted one, beyond which a curve is sampled again."""

_MAX_SNAKE_STEPS = 2500
"""Steps after which a curve that is not at rest is left as it is."""

_CURVE_REST_INTERVAL = 20
"""Steps over which the motion of a curve is measured."""

_MAX_REST_MOTION = 0.1
"""Largest distance that a curve at rest moves over these steps [px]."""


@frozen
class Elasticity:
    """Internal forces of a curve: tension, rigidity, resistance to motion."""

    alpha: float
    beta: float
    gamma: float


def advance_curve(curve: Array, force: Force, elasticity: Elasticity, shape: Extent) -> Array:
    """Advance a closed curve, shape (N, 2) [px], by a step; it stays within the image."""
    wave = 2.0 - 2.0 * np.cos(2.0 * np.pi * np.arange(len(curve) // 2 + 1) / len(curve))
    matrix = elasticity.alpha * wave + elasticity.beta * wave**2 + elasticity.gamma
    right = elasticity.gamma * curve + force(curve)
    wanted = np.fft.irfft(np.fft.rfft(right, axis=0) / matrix[:, None], n=len(curve), axis=0)
    after = curve + _MAX_POINT_STEP * np.tanh(wanted - curve)
    return np.clip(after, 0.0, np.array(shape) - 1.0)


def evolve_curves(curves: Arrays, force: Force, elasticity: Elasticity, shape: Extent) -> Iterator[ContourState]:
    """Evolve closed curves, each of shape (N, 2) [px], until all are at rest or have collapsed."""
    before = curves
    yield _build_state(0, curves)
    for step in range(1, _MAX_SNAKE_STEPS + 1):
        paths = (_even_out_points(advance_curve(curve, force, elasticity, shape)) for curve in curves)
        curves = tuple(
            path[:-1] for path in paths if len(path) > _MIN_CURVE_POINTS and path_length(path) >= _MIN_CURVE_LENGTH
        )
        reason, at_rest = "", False
        if not curves:
            reason = "the curve has collapsed"
        elif step % _CURVE_REST_INTERVAL == 0:
            at_rest = len(curves) == len(before) and all(
                SegmentTree(former, np.roll(former, -1, axis=0)).distances_to(curve).max() < _MAX_REST_MOTION
                for curve, former in zip(curves, before, strict=True)
            )
            reason, before = "the curve is at rest" if at_rest else "", curves
        if step == _MAX_SNAKE_STEPS and not reason:
            reason = f"stopped after {step} steps"
        yield _build_state(step, curves, reason, at_rest)
        if reason:
            return


def _build_state(step: int, curves: Arrays, reason: str = "", at_rest: bool = False) -> ContourState:
    return ContourState(step, lambda: tuple(Contour(curve, closed=True) for curve in curves), reason, at_rest)


def _even_out_points(curve: Array) -> Array:
    """Return the path around a curve, sampled again where its points have become uneven."""
    path = np.concatenate([curve, curve[:1]])
    steps = step_lengths(path)
    if steps.min() >= _SPACING_RANGE[0] * SNAKE_SPACING and steps.max() <= _SPACING_RANGE[1] * SNAKE_SPACING:
        return path
    return resample_path(path, SNAKE_SPACING)


@frozen
class SnakeSettings(Settings):
    """Parameters of the classical snake.

    Attributes
    ----------
    alpha : float
        Weight of the tension, which shortens the curve (eq. (1)). Larger values shrink the curve faster, and also where
        there is no edge.
    beta : float
        Weight of the rigidity, which keeps the curve from bending (eq. (1)). Larger values round corners and keep the
        curve out of narrow bays.
    attraction : float
        Weight of the force of the image, which pulls the curve to edges (eq. (1)). Larger values pull harder, so that
        tension and rigidity count for less.
    smoothing : float
        Width of the Gaussian that smooths the image before its edges are found [px]. Larger values remove noise and
        round corners.
    """

    alpha: float = declare_setting(0.015, 0.0, 10.0)
    beta: float = declare_setting(0.1, 0.0, 1000.0)
    attraction: float = declare_setting(1.0, 0.0, 100.0)
    smoothing: float = declare_setting(2.0, 0.0, 50.0)


_SNAKE_RESISTANCE = 0.01


def build_edge_force(edges: Array, attraction: float) -> Force:
    """Build a force from the gradient of an edge map, shape (H, W), by quadratic splines between the pixels."""
    rows, cols = map(np.arange, edges.shape)
    surface = scipy.interpolate.RectBivariateSpline(rows, cols, attraction * edges, kx=2, ky=2, s=0)

    def interpolate_force(at: Array) -> Array:
        row, col = at.T
        return np.stack([surface(row, col, dx=1, grid=False), surface(row, col, dy=1, grid=False)], axis=1)

    return interpolate_force


def find_sobel_edges(image: Image, smoothing: float) -> Array:
    """Find edges, shape (H, W), by the Sobel filter, as scikit-image's ``active_contour`` does in smoothed images."""
    smooth = scipy.ndimage.gaussian_filter(unit_gray(image), smoothing, mode="nearest")
    return skimage.filters.sobel(smooth)  # type: ignore[no-untyped-call]


def evolve_snake(image: Image, start: Start, settings: SnakeSettings) -> Iterator[ContourState]:
    """Evolve the classical snake."""
    force = build_edge_force(find_sobel_edges(image, settings.smoothing), settings.attraction)
    elasticity = Elasticity(settings.alpha, settings.beta, _SNAKE_RESISTANCE)
    return evolve_curves(start.sample_curves(SNAKE_SPACING), force, elasticity, image.shape)


SNAKE = ContourMethod(
    "snake",
    "Classical snake",
    "A closed curve that is pulled up the slope of the edge map, and that tension and rigidity keep short and smooth.",
    "Kass, Witkin and Terzopoulos (1988), doi:10.1007/BF00133570; the forces of scikit-image's active_contour",
    SnakeSettings,
    evolve_snake,
)


@frozen
class GvfSnakeSettings(Settings):
    """Parameters of the GVF snake.

    Attributes
    ----------
    mu : float
        How much the field is smoothed, against how closely it follows edges (gradient vector flow). Larger values carry
        the edges farther and even out noise.
    alpha : float
        Weight of the tension, which shortens the curve (eq. (1)). Larger values keep the curve out of bays.
    beta : float
        Weight of the rigidity, which keeps the curve from bending (eq. (1)). Larger values round corners.
    attraction : float
        Weight of the field, whose vectors all have the length 1. Larger values move the curve faster, and overcome
        tension and rigidity.
    smoothing : float
        Width of the Gaussian that smooths the image before its edges are found [px]. Larger values remove noise and
        round corners.
    """

    mu: float = declare_setting(0.02, 1e-4, 100.0)
    alpha: float = declare_setting(0.0, 0.0, 10.0)
    beta: float = declare_setting(0.0, 0.0, 1000.0)
    attraction: float = declare_setting(0.6, 0.0, 100.0)
    smoothing: float = declare_setting(1.0, 0.0, 50.0)


def evolve_gvf_snake(image: Image, start: Start, settings: GvfSnakeSettings) -> Iterator[ContourState]:
    """Evolve the GVF snake."""
    field = even_out_field(gradient_vector_flow(unit_edges(image, settings.smoothing), settings.mu))
    elasticity = Elasticity(settings.alpha, settings.beta, 1.0)

    def interpolate_force(at: Array) -> Array:
        sampled = (scipy.ndimage.map_coordinates(part, at.T, order=1, mode="nearest") for part in field)
        return settings.attraction * np.stack([*sampled], axis=1)

    return evolve_curves(start.sample_curves(SNAKE_SPACING), interpolate_force, elasticity, image.shape)


GVF_SNAKE = ContourMethod(
    "gvf",
    "GVF snake",
    "A closed curve in the field of gradient vector flow, which carries the edges far into flat regions.",
    "Xu and Prince (1998), doi:10.1109/83.661186",
    GvfSnakeSettings,
    evolve_gvf_snake,
)
