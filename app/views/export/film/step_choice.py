"""Steps of a branch from a text or a choice."""

from __future__ import annotations

import numpy as np

from app.model.text.language import tr


def evenly(first: int, last: int, count: int) -> tuple[int, ...]:
    """`count` evenly spaced steps from the first to the last, without repetition."""
    return tuple(int(step) for step in np.unique(np.linspace(first, last, max(count, 1)).round().astype(int)))


def every(first: int, last: int, stride: int) -> tuple[int, ...]:
    """Every `stride`-th step from the first, and always the last."""
    steps = list(range(first, last + 1, max(stride, 1)))
    return tuple(steps if steps and steps[-1] == last else [*steps, last])


def written(text: str, first: int, last: int) -> tuple[int, ...]:
    """Steps from a text.

    Parameters
    ----------
    text : str
        Numbers separated by commas or spaces.
    first, last : int
        Steps of the branch.

    Raises
    ------
    ValueError
        If the text is empty or contains anything other than steps of the branch.
    """
    steps = []
    for word in text.replace(",", " ").replace(";", " ").split():
        if not word.isdecimal() or not first <= int(word) <= last:
            text = tr("“{word}” is not a step of this branch: write numbers from {first} to {last}, with commas.")
            raise ValueError(text.format(word=word, first=first, last=last))
        steps.append(int(word))
    if not steps:
        raise ValueError(tr("No step is written: write numbers such as 0, 40, 80."))
    return tuple(steps)
