"""Choice: which part of a file of many planes is read, by numbers that count from 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.parameters.quotation import shown


@dataclass(frozen=True)
class Choice:
    """Which part of a file is read; what is None is left to the reader, which says what it took.

    Attributes
    ----------
    page : int or None
        Plane, page or frame, of what is read as an image.
    channel, time : int or None
        Channel and point in time.
    series : int, str or None
        Series, by its number or its name; in an archive of arrays the array.

    Raises
    ------
    ValueError
        When one is no whole number from 1 up, or a name for what has only numbers.
    """

    page: int | None = None
    channel: int | None = None
    time: int | None = None
    series: int | str | None = None

    def __post_init__(self) -> None:
        for name in ("page", "channel", "time", "series"):
            given = getattr(self, name)
            if isinstance(given, np.integer):
                given = int(given)
                object.__setattr__(self, name, given)
            if given is None or (name == "series" and isinstance(given, str)):
                continue
            if not isinstance(given, int) or isinstance(given, bool) or given < 1:
                raise ValueError(f"{name} is {shown(given)} but must be a whole number from 1 up.")


class UnchosenError(UnreadableError):
    """A file holds several images, and none of them was chosen.

    Attributes
    ----------
    names : tuple of str
        All that it holds.
    images : tuple of int
        Which of them are images or volumes, from 0.
    """

    def __init__(self, message: str, names: tuple[str, ...], images: tuple[int, ...]) -> None:
        super().__init__(message)
        self.names = names
        self.images = images


FIRST = Choice()
"""What is read when nobody chooses."""


def index_of(what: str, wanted: int | None, count: int, otherwise: int, name: str) -> int:
    """Index, from 0, of what is wanted among so many; UnreadableError when there are fewer."""
    if wanted is None:
        return otherwise
    if wanted > count:
        one = "1" if count == 1 else f"1 to {count}"
        raise UnreadableError(f"{what} is {wanted}, but {name} has {count} of them: choose {one}.")
    return wanted - 1


def series_of(wanted: int | str | None, names: tuple[str, ...], otherwise: int, file: str) -> int:
    """Index of the series that is wanted, by number or name; UnreadableError when there is none such."""
    if isinstance(wanted, str):
        if wanted in names:
            return names.index(wanted)
        known = ", ".join(map(shown, names[:9])) + (", …" if len(names) > 9 else "")
        raise UnreadableError(f"series is {shown(wanted)}, but {file} has {known}: choose one of these.")
    return index_of("series", wanted, len(names), otherwise, file)
