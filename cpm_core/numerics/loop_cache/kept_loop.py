"""Kept loops: the cache of one compiled loop, which no fault of its files or its disk stops.

Numba's own cache raises what it meets: a file that was cut short, a disk that is full, a folder without permission.
Then every later run fails as well; and two processes that keep the same loop at once may leave an index that names the
code of another signature. Here each signature has a file of its own, which ends with its hash, since code with a wrong
byte would be executed. A file that cannot be read is dropped and the loop compiled again, and a loop that cannot be
kept is compiled without being kept.
"""

from __future__ import annotations

import hashlib
import logging
import pickle
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.serialize import dumps

from cpm_core.numerics.loop_cache import elsewhere, folders
from cpm_core.numerics.loop_cache.shipped import Target, shipped
from cpm_core.numerics.loop_cache.versions import module_of

_LOG = logging.getLogger(__name__)

_HASH = hashlib.sha256
_LENGTH = _HASH().digest_size

_LOOK_EVERY = 0.05
"""Interval at which a loop is looked for that another process compiles [s]."""


def kept_loop(function: Callable[..., Any]) -> KeptLoop | None:
    """Cache of a loop; None where it can neither be kept nor is brought by the program."""
    brought, (package, kept) = shipped(), folders.of_module(module_of(function))
    first = _ShippedLoop(function, package, brought.target) if package is not None and brought is not None else None
    if kept is None:
        return first
    folders.in_use(kept)
    return KeptLoop(function, kept, first)


class KeptLoop(FunctionCache):
    """Cache of a loop in a folder, which may be there already; in place of Numba's own, whose methods it has.

    `first` is looked into before it.
    """

    def __init__(self, function: Callable[..., Any], folder: Path, first: KeptLoop | None = None) -> None:
        self._name = repr(function)
        self._py_func = function
        self._first = first
        self._impl = _Content()
        self._cache_path = str(folder)
        self._folder = folder
        self._cache_file: Any = _Files(folder, function.__qualname__.replace("<", "").replace(">", ""))
        self.enable()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Code for a signature; None when there is none, or none that can be read."""
        found = self._loaded(sig, target_context)
        while found is None and elsewhere.is_compiling():
            time.sleep(_LOOK_EVERY)
            found = self._loaded(sig, target_context)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep code for a signature, if that is possible."""
        try:
            if not self._folder.is_dir():
                self._folder.mkdir(parents=True, exist_ok=True)
                folders.remove_unused(self._folder.parent)
            if self._impl.check_cachable(data):
                self._cache_file.save(self._index_key(sig, data.codegen), self._impl.reduce(data))
        except OSError as error:
            _LOG.info("%s is not kept: %s", self._name, error)

    def _loaded(self, sig: Any, target_context: Any) -> Any:
        found = self._first.load_overload(sig, target_context) if self._first is not None else None
        if found is not None:
            return found
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # what a damaged file raises cannot be foreseen
            _LOG.info("%s: %s: %s", self._name, type(error).__name__, error)
            with suppress(OSError):
                self._cache_file.drop(self._index_key(sig, target_context.codegen()))
            return None


class _ShippedLoop(KeptLoop):
    """A loop that the program brings compiled; nothing is ever written."""

    def __init__(self, function: Callable[..., Any], folder: Path, target: Target) -> None:
        super().__init__(function, folder)
        self._target = target

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Code for a signature; None when there is none, or none that can be read."""
        try:
            return FunctionCache.load_overload(self, sig, target_context)
        except Exception as error:  # as above
            _LOG.info("%s: %s: %s", self._name, type(error).__name__, error)
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep nothing."""

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        sig, _, function = super()._index_key(sig, codegen)
        return sig, tuple(self._target), function


class _Content(CompileResultCacheImpl):
    """What is kept of a compiled loop; the folder is known, so that no place for it is looked for."""

    def __init__(self) -> None: ...

    def reduce(self, data: Any) -> Any:
        """All but the text for people, which names files of this computer."""
        return tuple("" if isinstance(part, str) else part for part in super().reduce(data))

    def check_cachable(self, data: Any) -> bool:
        """Whether code may be kept: not if it holds addresses of this process."""
        return not (data.library.has_dynamic_globals or any(not loop.can_cache for loop in data.lifted))


class _Files:
    """The files of a loop, one for each signature. Each is written aside and holds the signature that it is for."""

    def __init__(self, folder: Path, name: str) -> None:
        self._folder = folder
        self._name = name

    def load(self, key: Any) -> Any:
        """Content for a key; None when there is none, `ValueError` when it is damaged."""
        path = self._path(key)
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            return None
        if _HASH(content[:-_LENGTH]).digest() != content[-_LENGTH:]:
            raise ValueError(f"{path.name} is damaged")
        made_for, data = pickle.loads(content)
        return data if made_for == key else None

    def save(self, key: Any, data: Any) -> None:
        """Write the content for a key."""
        content = dumps((key, data))
        aside = self._folder / f"{uuid.uuid4().hex}.tmp"
        try:
            aside.write_bytes(content + _HASH(content).digest())
            aside.replace(self._path(key))
        finally:
            aside.unlink(missing_ok=True)

    def drop(self, key: Any) -> None:
        """Remove the content for a key."""
        self._path(key).unlink(missing_ok=True)

    def _path(self, key: Any) -> Path:
        return self._folder / f"{self._name}-{_HASH(repr(key).encode()).hexdigest()[:16]}{folders.SUFFIX}"
