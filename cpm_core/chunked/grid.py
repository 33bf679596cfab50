"""The grid of chunks: each owns the pixels of its core, and sees those around it as well."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.formats.images.ome_zarr import Levels, open_levels
from cpm_core.formats.images.reading import Reading
from cpm_core.numerics.grids import Window, around, tiles
from cpm_core.numerics.types import Array, Extent, frozen
from cpm_core.parameters import Parameters

SIDE = 1024
"""Side of a core [px]: a run on it with what is around takes less than 1.5 GB."""

_OVERLAP = 128
"""Least number of pixels that a chunk sees around its core: objects of up to about 100 px are seen as a whole."""

_DISTURBED, _IN_SIGMA = 16, 8.0
"""Distance from the border of what a chunk sees in which contours may differ: in px, and in addition in sigma."""

UNSURE = 1.0
"""Distance from the border of a core in which the middle of a box may be in another one for the neighbor [px]."""

_STEP = 32
"""What the overlap is a multiple of, so that the pyramids of neighbors have the same pixels [px]."""


@frozen
class Source:
    """A plane of an image in a folder of Zarr, or with three axes a volume; each process opens it by itself."""

    path: Path
    reading: Reading
    axes: str = "yx"

    @property
    def levels(self) -> Levels:
        """The image, of which nothing has been read."""
        return _opened(self.path, self.reading)

    @property
    def shape(self) -> Extent:
        """Its shape."""
        return tuple(self.levels.count(axis) for axis in self.axes)

    def gray(self, window: Window) -> Array:
        """Gray levels in a window, shape (H, W) or (P, H, W)."""
        return self.values(window).astype(float)

    def values(self, window: Window) -> NDArray[Any]:
        """The same as they are stored."""
        return self.levels.part(window, self.reading)


@lru_cache(2)
def _opened(path: Path, reading: Reading) -> Levels:
    return open_levels(path, reading)


@frozen
class Chunk:
    """A part of an image.

    Attributes
    ----------
    number : int
        From 0, plane by plane and row by row.
    core, padded : Window
        The pixels that it owns, and those that it sees.
    """

    number: int
    core: Window
    padded: Window

    def may_own(self, middle: Array) -> bool:
        """Whether it is the chunk of a contour with this middle, or a neighbor takes it for that."""
        low, high = limits(self.core)
        return bool(((middle >= low - UNSURE) & (middle < high + UNSURE)).all())


def limits(window: Window) -> Array:
    """Where a window begins, and where it ends, shape (2, D) [px]; centers of pixels are whole numbers."""
    return np.array([[side.start - 0.5, side.stop - 0.5] for side in window]).T


def touches(contour: Contour, window: Window) -> bool:
    """Whether the box of a contour has pixels in a window."""
    low, high = limits(window)
    return bool((contour.box[1] >= low).all() and (contour.box[0] <= high).all())


@frozen
class Grid:
    """The chunks of an image.

    Attributes
    ----------
    shape : tuple of int
        Shape of the image.
    side, overlap : int
        Side of the cores, and how far a chunk sees beyond [px].
    whole : float
        Longest side of the box of a contour that each chunk whose core it touches sees as a whole, undisturbed [px].
    """

    shape: Extent
    side: int
    overlap: int
    whole: float

    @property
    def chunks(self) -> tuple[Chunk, ...]:
        """All chunks."""
        cores = tiles(self.shape, self.side)
        return tuple(Chunk(n, core, around(core, self.overlap, self.shape)) for n, core in enumerate(cores))

    @property
    def counts(self) -> Extent:
        """Number of chunks along each axis."""
        return tuple(-(-n // self.side) for n in self.shape)

    def chunk_at(self, places: Array) -> Array:
        """Number of the chunk in whose core each of places lies, shape (N,); beyond the border the nearest one."""
        at = np.clip(np.floor((places + 0.5) / self.side).astype(int), 0, np.array(self.counts) - 1)
        return np.ravel_multi_index(tuple(at.T), self.counts)

    def within(self, window: Window) -> Iterator[tuple[int, Window]]:
        """Numbers of the chunks whose cores reach into a window, and these parts of it."""
        for at in product(*(range(part.start // self.side, -(-part.stop // self.side)) for part in window)):
            core = tuple(
                slice(max(k * self.side, part.start), min((k + 1) * self.side, part.stop))
                for k, part in zip(at, window, strict=True)
            )
            yield int(np.ravel_multi_index(at, self.counts)), core

    def sees(self, contour: Contour) -> bool:
        """Whether each chunk whose core a contour touches sees it as a whole, undisturbed."""
        return bool((contour.box[1] - contour.box[0]).max() <= self.whole)

    def around(self, number: int) -> list[int]:
        """Numbers of a chunk and its neighbors."""
        at = np.array(np.unravel_index(number, self.counts)).tolist()
        near = np.ix_(*(range(max(k - 1, 0), min(k + 2, n)) for k, n in zip(at, self.counts, strict=True)))
        found: list[int] = np.ravel_multi_index(near, self.counts).ravel().tolist()
        return found

    def near(self, window: Window) -> list[int]:
        """Numbers of the chunks that contours with pixels in a window may belong to, if they see them as a whole."""
        wide = around(window, math.ceil(0.5 * self.whole + UNSURE) + 1, self.shape)
        return [number for number, _ in self.within(wide)]


def disturbed(smoothing: float) -> int:
    """Distance from the border of what a chunk sees in which what is found may differ, after a Gaussian [px]."""
    return _DISTURBED + math.ceil(_IN_SIGMA * smoothing)


def grid_for(shape: Extent, parameters: Parameters, smoothing: float, side: int = SIDE) -> Grid:
    """The grid for a run with these parameters and a Gaussian of `smoothing` px."""
    needed = disturbed(smoothing) + max(parameters.min_length, parameters.max_gap)
    overlap = -(-max(_OVERLAP, math.ceil(needed)) // _STEP) * _STEP
    return Grid(shape, side, overlap, float(overlap - disturbed(smoothing)))
