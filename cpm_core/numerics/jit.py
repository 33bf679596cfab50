"""How the inner loops of the model are compiled: cached on disk, free of the interpreter's lock, vectorised.

The loops may reorder sums (so that they run on vector registers) but never assume that values are finite; the same
input gives the same bits at every call. No loop starts threads of its own: a caller that wants two cores splits the
work, so that two callers can never meet inside one parallel region.

A loop that assigns an array to a part of another costs three seconds of compiling, for Numba then compiles as well how
the two shapes are put into words if they do not fit: element by element it costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from cpm_core.numerics.jit_cache import kept_with_the_sources

_Function = TypeVar("_Function", bound=Callable[..., Any])


_OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "arcp", "nsz"},
}


def compiled(function: _Function) -> _Function:
    """Compile a loop over arrays on its first call."""
    with kept_with_the_sources():
        return cast(_Function, numba.njit(**_OPTIONS)(function))


def inlined(function: _Function) -> _Function:
    """Compile a short function as a part of each loop that calls it.

    A call hands over every array, and counts it up and down, which takes tens of nanoseconds; that is worth sparing
    where a function takes no longer itself. It is compiled anew at every place that calls it: have one in a loop.
    """
    with kept_with_the_sources():
        return cast(_Function, numba.njit(inline="always", **_OPTIONS)(function))
