"""The hash of a file, by which a session knows its image."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

_BLOCK = 1 << 20
"""Bytes between two questions whether to go on."""


def _always() -> None:
    pass


def fingerprint(path: Path, go_on: Callable[[], None] = _always) -> str:
    """Hash of a file (SHA-256), 64 hexadecimal digits; empty when it cannot be read.

    `go_on` is called after every block, because a large file takes minutes, and may raise to stop.
    """
    digest, block = hashlib.sha256(), bytearray(_BLOCK)
    try:
        with path.open("rb", buffering=0) as stream:
            while length := stream.readinto(block):
                digest.update(memoryview(block)[:length])
                go_on()
    except OSError:
        return ""
    return digest.hexdigest()
