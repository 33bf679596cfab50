"""Compilation of the inner loops of the model: cached on disk, free of the interpreter's lock, vectorized.

The loops compute in the order in which they are written and round after each operation. Where no contour depends on the
last bits, `reordered` lets the compiler choose the order. No loop assumes that values are finite. None starts threads
of its own: a caller that wants two cores splits the work, so that two callers never meet inside one parallel region.

Numba keeps compiled loops in a cache folder and compiles one again when its own file changes. After a change to a loop
that others call, remove the `__pycache__` folders, or the folder that ``NUMBA_CACHE_DIR`` names.

Do not assign an array or a tuple to a part of an array in a loop: Numba then also compiles the error message for shapes
that do not fit, which takes two seconds. Assign the elements one by one. What makes an array, `np.empty` as well, is
compiled for each kernel, in a tenth of a second: let the caller make it.
"""

from __future__ import annotations

import gc
import logging
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, cached_property, update_wrapper
from typing import Any, TypeVar

from cpm_core.numerics.types import Callback

Function = TypeVar("Function", bound=Callable[..., Any])

_LOG = logging.getLogger(__name__)

_NUMBA_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,  # it would be compiled with each kernel, and only other languages call it
}
"""Options of every kernel."""


@cache
def _numba() -> Any:
    """Import Numba, and pause the garbage collector while it compiles, which would search all of Numba many times."""
    import numba  # takes a third of the time of all imports
    from numba.core import event

    was_enabled: list[bool] = []

    class Pause(event.Listener):
        def on_start(self, event: Any) -> None:
            _announce()
            was_enabled.append(gc.isenabled())
            gc.disable()

        def on_end(self, event: Any) -> None:
            if was_enabled.pop():  # not within the compilation of a kernel that calls this one
                gc.enable()
            for thread, tell in () if was_enabled else tuple(_told):
                if thread == threading.get_ident():
                    tell()

    event.register("numba:compile", Pause())
    return numba


_told: list[tuple[int, Callback]] = []
"""Threads, and functions to call whenever one of them has compiled a kernel."""


@contextmanager
def tell_compiled(tell: Callback) -> Iterator[None]:
    """Call a function whenever this thread has compiled a kernel; what others compile meanwhile does not count."""
    _told.append(entry := (threading.get_ident(), tell))
    try:
        yield
    finally:
        _told.remove(entry)


@cache
def _announce() -> None:
    _LOG.info("Inner loops are compiled for this computer, once, which takes ten to twenty seconds.")


class _LazyKernel:
    """Function that imports Numba and compiles itself on its first use; Numba accepts it as its own.

    What Python calls is kept in the cache. What kernels call becomes a part of them: it needs neither a place there nor
    the code that takes arguments from Python, which is as long as a short kernel.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self._options = options | _NUMBA_OPTIONS

    @cached_property
    def _called(self) -> Any:
        from cpm_core.numerics.loop_cache import keep_compiled

        return keep_compiled(_numba().njit(**self._options)(self.__wrapped__))

    @cached_property
    def _part(self) -> Any:
        return _numba().njit(no_cpython_wrapper=True, **self._options)(self.__wrapped__)

    def __call__(self, *arguments: Any) -> Any:
        return self._called(*arguments)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._part if name == "_numba_type_" else self._called, name)


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
