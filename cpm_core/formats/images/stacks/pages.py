"""Pages: the planes of a stack as images of their own, each read when it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, overload

from cpm_core.image.image import Image
from cpm_core.parameters.quotation import counted, described

Axis = Literal["z", "t", "c"]
"""Planes, points in time, channels."""


class Pages(Sequence[Image]):
    """The pages of a file; none is kept, so that a long stack takes no more memory than one of its pages.

    Parameters
    ----------
    name : str
        The file.
    count : int
        How many pages there are.
    word : str
        What a page is called: page or frame.
    axis : {"z", "t", "c"}
        What the pages are: planes, points in time, channels.
    alone : bool
        Whether the file has no further axis, of which one part is read.
    read : callable
        Reads the page with a number from 1; ValueError when it cannot be used.
    sha256 : str
        Hash of the file.
    """

    def __init__(
        self,
        name: str,
        count: int,
        read: Callable[[int], Image],
        *,
        word: str = "page",
        axis: Axis = "z",
        alone: bool = True,
        sha256: str = "",
    ) -> None:
        self.name = name
        self.word = word
        self.axis = axis
        self.alone = alone
        self.sha256 = sha256
        self._count = count
        self._read = read

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Image: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Image]: ...

    def __getitem__(self, index: int | slice) -> Image | Sequence[Image]:
        """Read a page, counted from 0 here; of a slice the pages are read when they are asked for."""
        places = range(self._count)[index]
        if isinstance(places, range):
            return _Chosen(self, places)
        return self._read(places + 1)

    def __repr__(self) -> str:
        return described("Pages", self.name, counted(len(self), self.word))


class _Chosen(Sequence[Image]):
    """Some of the pages of a stack."""

    def __init__(self, pages: Pages, places: range) -> None:
        self._pages = pages
        self._places = places

    def __len__(self) -> int:
        return len(self._places)

    @overload
    def __getitem__(self, index: int) -> Image: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Image]: ...

    def __getitem__(self, index: int | slice) -> Image | Sequence[Image]:
        """Read a page, or choose some of these."""
        chosen = self._places[index]
        return _Chosen(self._pages, chosen) if isinstance(chosen, range) else self._pages[chosen]
