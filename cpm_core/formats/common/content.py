"""Content of a file: all of it, unless it is too large, and its fingerprint, the hash by which it is known again."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterable
from pathlib import Path

MOST = 2**29
"""Most bytes of a file of contours or of a surface."""

_PART = 2**20
"""Bytes that are read at once."""

_LARGEST = 2**30
"""Bytes of the largest file that is read as a whole: some seconds."""

_SAMPLES = 64
"""Parts of a larger file that are read."""

_SAMPLED = "sampled:"
"""Begins the fingerprint of a larger file."""


def content_of(file: Path) -> bytes:
    """The bytes of a file; ValueError when it cannot be read or is too large."""
    try:
        size = file.stat().st_size
        content = file.read_bytes() if size <= MOST else b""
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}.") from error
    if size > MOST:
        raise ValueError(f"{file.name} has {size >> 20} MB, more than the {MOST >> 20} MB that are read.")
    return content


def fingerprint(path: Path, go_on: Callable[[], object] | None = None) -> str:
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
                kind = _SAMPLED
                found.update(b"%d\n" % size)
                starts = (number * (size - _PART) // (_SAMPLES - 1) for number in range(_SAMPLES))
            for start in starts:
                stream.seek(start)
                found.update(stream.read(_PART))
                if go_on is not None:
                    go_on()
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}.") from error
    return f"{kind}{found.hexdigest()}"


def fingerprint_if_read(path: Path, go_on: Callable[[], object] | None = None) -> str:
    """Hash of a file as `fingerprint` makes it; empty when the file cannot be read."""
    try:
        return fingerprint(path, go_on)
    except ValueError:
        return ""


def differ(known: str, found: str) -> bool:
    """Whether a fingerprint that is known shows that a file with another one is not the same.

    That of a whole large file, which earlier versions made, cannot be compared with that of its parts.
    """
    return known != found and found.startswith(_SAMPLED) <= known.startswith(_SAMPLED)
