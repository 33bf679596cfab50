"""The field of gradient vector flow (Xu and Prince 1998): the gradient of the edge map, extended into flat regions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from cpm_core.field.edge_map import gradient
from cpm_core.numerics.types import Array

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


def _operator(shape: tuple[int, ...], work: Callable[[Array], Array]) -> Any:
    """A linear function of arrays of a shape, as SciPy takes it."""
    size = int(np.prod(shape))
    return scipy.sparse.linalg.LinearOperator((size, size), lambda v: work(v.reshape(shape)).ravel())


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
