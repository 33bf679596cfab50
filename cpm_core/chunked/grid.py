"""The grid of chunks: each owns the pixels of its core, and sees a margin around it as well."""

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
from cpm_core.formats.images.ome_zarr import MultiscaleImage, open_multiscale
from cpm_core.formats.images.reading import Reading
from cpm_core.numerics.grids import Window, expand_window, split_into_tiles
from cpm_core.numerics.types import Array, Extent, frozen
from cpm_core.parameters import Parameters

CHUNK_SIDE = 1024
"""Side of a core [px]: a run on it with its margin takes less than 1.5 GB."""

_MIN_OVERLAP = 128
"""Least number of pixels that a chunk sees around its core [px]."""

_DISTURBED_PIXELS = 16
"""Distance from the border of a padded chunk within which contours may differ from the whole image's [px]."""

_DISTURBED_SIGMAS = 8.0
"""Addition to that distance, in sigmas of the smoothing."""

_OVERLAP_MULTIPLE = 32
"""The overlap is a multiple of this, so that the pyramids of neighbors have the same pixels [px]."""


@frozen
class ChunkedSource:
    """A plane of an image, or a volume, in a Zarr folder; each process opens it by itself."""

    path: Path
    reading: Reading
    axes: str = "yx"

    @property
    def levels(self) -> MultiscaleImage:
        """Levels of the image, opened but not read."""
        return _open_levels(self.path, self.reading)

    @property
    def shape(self) -> Extent:
        """Shape of the image."""
        return tuple(self.levels.axis_length(axis) for axis in self.axes)

    def read_grays(self, window: Window) -> Array:
        """Read gray levels in a window, shape (H, W) or (P, H, W), as float64."""
        return self.read_values(window).astype(float)

    def read_values(self, window: Window) -> NDArray[Any]:
        """Read values in a window, shape (H, W) or (P, H, W), in the type that they are stored in."""
        return self.levels.read_window(window, self.reading)


@lru_cache(3)
def _open_levels(path: Path, reading: Reading) -> MultiscaleImage:
    """Open the levels of an image once in each process."""
    return open_multiscale(path, reading)


@frozen
class Chunk:
    """A part of an image.

    Attributes
    ----------
    number : int
        From 0, plane by plane and row by row.
    core, padded : Window
        The pixels that it owns, and the pixels that it sees.
    """

    number: int
    core: Window
    padded: Window


def window_limits(window: Window) -> Array:
    """Return where a window begins and ends, shape (2, D) [px]; centers of pixels are whole numbers."""
    return np.array([[side.start - 0.5, side.stop - 0.5] for side in window]).T


def outer_limits(window: Window, shape: Extent) -> Array:
    """Return where a window of an image of this shape begins and ends, infinite along the border of the image."""
    low, high = window_limits(window)
    return np.array([np.where(low < 0.0, -np.inf, low), np.where(high > np.array(shape) - 1.0, np.inf, high)])


def box_touches(contour: Contour, window: Window) -> bool:
    """Return whether the box of a contour has pixels in a window."""
    low, high = window_limits(window)
    return bool((contour.box[1] >= low).all() and (contour.box[0] <= high).all())


@frozen
class ChunkGrid:
    """The chunks of an image.

    Attributes
    ----------
    shape : tuple of int
        Shape of the image.
    side, overlap : int
        Side of the cores, and width of the margin that a chunk sees around its core [px].
    """

    shape: Extent
    side: int
    overlap: int

    @property
    def chunks(self) -> tuple[Chunk, ...]:
        """All chunks."""
        cores = split_into_tiles(self.shape, self.side)
        return tuple(Chunk(n, core, expand_window(core, self.overlap, self.shape)) for n, core in enumerate(cores))

    @property
    def counts(self) -> Extent:
        """Number of chunks along each axis."""
        return tuple(-(-n // self.side) for n in self.shape)

    def find_chunk_numbers(self, places: Array) -> Array:
        """Find the chunks, shape (N,), whose cores hold points, shape (N, D) [px], or are nearest to them."""
        at = np.clip(np.floor((places + 0.5) / self.side).astype(int), 0, np.array(self.counts) - 1)
        return np.ravel_multi_index(tuple(at.T), self.counts)

    def split_window(self, window: Window) -> Iterator[tuple[int, Window]]:
        """Split a window into its parts in the cores of chunks, each with the number of the chunk."""
        for at in product(*(range(part.start // self.side, -(-part.stop // self.side)) for part in window)):
            core = tuple(
                slice(max(k * self.side, part.start), min((k + 1) * self.side, part.stop))
                for k, part in zip(at, window, strict=True)
            )
            yield int(np.ravel_multi_index(at, self.counts)), core

    def find_chunks_in(self, window: Window) -> list[int]:
        """Find the numbers of the chunks whose cores have pixels in a window."""
        return [number for number, _ in self.split_window(window)]

    def find_neighbors(self, chunk: Chunk) -> list[int]:
        """Find the numbers of a chunk and of its neighbors."""
        return self.find_chunks_in(expand_window(chunk.core, 1, self.shape))


def disturbed_margin(smoothing: float) -> int:
    """Compute how far from the border of a padded chunk results may differ, after a Gaussian of this sigma [px]."""
    return _DISTURBED_PIXELS + math.ceil(_DISTURBED_SIGMAS * smoothing)


def build_grid(shape: Extent, parameters: Parameters, smoothing: float, side: int = CHUNK_SIDE) -> ChunkGrid:
    """Build the grid for a run with these parameters and a Gaussian of `smoothing` px."""
    needed = disturbed_margin(smoothing) + max(parameters.min_length, parameters.max_gap)
    overlap = -(-max(_MIN_OVERLAP, math.ceil(needed)) // _OVERLAP_MULTIPLE) * _OVERLAP_MULTIPLE
    return ChunkGrid(shape, side, overlap)
