"""How the inner loops of the model are compiled: cached on disk, free of the interpreter's lock, vectorized.

The loops may reorder sums, so that they run on vector registers, but never assume that values are finite. The same
input gives the same bits at every call. No loop starts threads of its own: a caller that wants two cores splits the
work, so that two callers never meet inside one parallel region.

Do not assign an array to a slice of another in a loop: Numba then also compiles the error message for shapes that do
not fit, which takes three seconds. Assign the elements one by one.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar, cast

import numba

from cpm_core.numerics.jit_cache import cached_by_version
from cpm_core.numerics.kept_loops import KeptLoop

_Function = TypeVar("_Function", bound=Callable[..., Any])


_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "arcp", "nsz"},
}


def compiled(function: _Function) -> _Function:
    """Compile a loop over arrays on its first call."""
    return cast(_Function, _kept(numba.njit(**_OPTIONS)(function), function))


def inlined(function: _Function) -> _Function:
    """Compile a short function as a part of each loop that calls it.

    A call passes every array and counts its references, which takes tens of nanoseconds: inlining pays where the
    function itself takes no longer. It is compiled again at every place that calls it, so call it in one loop.
    """
    return cast(_Function, _kept(numba.njit(inline="always", **_OPTIONS)(function), function))


def _kept(loop: Any, function: Callable[..., Any]) -> Any:
    """A loop that is cached on disk, where that is possible; the function itself where nothing is compiled."""
    if hasattr(loop, "py_func"):
        with cached_by_version(), suppress(RuntimeError, OSError):  # no folder can be written to
            loop._cache = KeptLoop(function)
    return loop
