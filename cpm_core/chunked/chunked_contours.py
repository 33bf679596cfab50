"""What is to be run chunk by chunk, and the contours or objects that were found, stored by chunk."""

from __future__ import annotations

from dataclasses import asdict, replace

from cpm_core.chunked.grid import ChunkedSource, ChunkGrid, box_touches, window_limits
from cpm_core.chunked.image_statistics import ImageStatistics
from cpm_core.chunked.store import RunStore, unpack_contours
from cpm_core.contours.contour import Contour
from cpm_core.formats.common.provenance import VERSION
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, Integers, JsonDict, frozen
from cpm_core.parameters import Parameters
from cpm_core.shapes.everywhere import SeedingKind

CONTOURS_KIND = "contours"
"""Kind of the files that hold the contours of chunks."""

JOINED_KIND = "joined"
"""Kind of the files that hold contours across seams, each in that of the chunk with the middle of its box."""

OBJECTS_KIND = "objects"
"""Kind of the files that hold the objects of chunks."""


@frozen
class ChunkedTask:
    """A run to be done, and where its results are stored.

    Attributes
    ----------
    source : ChunkedSource
        The image.
    parameters : Parameters
        Parameters of the run.
    kind : str
        Kind of automatic seeding, one of `CHUNKED_START_KINDS`.
    store : RunStore
        Where results are stored.
    max_steps : int or None
        Greatest number of steps in each chunk.
    objects : bool
        Whether objects between the contours are found instead of contours.
    """

    source: ChunkedSource
    parameters: Parameters
    kind: SeedingKind
    store: RunStore
    max_steps: int | None = None
    objects: bool = False

    @property
    def settings(self) -> JsonDict:
        """All settings that the result depends on, besides the image."""
        return {"image": str(self.source.path.absolute()), "reading": asdict(self.source.reading), "start": self.kind,
                "parameters": asdict(self.parameters), "steps": self.max_steps, "objects": self.objects,
                "version": VERSION}  # fmt: skip


@frozen
class ChunkedContours:
    """Contours or objects, which can be read chunk by chunk.

    Attributes
    ----------
    task : ChunkedTask
        The run.
    grid : ChunkGrid
        The chunks.
    statistics : ImageStatistics
        What the fields depend on in the whole image.
    counts : tuple of int
        Number of contours, or of objects, of each chunk.
    kind : str
        `CONTOURS_KIND` or `OBJECTS_KIND`; the contours of an object share its number as their `Contour.group`.
    """

    task: ChunkedTask
    grid: ChunkGrid
    statistics: ImageStatistics
    counts: Integers
    kind: str = CONTOURS_KIND

    @property
    def count(self) -> int:
        """Number of contours, or of objects."""
        return sum(self.counts)

    def read_chunk_contours(self, chunk: int) -> list[Contour]:
        """Read the contours of a chunk, numbered through the image; last those across seams."""
        store, before = self.task.store, sum(self.counts[:chunk])
        found = unpack_contours(store.load(chunk_file_name(self.kind, chunk)))
        if self.kind == OBJECTS_KIND:
            numbers = [before + one.group for one in found]
            return [replace(one, group=n, name=f"object {n}") for one, n in zip(found, numbers, strict=True)]
        if store.has_file(chunk_file_name(JOINED_KIND, chunk)):
            found += unpack_contours(store.load(chunk_file_name(JOINED_KIND, chunk)))
        return [replace(one, number=number) for number, one in enumerate(found, before + 1)]

    def find_contours_near(self, window: Window) -> list[Contour]:
        """Read the contours that reach into a window."""
        low, high = window_limits(window)
        wide = self.task.store.load(f"{self.kind}.npz")
        there = ((wide["boxes"][:, 1] >= low) & (wide["boxes"][:, 0] <= high)).all(axis=1)
        chunks = {*self.grid.find_chunks_in(window), *wide["chunks"][there].tolist()}
        found = (one for chunk in sorted(chunks) for one in self.read_chunk_contours(chunk))
        return [one for one in found if box_touches(one, window)]

    def find_links_near(self, window: Window) -> list[Array]:
        """Read the links between contours (`Result.links`) in a window."""
        files = (chunk_file_name(CONTOURS_KIND, chunk) for chunk in self.grid.find_chunks_in(window))
        links = (one for file in files for one in unpack_contours(self.task.store.load(file), "link"))
        return [one.points for one in links if box_touches(one, window)]


def chunk_file_name(kind: str, number: int) -> str:
    """Return the name of the file of a chunk that holds results of a kind."""
    return f"{kind}_{number}.npz"
