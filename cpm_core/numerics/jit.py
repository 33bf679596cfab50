"""How the inner loops of the model are compiled: cached on disk, free of the interpreter's lock, vectorized.

The loops compute in the order in which they are written and round after each operation, so that every processor gives
the same bits, whatever the width of its vector registers. A long sum needs a fixed order that these can follow: see
`lanes`. Where no contour depends on the last bits, `reordered` lets the compiler choose the order. No loop assumes that
values are finite. None starts threads of its own: a caller that wants two cores splits the work, so that two callers
never meet inside one parallel region.

Loops return plain tuples to Python, never named ones: a signal that raises, as Ctrl+C does, may arrive whenever Python
code runs, and ends the process if that is while Numba makes a named tuple.

Do not assign an array to a slice of another in a loop: Numba then also compiles the error message for shapes that do
not fit, which takes three seconds. Assign the elements one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any, TypeVar, cast

import numba
from numba.core import serialize, types

from cpm_core.numerics.loop_cache.kept_loop import kept_loop

_Function = TypeVar("_Function", bound=Callable[..., Any])


serialize._numba_unpickle = lru_cache(maxsize=None)(serialize._numba_unpickle)
"""How a loop finds the class of an array that it returns, without a line of Python after the first time: Numba goes on
without the class, and the process may end, if Ctrl+C or another signal raises there."""

_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"nsz"},
    "no_cfunc_wrapper": True,  # it would be compiled with each loop, and only other languages call it
}
_REORDERED: dict[str, Any] = _OPTIONS | {"fastmath": {"reassoc", "contract", "arcp", "nsz"}}


def compiled(function: _Function) -> _Function:
    """Compile a loop over arrays on its first call."""
    return cast(_Function, _kept(numba.njit(**_OPTIONS)(function), function))


def reordered(function: _Function) -> _Function:
    """Compile a loop that may reorder sums and approximate reciprocals: faster, with other last bits elsewhere."""
    return cast(_Function, _kept(numba.njit(**_REORDERED)(function), function))


def inlined(function: _Function) -> _Function:
    """Compile a short function as a part of each loop that calls it.

    A call passes every array and counts its references, which takes tens of nanoseconds: inlining pays where the
    function itself takes no longer. It is compiled again at every place that calls it, so call it in one loop.
    """
    return cast(_Function, _kept(numba.njit(inline="always", **_OPTIONS)(function), function))


def _kept(loop: Any, function: Callable[..., Any]) -> Any:
    """A loop that is cached on disk, where that is possible; the function itself where nothing is compiled."""
    if hasattr(loop, "py_func"):
        loop.get_call_template = partial(_call_template, loop.get_call_template)
        if (cache := kept_loop(function)) is not None:
            loop._cache = cache
    return loop


def _call_template(found: Callable[..., Any], args: Sequence[Any], kws: Mapping[str, Any]) -> Any:
    """How a loop calls another: as with any number, where Numba would compile it again for each constant."""
    return found([types.unliteral(arg) for arg in args], {name: types.unliteral(arg) for name, arg in kws.items()})
