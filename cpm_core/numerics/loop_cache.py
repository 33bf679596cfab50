"""Numba's cache of compiled loops, of which neither a power cut nor a full disk ends a run."""

from __future__ import annotations

import logging
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache

_LOG = logging.getLogger(__name__)


class LoopCache(FunctionCache):
    """Numba's cache, which compiles again what it cannot read and goes on without what it cannot write."""

    def load_overload(self, *which: Any) -> Any:
        """Return a compiled loop; None, so that it is compiled, where none can be read."""
        try:
            return super().load_overload(*which)
        except Exception:  # to unpickle a damaged file may raise anything
            self._forget()
            _warn_once("The cache of compiled loops is damaged: they are compiled again.")

    def save_overload(self, *which: Any) -> None:
        """Keep a compiled loop for the next start, where the disk takes it."""
        try:
            super().save_overload(*which)
        except Exception as error:  # the index is read first
            self._forget()
            reason = getattr(error, "strerror", None) or type(error).__name__
            _warn_once(f"Compiled loops cannot be kept ({reason}): {_COST} Free space, or {_REMEDY}")

    def _forget(self) -> None:
        """Remove the index, which may name a file that is damaged, or older than the index."""
        with suppress(OSError):
            Path(self._cache_file._index_path).unlink(missing_ok=True)


_COST = "each start compiles them again."
_REMEDY = "name another folder in NUMBA_CACHE_DIR."


def keep_compiled(kernel: Any) -> Any:
    """Let a kernel of Numba keep what it compiles for the next start, where a folder can be written."""
    try:
        kernel._cache = LoopCache(kernel.py_func)
    except RuntimeError:  # none of Numba's folders
        _warn_once(f"No folder for compiled loops can be written: {_COST} To keep them, {_REMEDY}")
    return kernel


@cache
def _warn_once(sentence: str) -> None:
    _LOG.warning(sentence)
