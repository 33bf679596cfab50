"""Which steps of a branch are wanted, from what a person writes or chooses."""

from __future__ import annotations

import numpy as np

from app.model.text.language import tr


def evenly(first: int, last: int, count: int) -> tuple[int, ...]:
    """So many steps evenly from the first to the last, each once."""
    return tuple(int(step) for step in np.unique(np.linspace(first, last, max(count, 1)).round().astype(int)))


def every(first: int, last: int, stride: int) -> tuple[int, ...]:
    """Every so many steps from the first on, and the last in any case."""
    steps = list(range(first, last + 1, max(stride, 1)))
    return tuple(steps if steps and steps[-1] == last else [*steps, last])


def written(text: str, first: int, last: int) -> tuple[int, ...]:
    """Steps written one after the other.

    Parameters
    ----------
    text : str
        Numbers with commas or spaces between.
    first, last : int
        What there is.

    Raises
    ------
    ValueError
        When something else is written, a step that there is not, or nothing at all.
    """
    steps = []
    for word in text.replace(",", " ").replace(";", " ").split():
        if not word.isdecimal() or not first <= int(word) <= last:
            told = tr("“{word}” is not a step of this branch: write numbers from {first} to {last}, with commas.")
            raise ValueError(told.format(word=word, first=first, last=last))
        steps.append(int(word))
    if not steps:
        raise ValueError(tr("No step is written: write numbers such as 0, 40, 80."))
    return tuple(steps)
