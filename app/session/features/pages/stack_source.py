"""The file of a stack: how many pages it has, how each is read, and its pages once they are needed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

from app.model.volume.parts import Parts
from cpm_core.formats import load_pages
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stacks.pages import Pages


@dataclass(frozen=True, eq=False)
class StackSource:
    """A file whose pages are images of their own.

    Attributes
    ----------
    path : str
        The file.
    name : str
        Its name.
    count : int
        Number of its pages; 0 where nothing is open, or a volume.
    by_channel : bool
        Whether its pages are its channels, as it has neither planes nor times.
    reading : Reading
        How the page that is open is read.
    usual : int
        The page that is read when nobody chooses.
    """

    path: str = ""
    name: str = ""
    count: int = 0
    by_channel: bool = False
    reading: Reading = field(default_factory=Reading)
    usual: int = 1

    @classmethod
    def of(cls, path: str, name: str, parts: Parts | None, reading: Reading) -> StackSource:
        """The stack that a file holds."""
        if parts is None:
            return cls(path, name)
        by_channel = parts.pages == 1 and parts.times == 1 and parts.channels > 1
        count = parts.channels if by_channel else parts.pages
        return cls(path, name, count if count > 1 else 0, by_channel, reading, parts.usual)

    def of_the_same(self, other: StackSource) -> StackSource:
        """Another page of a stack whose file has been opened already."""
        if "pages" in other.__dict__:
            self.__dict__["pages"] = other.pages
        return self

    @property
    def number(self) -> int:
        """The page that is open."""
        if self.by_channel:
            return self.reading.channel or 1
        return self.reading.page or self.usual

    def reading_of(self, number: int) -> Reading:
        """How a page is read; that which is read when nobody chooses needs no number."""
        chosen = None if number == (1 if self.by_channel else self.usual) else number
        return replace(self.reading, channel=chosen) if self.by_channel else replace(self.reading, page=chosen)

    @cached_property
    def pages(self) -> Pages:
        """The pages, which are read from the file when they are asked for; not on the window's thread."""
        given = self.reading.arguments
        given.pop("page", None)
        if self.by_channel:
            given.pop("channel", None)
        return load_pages(self.path, **given)
