"""Errors turned into one sentence for people."""

from __future__ import annotations

import logging
from pathlib import Path

log = logging.getLogger(__name__)


def sentence(error: Exception, activity: str) -> str:
    """One sentence that says what went wrong.

    Parameters
    ----------
    error : Exception
        `ValueError` and `OSError` speak for themselves; anything else is our mistake and is logged in full.
    activity : str
        What was being done, as in ``"opening a.png"``.
    """
    if isinstance(error, ValueError):
        text = str(error)
    elif isinstance(error, OSError):
        name = Path(error.filename).name if isinstance(error.filename, str | Path) else ""
        text = f"{name}: {error.strerror}" if name and error.strerror else str(error)
    else:
        log.error("unexpected trouble while %s", activity, exc_info=error)
        text = f"Something unexpected happened while {activity}: {error or type(error).__name__}"
    text = " ".join(text.split())
    if text.partition(" ")[0].isalpha():  # names of files are left as they are
        text = text[:1].upper() + text[1:]
    return text if text.endswith((".", "!", "?")) else f"{text}."
