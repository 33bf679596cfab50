"""Steps of a run by cells of the image, in tiles that successive states share.

A step changes few cells, and a timeline keeps hundreds of states: each has tiles of its own only where it differs from
the one before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from math import prod
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Index

Steps = NDArray[np.int32]

NEVER = -1

TILE_BITS = 5
TILE = 1 << TILE_BITS
"""Side of a tile [cells]."""


class Window(NamedTuple):
    """Copies of some tiles, for compiled loops to read and to write.

    Attributes
    ----------
    cells : ndarray of int32, shape (K * TILE**2,)
        The tiles, row by row, one after the other.
    first : ndarray of int64, shape (tiles,)
        Index in `cells` with which each tile begins; meaningless for those that have not been copied.
    """

    cells: Steps
    first: Index


@dataclass(frozen=True, eq=False, slots=True)
class TiledSteps:
    r"""A step for each cell, -1 for never.

    Attributes
    ----------
    shape : tuple of int
        Number of cells along each axis.
    tiles : tuple of ndarray of int32
        Tiles of the same size in the order of their rows, those at the end filled up with -1. They cannot be written
        to: a tile in which nothing has changed belongs to many states.
    """

    shape: tuple[int, ...]
    tiles: tuple[Steps, ...]

    @classmethod
    def never(cls, shape: tuple[int, ...]) -> Self:
        """No step at any cell."""
        return cls(shape, (_empty_tile(len(shape)),) * prod(-(-n // TILE) for n in shape))

    def whole(self) -> Steps:
        r"""A copy as one array, shape (\*cells)."""
        cells = np.empty(self.shape, np.int32)
        for tile, part in zip(self.tiles, self._parts(), strict=True):
            inside = cells[part]
            inside[...] = tile[tuple(slice(n) for n in inside.shape)]
        return cells

    def changed_to(self, cells: Steps) -> Self:
        r"""The steps of an array of shape (\*cells), with the tiles of this one where they are the same."""
        tiles = []
        for tile, part in zip(self.tiles, self._parts(), strict=True):
            other = np.full_like(tile, NEVER)
            inside = cells[part]
            other[tuple(slice(n) for n in inside.shape)] = inside
            tiles.append(tile if np.array_equal(tile, other) else _frozen(other))
        return type(self)(self.shape, tuple(tiles))

    def renewed(self, step: int) -> Self:
        """The same with this step at all cells that have one."""
        empty, later = _empty_tile(len(self.shape)), np.int32(step)
        tiles = (tile if tile is empty else _frozen(np.where(tile == NEVER, tile, later)) for tile in self.tiles)
        return type(self)(self.shape, tuple(tiles))

    def window(self, chosen: Index) -> Window:
        """Copies of the tiles with these numbers, at least one."""
        first = np.zeros(len(self.tiles), np.int64)
        first[chosen] = np.arange(len(chosen)) * self.tiles[0].size
        return Window(np.concatenate([self.tiles[k] for k in chosen.tolist()]).ravel(), first)

    def replaced(self, window: Window, chosen: Index) -> Self:
        """The same with the tiles of a window that have these numbers."""
        tiles, side = list(self.tiles), self.tiles[0].shape
        for k, first in zip(chosen.tolist(), window.first[chosen].tolist(), strict=True):
            tile = window.cells[first : first + self.tiles[0].size]
            tiles[k] = _frozen(tile.reshape(side).copy())
        return type(self)(self.shape, tuple(tiles))

    def _parts(self) -> list[tuple[Any, ...]]:
        """The cells of each tile, as an index that gives an array for any number of axes."""
        corners = product(*(range(0, n, TILE) for n in self.shape))
        return [(*(slice(first, first + TILE) for first in corner), ...) for corner in corners]


@lru_cache
def _empty_tile(dimension: int) -> Steps:
    """The tile without any step, which all images share."""
    return _frozen(np.full((TILE,) * dimension, NEVER, np.int32))


def _frozen(tile: Steps) -> Steps:
    tile.flags.writeable = False
    return tile
