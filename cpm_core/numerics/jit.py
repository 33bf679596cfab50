"""Compilation of the inner loops of the model: cached on disk, free of the interpreter's lock, vectorized.

The loops compute in the order in which they are written and round after each operation. Where no contour depends on the
last bits, `reordered` lets the compiler choose the order. No loop assumes that values are finite. None starts threads
of its own: a caller that wants two cores splits the work, so that two callers never meet inside one parallel region.

Numba keeps compiled loops in a cache folder and compiles one again when its own file changes. After a change to a loop
that others call, remove the `__pycache__` folders, or the folder that ``NUMBA_CACHE_DIR`` names.

Do not assign an array to a slice of another in a loop: Numba then also compiles the error message for shapes that do
not fit, which takes three seconds. Assign the elements one by one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import update_wrapper
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_NUMBA_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,  # it would be compiled with each kernel, and only other languages call it
}
"""Options of every kernel."""


class _LazyKernel:
    """Function that imports Numba and compiles itself on its first use; Numba accepts it as its own."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self._options, self._compiled = options, None

    def _compile(self) -> Any:
        """Compile the function and keep the result."""
        import numba  # takes a third of the time of all imports

        made = numba.njit(cache=True, **self._options, **_NUMBA_OPTIONS)(self.__wrapped__)
        self._compiled = self._compiled or made  # of two threads the first one decides
        return self._compiled

    def __call__(self, *arguments: Any) -> Any:
        return (self._compiled or self._compile())(*arguments)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._compiled or self._compile(), name)


def _make_decorator(**options: Any) -> Callable[[Function], Function]:
    """Make a decorator that compiles on the first call and stores the result in Numba's cache."""
    return lambda function: _LazyKernel(function, options)  # type: ignore[return-value]


compiled = _make_decorator(fastmath={"nsz"})
"""Compile a kernel over arrays on its first call."""

reordered = _make_decorator(fastmath={"reassoc", "contract", "arcp", "nsz"})
"""Compile a kernel that may reorder sums and approximate reciprocals: faster, with other last bits elsewhere."""

inlined = _make_decorator(fastmath={"nsz"}, inline="always")
"""Compile a short function as a part of each kernel that calls it.

A call passes every array and counts its references, which takes tens of nanoseconds: inlining pays where the function
itself takes no longer. It is compiled again at every place that calls it, so call it in one kernel.
"""
