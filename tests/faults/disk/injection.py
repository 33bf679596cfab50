"""Operations on files that fail, one after the other: each call of a kind below a folder can be made to fail."""

from __future__ import annotations

import builtins
import errno
import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

_OF_A_PATH = ("replace", "rename", "unlink", "remove", "mkdir", "stat", "scandir", "listdir", "chmod", "utime")
_OF_A_FILE = ("fsync", "fchmod")

_CHANGING = frozenset({"create", "replace", "rename", "unlink", "remove", "mkdir", "chmod", "utime"})
_LOOKING = frozenset({"open", "stat", "scandir", "listdir"})
_REFUSED = {
    errno.ENOSPC: frozenset({"create", "write", "fsync", "replace", "rename", "mkdir"}),
    errno.EROFS: _CHANGING,
    errno.EACCES: _CHANGING | _LOOKING,
    errno.EIO: _CHANGING | _LOOKING | {"read", "write", "fsync", "fchmod"},
}
"""Operations that may fail, by the number of the error."""


def can_fail(operation: str, error: int) -> bool:
    """Whether an operation fails with an error on a real disk."""
    return operation in _REFUSED[error]


@dataclass
class Faults:
    """Counts operations on files below a folder, and lets the one with a number fail, or all from it on.

    Parameters
    ----------
    folder : Path
        Only files below it are concerned.
    number : int
        Which operation fails, counted from one; none when it is zero.
    error : int
        The number of the error, as ``errno.ENOSPC``.
    lasting : bool
        Whether all later operations fail as well that the same disk would refuse.
    """

    folder: Path
    number: int = 0
    error: int = 0
    lasting: bool = False
    operations: list[str] = field(default_factory=list)

    def count(self, operation: str, place: object) -> None:
        """Count an operation, and let it fail when it is its turn."""
        if not self._concerns(place):
            return
        self.operations.append(operation)
        made = len(self.operations)
        failing = made == self.number or (self.lasting and 0 < self.number < made)
        if failing and can_fail(operation, self.error):
            raise OSError(self.error, os.strerror(self.error), str(place))

    def _concerns(self, place: object) -> bool:
        return isinstance(place, str | bytes | os.PathLike) and os.fsdecode(place).startswith(str(self.folder))

    @property
    def happened(self) -> bool:
        """Whether an operation has failed."""
        return 0 < self.number <= len(self.operations)


@contextmanager
def injected(faults: Faults) -> Iterator[Faults]:
    """Let operations on files go through `faults` in this block, on all threads."""
    with (
        mock.patch.multiple(os, **_patches(faults)),
        mock.patch.object(io, "open", _opener(faults)) as opener,
        mock.patch.object(builtins, "open", opener),
    ):
        yield faults


def _patches(faults: Faults) -> dict[str, Callable[..., Any]]:
    def of_a_path(name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def called(place: Any, *arguments: Any, **named: Any) -> Any:
            faults.count(name, place)
            return real(place, *arguments, **named)

        return called

    def of_a_file(name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def called(descriptor: int, *arguments: Any) -> Any:
            faults.count(name, faults.folder)
            return real(descriptor, *arguments)

        return called

    found = {name: of_a_path(name, getattr(os, name)) for name in _OF_A_PATH}
    return found | {name: of_a_file(name, getattr(os, name)) for name in _OF_A_FILE}


def _opener(faults: Faults) -> Callable[..., Any]:
    class Raw(io.FileIO):
        """A file whose reading and writing can fail."""

        def write(self, content: Any) -> Any:
            faults.count("write", self.name)
            return super().write(content)

        def readinto(self, content: Any) -> Any:
            faults.count("read", self.name)
            return super().readinto(content)

        def readall(self) -> Any:
            faults.count("read", self.name)
            return super().readall()

    real = io.open

    def opened(
        place: Any,
        mode: str = "r",
        buffering: int = -1,
        encoding: Any = None,
        errors: Any = None,
        newline: Any = None,
        closefd: bool = True,
        opener: Any = None,
    ) -> Any:
        if not isinstance(place, str | bytes | os.PathLike) or opener is not None:
            return real(place, mode, buffering, encoding, errors, newline, closefd, opener)
        place = os.fspath(place)
        faults.count("open" if mode in ("r", "rb") else "create", place)
        raw = Raw(place, mode.replace("b", "").replace("t", ""))
        if buffering == 0:
            return raw
        kind = io.BufferedRandom if "+" in mode else io.BufferedReader if "r" in mode else io.BufferedWriter
        buffered = kind(raw)
        return buffered if "b" in mode else io.TextIOWrapper(buffered, encoding, errors, newline)

    return opened
