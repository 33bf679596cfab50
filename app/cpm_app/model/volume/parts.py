"""Parts of a file that holds several images, with their numbers in words."""

from __future__ import annotations

from pathlib import Path

from cpm_app.model.text.language import tr
from cpm_core.formats import ONLY_THESE_NOTE, Reading, Stack
from cpm_core.image import MINIMUM_SIDE
from cpm_core.numerics.types import Sides, Texts, frozen

_PAGE_WORDS = {
    "plane": (tr("{count} planes"), tr("plane {number}")),
    "page": (tr("{count} pages"), tr("page {number}")),
    "frame": (tr("{count} frames"), tr("frame {number}")),
}
"""Number of pages, and one of them, in words."""


@frozen
class FileParts:
    """Content of a file.

    Attributes
    ----------
    pages : int
        Planes, pages or frames: images of one size that make a volume, or a film.
    times, channels : int
        Points in time and channels of each.
    series : tuple of str
        Names of all series; empty where a file has none.
    series_number : int
        Series that the other values belong to, from 1.
    word : str
        Word for a page: plane, page or frame.
    default_page : int
        The page that is read by default, from 1.
    spacing, unit
        Size of a voxel in the file, along (plane, row, col), and its unit; None where it has none.
    is_volume : bool
        Whether pages are planes of a volume: the file gives their distance, or its format is one of volumes.
    volume_planes : int
        Number of pages that make a volume.
    doubts : tuple of str
        Sentences of the core on faults of that volume, such as missing planes.
    series_around : Path or None
        Folder with the slices of a series that the file seems to belong to.
    has_colors : bool
        Whether the first channels are red, green and blue, which are open together unless a channel is chosen.
    channel_styles : tuple of (str, str)
        As in `Stack`.
    """

    pages: int
    times: int = 1
    channels: int = 1
    series: Texts = ()
    series_number: int = 1
    word: str = "page"
    default_page: int = 1
    is_volume: bool = False
    spacing: Sides = (1.0, 1.0, 1.0)
    unit: str | None = None
    volume_planes: int = 0
    doubts: Texts = ()
    series_around: Path | None = None
    has_colors: bool = False
    channel_styles: tuple[tuple[str, str], ...] = ()

    @classmethod
    def from_stack(cls, stack: Stack, paged: bool, series_around: Path | None = None) -> FileParts:
        """Return the parts of a stack, or of a film, whose pages are its frames.

        `paged` is whether pages are usually separate images. A stack with several planes at each time has both.
        """
        planes, film = stack.shape[0], stack.shape[0] == 1 and stack.times > 1
        pages, times = (stack.times, 1) if film else (planes, stack.times)
        usual = 1 if film else stack.default_plane + 1
        deep = not film and (stack.has_plane_spacing or not paged)
        first, end = stack.volume_range or (0, pages)
        left_out = (ONLY_THESE_NOTE,) if stack.volume_range is not None and end - first >= MINIMUM_SIDE else ()
        return cls(pages, times, stack.channels, stack.series, stack.series_number + 1, stack.plane_word, usual, deep,
                   stack.spacing, stack.unit, end - first, (*stack.volume_notes, *left_out),
                   series_around if pages == 1 else None, stack.has_colors, stack.channel_styles)  # fmt: skip

    @property
    def can_be_volume(self) -> bool:
        """Whether there are enough pages for a volume."""
        return self.volume_planes >= MINIMUM_SIDE

    @property
    def has_choice(self) -> bool:
        """Whether there is anything to choose."""
        return self.pages > 1 or self.has_volume_choice

    @property
    def has_volume_choice(self) -> bool:
        """Whether there is anything to choose apart from the page."""
        return max(self.times, self.channels, len(self.series)) > 1

    @property
    def count_text(self) -> str:
        """Number of each kind of part, in words."""
        counts = (
            (_PAGE_WORDS[self.word][0], self.pages),
            (tr("{count} channels"), self.channels),
            (tr("{count} points in time"), self.times),
            (tr("{count} series"), len(self.series)),
        )
        return ", ".join(text.format(count=count) for text, count in counts if count > 1)

    @property
    def has_composite(self) -> bool:
        """Whether all channels are shown together, rather than red, green and blue, or one of them."""
        return self.channels > 1 and not self.has_colors

    def describe_reading(self, reading: Reading, as_volume: bool) -> str:
        """Describe in words which parts are open; empty where all of them are shown."""
        numbers = (
            (_PAGE_WORDS[self.word][1], self.pages, None if as_volume else reading.page or self.default_page),
            (tr("channel {number}"), self.channels, None if self.has_composite else reading.channel),
            (tr("time {number}"), self.times, reading.time or 1),
        )
        said = [text.format(number=number) for text, count, number in numbers if count > 1 and number is not None]
        if len(self.series) > 1:
            said.append(tr("series {name}", name=self.series[self.series_number - 1]))
        return ", ".join(said)
