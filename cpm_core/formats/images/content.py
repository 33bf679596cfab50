"""The whole content of a file of contours or of a surface, unless it is too large."""

from __future__ import annotations

from pathlib import Path

LARGEST = 2**29
"""Most bytes of a file."""


def content_of(file: Path) -> bytes:
    """The bytes of a file; ValueError when it cannot be read or is too large."""
    try:
        size = file.stat().st_size
        content = file.read_bytes() if size <= LARGEST else b""
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}.") from error
    if size > LARGEST:
        raise ValueError(f"{file.name} has {size >> 20} MB, more than the {LARGEST >> 20} MB that are read.")
    return content
