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

from cpm_core.kernel_cache import kept_with_the_sources

_Function = TypeVar("_Function", bound=Callable[..., Any])


def compiled(function: _Function) -> _Function:
    """Compile a loop over arrays on its first call."""
    decorate = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "arcp", "nsz"})
    with kept_with_the_sources():
        return cast(_Function, decorate(function))
