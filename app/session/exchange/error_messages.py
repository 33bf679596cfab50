"""Errors as one sentence for the user."""

from __future__ import annotations

import logging
from pathlib import Path

log = logging.getLogger(__name__)


def sentence(error: Exception, activity: str) -> str:
    """One sentence on what went wrong during an activity such as ``"opening a.png"``.

    The texts of `ValueError` and `OSError` are used. Any other error, except for lack of memory, is a defect of the
    program and is logged in full.
    """
    if isinstance(error, ValueError):
        text = str(error)
    elif isinstance(error, OSError):
        name = Path(error.filename).name if isinstance(error.filename, str | Path) else ""
        text = f"{name}: {error.strerror}" if name and error.strerror else str(error)
    elif isinstance(error, MemoryError):
        text = f"There was not enough memory while {activity}: close other programs, or use a smaller image"
    else:
        log.error("unexpected error while %s", activity, exc_info=error)
        text = f"Something unexpected happened while {activity}: {error or type(error).__name__}"
    text = " ".join(text.split())
    if text.partition(" ")[0].isalpha():  # file names are not changed
        text = text[:1].upper() + text[1:]
    return text if text.endswith((".", "!", "?")) else f"{text}."
