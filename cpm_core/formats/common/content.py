"""Content of files: reading, the error when that fails, and hashes that identify a file."""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import logging
import os
import shutil
import stat
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import IO, TypeGuard

import numpy as np

from cpm_core.numerics.packages import MissingPackageError
from cpm_core.numerics.types import Callback, Integers

AnyPath = str | os.PathLike[str]

AnySource = AnyPath | IO[bytes]
"""A path, an address that fsspec knows, such as s3://bucket/name.tif, or an open file."""

MAX_FILE_SIZE = 2**29
"""Largest size of a file of contours or of a surface [bytes]."""

_HASH_BLOCK = 2**20
"""Size of the blocks in which a file is hashed [bytes]."""

_LARGEST_HASHED_WHOLE = 2**30
"""Size up to which a whole file is hashed, which takes some seconds [bytes]."""

_SAMPLED_BLOCKS = 64
"""Number of blocks of a larger file that are hashed."""

_MAX_FOLDER_LENGTH = 40
"""Longest path of a folder that a message shows in full [characters]."""

_LOG = logging.getLogger(__name__)


class UnreadableError(ValueError):
    """A file cannot be used; the message is a sentence for users.

    Attributes
    ----------
    images : tuple of int
        Indices of the parts of a file that are images or volumes, if there are several and none was chosen; else empty.
    """

    def __init__(self, message: str, images: Integers = ()) -> None:
        super().__init__(message)
        self.images = images


class MissingFileError(FileNotFoundError, ValueError):
    """A file does not exist."""


def is_address(source: AnyPath) -> TypeGuard[str]:
    """Return whether a text is an address of fsspec rather than a path; a file that exists is none."""
    return isinstance(source, str) and ("://" in source or "::" in source) and not os.path.lexists(source)


def find_local_file(source: AnySource) -> Path:
    """Return the path of a file; of an open file, and of one at an address, a copy that lasts as long as the program.

    Raises
    ------
    ValueError
        When there is no file at an address, or a package that its kind of address needs is missing.
    """
    if isinstance(source, os.PathLike) or (isinstance(source, str) and not is_address(source)):
        return Path(source)
    folder = Path(tempfile.mkdtemp(prefix="cpm-"))  # one for each copy, as files of other folders may have its name
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    if not isinstance(source, str):
        copy = folder / Path(str(getattr(source, "name", "file")).strip("<>")).name
        copy.write_bytes(source.read())
        return copy
    try:
        import fsspec  # only here, because most files are local

        options = {"same_names": True, "cache_storage": str(folder)}
        return Path(fsspec.open_local(f"simplecache::{source}", simplecache=options))
    except ImportError as error:
        raise MissingPackageError(source, error.name or "fsspec") from None
    except Exception as error:  # of any kind of address
        raise UnreadableError(f"{source} cannot be read: {str(error) or type(error).__name__}.") from error


def format_location(file: Path) -> str:
    """Format a path for a sentence: the file name first, since it matters most, then the end of a long folder."""
    folder = os.path.dirname(file)  # noqa: PTH120 - empty where none is given
    if len(folder) > _MAX_FOLDER_LENGTH:
        folder = f"…{os.sep}{Path(folder).name}"
    return f"{file.name} in {folder.rstrip(os.sep)}{os.sep}" if folder else file.name


def read_content(file: Path, max_size: int = MAX_FILE_SIZE, head_size: int = -1) -> bytes:
    """Return the bytes of a file, or its first `head_size`; UnreadableError when it cannot be read or is too large."""
    try:
        known = file.stat()
        if stat.S_ISDIR(known.st_mode):
            raise UnreadableError(f"{format_location(file)} is a folder: choose a file in it.")
        if not stat.S_ISREG(known.st_mode):
            raise UnreadableError(f"{format_location(file)} is not an ordinary file: choose another one.")
        if known.st_size > max_size and head_size < 0:
            raise UnreadableError(
                f"{file.name} has {known.st_size >> 20} MB, more than the {max_size >> 20} MB allowed."
            )
        with file.open("rb") as stream:
            return stream.read(head_size)
    except FileNotFoundError:
        raise MissingFileError(f"{format_location(file)} does not exist: check its name and folder.") from None
    except PermissionError:
        raise UnreadableError(
            f"{format_location(file)} cannot be read, because you have no permission: ask its owner for it."
        ) from None
    except OSError as error:
        raise UnreadableError(f"{format_location(file)} cannot be read: {error.strerror or error}.") from error


@contextlib.contextmanager
def explain_decoding_errors(name: str, fallback: str | Callable[[], str]) -> Iterator[None]:
    """Turn any decoding error into a ValueError that names the file; unknown causes become the sentence `fallback`."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # oddities of a readable file do not concern the user
            yield
    except (UnreadableError, MissingFileError, MissingPackageError) as error:
        if name in str(error):
            raise
        raise UnreadableError(f"{name}: {error}") from error
    except MemoryError:
        raise ValueError(f"{name} does not fit into memory: crop it or make it smaller first.") from None
    except Exception as error:  # decoders raise exceptions of any kind on damaged files
        _LOG.info("%s: %s: %s", name, type(error).__name__, error)
        raise ValueError(f"{name} {fallback if isinstance(fallback, str) else fallback()}") from error


def compute_fingerprint(path: Path, check_cancelled: Callback | None = None) -> str:
    """Return the hash of a file: SHA-256 as 64 hexadecimal digits.

    Above 1 GiB only the size and some blocks are hashed, the first and the last among them, and the hash begins with
    "sampled:". `check_cancelled` is called between blocks and may raise to stop. ValueError when the file cannot be
    read.
    """
    found, kind = hashlib.sha256(), ""
    try:
        with path.open("rb") as stream:
            size = stream.seek(0, os.SEEK_END)
            starts: Iterable[int] = range(0, size, _HASH_BLOCK)
            if size > _LARGEST_HASHED_WHOLE:
                kind = "sampled:"
                found.update(b"%d\n" % size)
                starts = (number * (size - _HASH_BLOCK) // (_SAMPLED_BLOCKS - 1) for number in range(_SAMPLED_BLOCKS))
            for start in starts:
                stream.seek(start)
                found.update(stream.read(_HASH_BLOCK))
                if check_cancelled is not None:
                    check_cancelled()
    except OSError as error:
        raise ValueError(f"{format_location(path)} cannot be read: {error.strerror or error}.") from error
    return f"{kind}{found.hexdigest()}"


def try_fingerprint(path: Path, check_cancelled: Callback | None = None) -> str:
    """Return the hash of a file as `compute_fingerprint` does; empty when the file cannot be read."""
    try:
        return compute_fingerprint(path, check_cancelled)
    except ValueError:
        return ""
