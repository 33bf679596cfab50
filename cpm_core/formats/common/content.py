"""Content of a file: how it is read, the error when it cannot be, and the hash by which it is known again."""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import stat
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from cpm_core.numerics.types import Callback, Integers

AnyPath = str | os.PathLike[str]

MOST = 2**29
"""Most bytes of a file of contours or of a surface."""

_PART = 2**20
"""Bytes that are read at once."""

_LARGEST = 2**30
"""Bytes of the largest file that is read as a whole: some seconds."""

_SAMPLES = 64
"""Parts of a larger file that are read."""

_LONGEST_FOLDER = 40
"""Letters of a folder that a sentence shows as a whole."""

_LOG = logging.getLogger(__name__)


def missing(what: str, package: str, install: str) -> str:
    """One sentence on what cannot be done without a package, and what pip installs it by."""
    return f'{what} needs the package {package}, which is not installed: run pip install "{install}".'


class UnreadableError(ValueError):
    """A file cannot be used; the message is a sentence for users.

    Attributes
    ----------
    images : tuple of int
        Which parts of a file with several of them are images or volumes, from 0, where none was chosen; else empty.
    """

    def __init__(self, message: str, images: Integers = ()) -> None:
        super().__init__(message)
        self.images = images


def placed(file: Path) -> str:
    """A file in a sentence: its name first, which is what counts, and its folder, of a long one the end."""
    folder = os.path.dirname(file)  # noqa: PTH120 - empty where none is given
    if len(folder) > _LONGEST_FOLDER:
        folder = f"…{os.sep}{Path(folder).name}"
    return f"{file.name} in {folder.rstrip(os.sep)}{os.sep}" if folder else file.name


def content_of(file: Path, most: int = MOST, part: int = -1) -> bytes:
    """The bytes of a file, or so many of its first; UnreadableError when it cannot be read or is too large."""
    try:
        known = file.stat()
        if stat.S_ISDIR(known.st_mode):
            raise UnreadableError(f"{placed(file)} is a folder: choose a file in it.")
        if not stat.S_ISREG(known.st_mode):
            raise UnreadableError(f"{placed(file)} is not an ordinary file: choose another one.")
        if known.st_size > most and part < 0:
            raise UnreadableError(f"{file.name} has {known.st_size >> 20} MB, more than the {most >> 20} MB allowed.")
        with file.open("rb") as stream:
            return stream.read(part)
    except FileNotFoundError:
        raise UnreadableError(f"{placed(file)} does not exist: check its name and folder.") from None
    except PermissionError:
        raise UnreadableError(
            f"{placed(file)} cannot be read, because you have no permission: ask its owner for it."
        ) from None
    except OSError as error:
        raise UnreadableError(f"{placed(file)} cannot be read: {error.strerror or error}.") from error


@contextlib.contextmanager
def decoding(name: str, otherwise: str) -> Iterator[None]:
    """Let ValueError say in a sentence why a file of this name cannot be read: `otherwise`, where nobody knows why."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # oddities of a readable file do not concern the user
            yield
    except UnreadableError as error:
        if name in str(error):
            raise
        raise UnreadableError(f"{name}: {error}") from error
    except MemoryError:
        raise ValueError(f"{name} does not fit into memory: crop it or make it smaller first.") from None
    except Exception as error:  # decoders raise exceptions of any kind on damaged files
        _LOG.info("%s: %s: %s", name, type(error).__name__, error)
        raise ValueError(f"{name} {otherwise}") from error


def fingerprint(path: Path, go_on: Callback | None = None) -> str:
    """Hash of a file (SHA-256), 64 hexadecimal digits.

    Of a file above 1 GiB it is the hash of its size and of parts of it, the first and the last among them, after
    "sampled:". `go_on` is called between the parts of a file, and may raise to stop. ValueError when the file cannot be
    read.
    """
    found, kind = hashlib.sha256(), ""
    try:
        with path.open("rb") as stream:
            size = stream.seek(0, os.SEEK_END)
            starts: Iterable[int] = range(0, size, _PART)
            if size > _LARGEST:
                kind = "sampled:"
                found.update(b"%d\n" % size)
                starts = (number * (size - _PART) // (_SAMPLES - 1) for number in range(_SAMPLES))
            for start in starts:
                stream.seek(start)
                found.update(stream.read(_PART))
                if go_on is not None:
                    go_on()
    except OSError as error:
        raise ValueError(f"{placed(path)} cannot be read: {error.strerror or error}.") from error
    return f"{kind}{found.hexdigest()}"


def fingerprint_if_read(path: Path, go_on: Callback | None = None) -> str:
    """Hash of a file as `fingerprint` makes it; empty when the file cannot be read."""
    try:
        return fingerprint(path, go_on)
    except ValueError:
        return ""
