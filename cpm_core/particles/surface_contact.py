"""Contact of particles with surfaces in a volume: which lie on one, how it is turned, and when it was last new."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cpm_core.numerics.types import Array, Index, Mask


@dataclass(frozen=True, eq=False, slots=True)
class SurfaceContact:
    """Contact of particles with surfaces.

    Attributes
    ----------
    normal : ndarray, shape (N, 3)
        Direction in which the smoothed volume rises at each.
    seated : ndarray of bool, shape (N,)
        Which lie on the ridge of an edge that is strong enough.
    strength : ndarray, shape (N,)
        Edge strength at each.
    woken : ndarray of int64, shape (N,)
        Step of the scale at which new ground was last found near each.
    """

    normal: Array
    seated: Mask
    strength: Array
    woken: Index

    @classmethod
    def none(cls, count: int) -> SurfaceContact:
        """Contact of particles that are not on any surface, awake since the first step."""
        return cls(np.zeros((count, 3)), np.zeros(count, np.bool_), np.zeros(count), np.zeros(count, np.int64))

    @classmethod
    def of_seated(cls, normal: Array, strength: Array, step: int) -> SurfaceContact:
        """Contact of particles that lie on surfaces with these normals, awake since a step."""
        count = len(normal)
        return cls(normal, np.ones(count, np.bool_), strength, np.full(count, step))

    def taken(self, index: Index) -> SurfaceContact:
        """That of the particles with the given indices, in this order."""
        return SurfaceContact(
            self.normal.take(index, axis=0), self.seated[index], self.strength[index], self.woken[index]
        )

    def joined(self, other: SurfaceContact) -> SurfaceContact:
        """That of these particles and others behind them."""
        return SurfaceContact(
            np.concatenate([self.normal, other.normal]),
            np.concatenate([self.seated, other.seated]),
            np.concatenate([self.strength, other.strength]),
            np.concatenate([self.woken, other.woken]),
        )

    def woken_at(self, step: int, which: Mask | None = None) -> SurfaceContact:
        """The same with some particles awake at a step, all of them by default."""
        if which is None:
            return replace(self, woken=np.full_like(self.woken, step))
        return replace(self, woken=np.where(which, step, self.woken))
