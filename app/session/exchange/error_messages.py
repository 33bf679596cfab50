"""Errors as one sentence for the user."""

from __future__ import annotations

import logging

from app.model.text.language import tr
from app.model.text.reasons import reason

log = logging.getLogger(__name__)


def sentence(error: Exception, activity: str) -> str:
    """One sentence on what went wrong during an activity such as ``tr("opening {name}")``.

    The texts of `ValueError` and `OSError` are used. Any other error, except for lack of memory, is a defect of the
    program and is logged in full.
    """
    if isinstance(error, ValueError | OSError):
        text = reason(error)
    elif isinstance(error, MemoryError):
        message = tr("There was not enough memory while {activity}: close other programs, or use a smaller image")
        text = message.format(activity=activity)
    else:
        log.error("unexpected error while %s", activity, exc_info=error)
        message = tr("Something unexpected happened while {activity}: {error}")
        text = message.format(activity=activity, error=str(error) or type(error).__name__)
    text = " ".join(text.split())
    if text.partition(" ")[0].isalpha():  # file names are not changed
        text = text[:1].upper() + text[1:]
    return text if text.endswith(_ENDS) else f"{text}."


_ENDS = (".", "!", "?", "。", "！", "？")
