"""Keys in the notation of the operating system and the language."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtGui import QKeySequence


def portable(key: str) -> str:
    """A key in the notation that is the same on all systems."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.PortableText)


def native(key: str) -> str:
    """A key as people call it here."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText)


def natives(keys: Sequence[str]) -> str:
    """Keys, separated by commas."""
    return ", ".join(native(key) for key in keys)
