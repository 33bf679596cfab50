"""Level sets: contours that are the zero of a function on the pixels, which an equation moves.

A function phi is above 0 inside the contour. It follows::

    dphi/dt = a kappa |grad phi| + b |grad phi| - v . grad phi

with the curvature ``kappa = div(grad phi / |grad phi|)``, weights a and b, and a velocity v on the pixels. The first
term takes central differences, the second Godunov's, the third upwind differences (Osher and Sethian 1988,
doi:10.1016/0021-9991(88)90002-2). The function moves near the contour only, within `FRONT_BAND` of it, and is made a
signed distance again every few steps. Steps are as long as stability allows.

The geodesic active contour is short in a metric of edges; the geometric GVF contour, eq. (3), moves in the field of
gradient vector flow.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.edge_map import smoothed_gradient
from cpm_core.image.image import Image
from cpm_core.methods.method import (
    ContourMethod,
    ContourState,
    Settings,
    Start,
    declare_setting,
    iterate_until_at_rest,
    signed_region_distance,
    unit_edges,
)
from cpm_core.methods.snakes import even_out_field, gradient_vector_flow
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask, frozen

MAX_FRONT_STEPS = 4000
"""Largest number of steps of a front."""

FRONT_BAND = 6.0
"""Distance from the contour within which the function moves [px]."""

MAX_FRONT_DISTANCE = FRONT_BAND + 2.0
"""Distance at which the function is cut [px]."""

_UNREACHED_DISTANCE = 1e9
"""Distance of a pixel that no sweep has reached yet."""

_MAX_FRONT_STEP = 0.5
"""Largest distance that a front moves in a step [px]."""

_MAX_CURVATURE_STEP = 0.2
"""Largest product of time step and weight of the curvature."""

_REINITIALIZATION_INTERVAL = 5
"""Steps after which the function is made a signed distance again."""


def evolve_front(inside: Mask, curvature: Array, pressure: Array, velocity: Array) -> Iterator[ContourState]:
    """Evolve a front that begins around a region, shape (H, W), until it is at rest or vanishes.

    Weights of curvature and pressure have the shape (H, W), the velocity (2, H, W); see above.
    """
    drift = np.abs(pressure) + np.abs(velocity).sum(axis=0)
    fastest, most_curved = drift.max(), np.abs(curvature).max()
    time = min(_MAX_FRONT_STEP / max(fastest, 1e-9), _MAX_CURVATURE_STEP / max(most_curved, 1e-9))

    def iterate_functions() -> Iterator[Array]:
        """Yield the function after each step, shape (H, W) [px]."""
        phi = np.clip(signed_region_distance(inside), -MAX_FRONT_DISTANCE, MAX_FRONT_DISTANCE)
        for step in itertools.count(1):
            yield phi
            phi = advance_front(phi, curvature, pressure, velocity, time)
            if step % _REINITIALIZATION_INTERVAL == 0:
                phi = reinitialize_distance(phi)

    return iterate_until_at_rest(iterate_functions(), 0.0, MAX_FRONT_STEPS)


@compiled
def advance_front(phi: Array, curvature: Array, pressure: Array, velocity: Array, time: float) -> Array:
    """Advance the function, shape (H, W), by a time.

    `curvature` and `pressure` are the weights a and b, shape (H, W), `velocity` is v, shape (2, H, W) [px]. Beyond the
    border the function continues with its outermost values.
    """
    rows, width = phi.shape
    out = phi.copy()
    for row in range(rows):
        up, down = max(row - 1, 0), min(row + 1, rows - 1)
        for col in range(width):
            here = phi[row, col]
            if abs(here) > FRONT_BAND:
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
                    # a curvature above 1/px is noise of the grid
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
def _measure_next_to_zero(phi: Array, out: Array) -> NDArray[np.bool_]:
    """Find the pixels between which the sign changes, and write their distance from the zero to `out` [px]."""
    rows, width = phi.shape
    fixed, by = np.zeros(phi.shape, dtype=np.bool_), np.empty(2)
    for row in range(rows):
        for col in range(width):
            here, by[0], by[1] = phi[row, col], _UNREACHED_DISTANCE, _UNREACHED_DISTANCE
            for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
                r, c = row + down, col + right
                if 0 <= r < rows and 0 <= c < width and (phi[r, c] > 0.0) != (here > 0.0):
                    by[abs(right)] = min(by[abs(right)], abs(here) / max(abs(here - phi[r, c]), 1e-12))
            nearest = min(by[0], by[1])
            if by[0] < _UNREACHED_DISTANCE and by[1] < _UNREACHED_DISTANCE:
                nearest = by[0] * by[1] / max(np.sqrt(by[0] * by[0] + by[1] * by[1]), 1e-12)
            out[row, col], fixed[row, col] = nearest, nearest < _UNREACHED_DISTANCE
    return fixed


@compiled
def reinitialize_distance(phi: Array) -> Array:
    """Compute the signed distance from the zero of a function, shape (H, W), cut at `MAX_FRONT_DISTANCE` [px].

    Next to the zero the distance is that of a straight contour through the pixels between which the sign changes;
    elsewhere it solves ``|grad d| = 1`` by sweeps in four directions (Zhao 2005, doi:10.1090/S0025-5718-04-01678-3).
    """
    rows, width = phi.shape
    out = np.full(phi.shape, _UNREACHED_DISTANCE)
    fixed = _measure_next_to_zero(phi, out)
    for sweep in range(4):
        for i in range(rows):
            row = i if sweep % 2 == 0 else rows - 1 - i
            for j in range(width):
                col = j if sweep < 2 else width - 1 - j
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
            size = min(out[row, col], MAX_FRONT_DISTANCE)
            out[row, col] = size if phi[row, col] > 0.0 else -size
    return out


@frozen
class GeodesicSettings(Settings):
    """Parameters of the geodesic active contour.

    Attributes
    ----------
    balloon : float
        Constant pressure that drives it on: outwards, or inwards from around the object (w₀ of eq. (2)). Larger values
        drive the contour on faster, and over edges.
    curvature : float
        Weight of the curvature, which shortens the contour (w₁ of eq. (2)). Larger values keep the contour out of gaps,
        bays and noise.
    pull : float
        Weight of the pull back to edges that the contour has begun to cross. Larger values hold the contour on edges
        against the balloon; at 0 they only slow it down.
    exponent : float
        Exponent of the factor by which edges slow the contour down (m of eq. (2)). Larger values also stop the contour
        at weak edges and at noise; smaller ones let it cross them.
    contrast : float
        Edge strength that counts as an edge, as a fraction of the largest. Larger values let the contour cross weak
        edges.
    smoothing : float
        Width of the Gaussian that smooths the image before its edges are found [px]. Larger values remove noise and
        round corners.
    """

    balloon: float = declare_setting(0.3, -20.0, 20.0)
    curvature: float = declare_setting(0.2, 0.0, 20.0)
    pull: float = declare_setting(1.0, 0.0, 100.0)
    exponent: float = declare_setting(1.0, 0.1, 20.0)
    contrast: float = declare_setting(0.05, 1e-4, 10.0)
    smoothing: float = declare_setting(1.5, 0.0, 50.0)


def compute_stopping_factor(image: Image, settings: GeodesicSettings) -> Array:
    """Compute the factor that slows a contour down, shape (H, W), from 1 in flat regions to nearly 0 on edges."""
    strength = unit_edges(image, settings.smoothing) / settings.contrast
    return (1.0 + strength) ** -settings.exponent


def evolve_geodesic(image: Image, start: Start, settings: GeodesicSettings) -> Iterator[ContourState]:
    """Evolve the geodesic active contour."""
    factor = compute_stopping_factor(image, settings)
    pressure, velocity = (
        start.pressure_sign * settings.balloon * factor,
        -settings.pull * smoothed_gradient(factor, 0.0),
    )
    return evolve_front(start.mask(image.shape), settings.curvature * factor, pressure, velocity)


GEODESIC = ContourMethod(
    "geodesic",
    "Geodesic active contour",
    "A level set that edges slow down and pull back, with a balloon that drives it on.",
    "Caselles, Kimmel and Sapiro (1997), doi:10.1023/A:1007979827043",
    GeodesicSettings,
    evolve_geodesic,
)


@frozen
class GeometricGvfSettings(Settings):
    """Parameters of the geometric GVF contour.

    Attributes
    ----------
    mu : float
        How much the field is smoothed, against how closely it follows edges (gradient vector flow). Larger values carry
        the edges farther and even out noise.
    curvature : float
        Weight of the curvature, which shortens the contour (w of eq. (3)). Larger values keep the contour out of gaps,
        bays and noise.
    pressure : float
        Constant pressure that drives it on: outwards, or inwards from around the object. Larger values drive the
        contour over places where the field does not, and into gaps.
    evenness : float
        How far the vectors of the field are made equally long: from 0, as the equation gives them, to 1, all of the
        length 1. Larger values move the contour also far from edges, and hold it better against the pressure in gaps.
    smoothing : float
        Width of the Gaussian that smooths the image before its edges are found [px]. Larger values remove noise and
        round corners.
    """

    mu: float = declare_setting(0.02, 1e-4, 100.0)
    curvature: float = declare_setting(0.02, 0.0, 20.0)
    pressure: float = declare_setting(0.5, -20.0, 20.0)
    evenness: float = declare_setting(0.5, 0.0, 1.0)
    smoothing: float = declare_setting(2.0, 0.0, 50.0)


def evolve_geometric_gvf(image: Image, start: Start, settings: GeometricGvfSettings) -> Iterator[ContourState]:
    """Evolve the geometric GVF contour."""
    field = even_out_field(gradient_vector_flow(unit_edges(image, settings.smoothing), settings.mu), settings.evenness)
    curvature, pressure = (
        np.full(image.shape, weight, float) for weight in (settings.curvature, start.pressure_sign * settings.pressure)
    )
    return evolve_front(start.mask(image.shape), curvature, pressure, field)


GEOMETRIC_GVF = ContourMethod(
    "geometric_gvf",
    "Geometric GVF contour",
    "A level set that the field of gradient vector flow carries to edges; its contours can divide and merge.",
    "Xu, Yezzi and Prince (2000), doi:10.1109/ACSSC.2000.911003",
    GeometricGvfSettings,
    evolve_geometric_gvf,
)
