"""Memory of a window that is used for hours: what is free within the process is given back while nothing goes on.

Runs make and drop many arrays of different sizes, and the C library keeps the gaps between those that stay. A window
that is used for hours would take more and more memory for the same work.

PySide looks at the source of each module that is imported beside it, and Python keeps the lines of all of them for
tracebacks, some twenty megabytes and more; it reads again those that a traceback needs.
"""

from __future__ import annotations

import ctypes
import gc
import linecache
from collections.abc import Callable
from functools import cache

_MOST_ARENAS = -8
"""What the C library of GNU calls the number of parts of memory among which it spreads the threads."""


def share_one_arena() -> None:
    """Let all threads take memory from the same part, where the C library can; to be called before threads begin.

    What one of them frees, another takes then. With a part for each thread, all keep the gaps between what stays.
    """
    choose = _of_the_library("mallopt")
    if choose is not None:
        choose(_MOST_ARENAS, 1)


def give_back() -> None:
    """Give free memory back to the system, where its C library can."""
    linecache.clearcache()
    trim = _of_the_library("malloc_trim")
    if trim is not None:
        trim(0)


@cache
def keep_loaded(volumes: bool) -> None:
    """Let no search for garbage go through what is loaded by now, which would delay the window by several frames.

    Once for images and once for volumes, since what else there is at that moment is never searched either: done with
    every volume that is opened, this would keep each of them.
    """
    gc.freeze()


@cache
def _of_the_library(name: str) -> Callable[..., int] | None:
    """A function of the C library of GNU; None where there is another."""
    try:
        found: Callable[..., int] = getattr(ctypes.CDLL(None), name)
    except (OSError, TypeError, AttributeError):
        return None
    return found
