"""Fingerprint: the hash of a file, by which it is known again."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

_PART = 2**22
"""Bytes that are read at once."""


def fingerprint(path: Path, go_on: Callable[[], object] | None = None) -> str:
    """Hash of a file (SHA-256), 64 hexadecimal digits.

    `go_on` is called between the parts of a long file, and may raise to stop. ValueError when the file cannot be read.
    """
    found = hashlib.sha256()
    try:
        with path.open("rb") as stream:
            while part := stream.read(_PART):
                found.update(part)
                if go_on is not None:
                    go_on()
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}.") from error
    return found.hexdigest()


def fingerprint_if_read(path: Path, go_on: Callable[[], object] | None = None) -> str:
    """Hash of a file as `fingerprint` makes it; empty when the file cannot be read."""
    try:
        return fingerprint(path, go_on)
    except ValueError:
        return ""
