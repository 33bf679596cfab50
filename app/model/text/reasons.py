"""What an error says, in the language of the window."""

from __future__ import annotations

from pathlib import Path

from app.model.text.language import from_core


def reason(error: Exception) -> str:
    """What an error says of itself; for an error with a file, with the name of the file."""
    if isinstance(error, OSError) and error.strerror and isinstance(error.filename, str | Path):
        return f"{Path(error.filename).name}: {cause(error)}"
    return from_core(str(error))


def cause(error: OSError) -> str:
    """What the system says, without the name of a file."""
    return from_core(error.strerror or str(error))
