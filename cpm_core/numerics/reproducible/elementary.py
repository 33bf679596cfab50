"""Powers and exponentials of arrays by the C library, whose functions do not depend on vector registers."""

from __future__ import annotations

import math

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array

_WORTH_A_THREAD = 50_000
"""Numbers from which a second thread makes it faster."""


def power(values: Array, exponent: float) -> Array:
    r"""Each of the values, shape (\*shape), raised to a power; a root where it is one."""
    if exponent == 0.5:
        return np.asarray(np.sqrt(values))
    base = np.ascontiguousarray(values, dtype=float)
    out = np.empty(base.shape)
    share(lambda first, last: _power(base.ravel(), exponent, first, last, out.ravel()), base.size, _WORTH_A_THREAD)
    return out


def exponential(values: Array) -> Array:
    r"""Exponential of each of the values, shape (\*shape)."""
    given = np.ascontiguousarray(values, dtype=float)
    out = np.empty(given.shape)
    _exponential(given.ravel(), out.ravel())
    return out


@compiled
def _power(base: Array, exponent: float, first: int, last: int, out: Array) -> None:
    for n in range(first, last):
        out[n] = math.pow(base[n], exponent)


@compiled
def _exponential(given: Array, out: Array) -> None:
    for n in range(len(given)):
        out[n] = math.exp(given[n])
