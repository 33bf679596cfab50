"""Where particles have been: their last places, by identity, for as long as they are asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np

from cpm_core.numerics.types import Array, Index

_STILL = 0.05
"""Distance under which a way is not worth drawing [px of the image]."""


class Trails:
    """Ways from each moment to the next, newest first.

    A particle is known by its identity, so that what is born or deleted in between has no way, and none leads from one
    particle to another.

    Parameters
    ----------
    length : int
        Moments that are looked back over.
    """

    def __init__(self, length: int) -> None:
        self._ways: deque[Array] = deque(maxlen=length)
        self._identity: Index = np.empty(0, np.int64)
        self._position: Array = np.empty((0, 2))
        self._step: int | None = None

    def __iter__(self) -> Iterator[Array]:
        """Ways as pairs of positions (row, col) from and to, shape (M, 2, 2), newest first."""
        return reversed(self._ways)

    def __len__(self) -> int:
        return len(self._ways)

    def keep(self, length: int) -> None:
        """Look back over another number of moments."""
        self._ways = deque(self._ways, maxlen=length)

    def forget(self) -> None:
        """Forget everything."""
        self._ways.clear()
        self._step = None

    def add(self, step: int, identity: Index, position: Array) -> None:
        """Add a moment; one that does not lie ahead of the last begins anew.

        Parameters
        ----------
        step : int
            Number of the step.
        identity : ndarray of int64, shape (N,)
            Identities of the particles.
        position : ndarray, shape (N, 2)
            Where they are [px of the image].
        """
        if self._step == step:
            return
        if self._step is None or step < self._step:
            self._ways.clear()
        order = np.argsort(identity, kind="stable")
        identity, position = identity[order], position[order]
        if self._step is not None and step > self._step:
            self._ways.append(self._way(identity, position))
        self._step, self._identity, self._position = step, identity, position

    def _way(self, identity: Index, position: Array) -> Array:
        before = np.searchsorted(self._identity, identity)
        before[before == len(self._identity)] = 0
        known = self._identity[before] == identity if len(self._identity) else np.zeros(len(identity), bool)
        pairs = np.stack([self._position[before[known]], position[known]], axis=1)
        moved = np.abs(pairs[:, 1] - pairs[:, 0]).max(axis=1, initial=0.0) > _STILL
        return np.asarray(pairs[moved])
