"""Kept loops: the cache of one compiled loop, which no fault of its files or its disk stops.

Numba's own cache raises what it meets: a file that was cut short, a disk that is full, a folder without permission.
Then every later run fails as well. Here a file that cannot be read is dropped and the loop compiled again, and a loop
that cannot be kept is compiled without being kept. Each file of code ends with its hash, since code with a wrong byte
would be executed.
"""

from __future__ import annotations

import hashlib
import logging
from contextlib import suppress
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile

_LOG = logging.getLogger(__name__)

_HASH = hashlib.sha256
_LENGTH = _HASH().digest_size


class KeptLoop(FunctionCache):
    """Cache of a loop; in place of Numba's own, whose methods it has."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file.__class__ = _CheckedFile

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Code for a signature; None when there is none, or none that can be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # what a damaged file raises cannot be foreseen
            _LOG.info("%s: %s: %s", self._name, type(error).__name__, error)
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep code for a signature, if that is possible."""
        try:
            self._save(sig, data)
        except OSError as error:
            _LOG.info("%s is not kept: %s", self._name, error)

    def _save(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError:
            raise
        except Exception as error:  # the index is damaged
            _LOG.info("%s: %s: %s", self._name, type(error).__name__, error)
            self.flush()
            super().save_overload(sig, data)


class _CheckedFile(IndexDataCacheFile):
    """Files of a cache, the content of which ends with its hash."""

    def _dump(self, obj: Any) -> bytes:
        content: bytes = super()._dump(obj)
        return content + _HASH(content).digest()

    def _load_data(self, name: str) -> Any:
        with open(self._data_path(name), "rb") as stream:  # noqa: PTH123  # Numba's path is text
            content = stream.read()
        if _HASH(content[:-_LENGTH]).digest() != content[-_LENGTH:]:
            raise ValueError(f"{name} is damaged")
        return super()._load_data(name)
