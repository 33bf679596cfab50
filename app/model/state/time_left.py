"""Estimate of the remaining time of a task, and its text."""

from __future__ import annotations

from app.model.text.language import tr

SURE_AFTER = 1.0
"""Time after which an estimate is shown [s]."""

_LEAST_FRACTION = 0.02


def seconds_left(elapsed: float, fraction: float | None) -> float | None:
    """Remaining time [s] after `elapsed` seconds, when a `fraction` from 0 to 1 is done; None while it is not known."""
    if fraction is None or fraction < _LEAST_FRACTION or elapsed < SURE_AFTER:
        return None
    return elapsed * (1.0 - min(fraction, 1.0)) / fraction


def in_words(seconds: float | None) -> str:
    """A remaining time as text, empty when it is not known."""
    if seconds is None:
        return ""
    if seconds < 10.0:
        return tr("a few seconds left")
    if seconds < 100.0:
        return tr("about {seconds} s left").format(seconds=5 * round(seconds / 5))
    if seconds < 6000.0:
        return tr("about {minutes} min left").format(minutes=round(seconds / 60))
    return tr("about {hours} h left").format(hours=round(seconds / 3600))
