"""Runs of level sets: from the start, by steps as long as is stable, with signed distances every few steps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.methods.level_sets.motion import FARTHEST, REACH, Indices, moved, signed_distance
from cpm_core.objects.methods.states import RegionState, until_at_rest

_FASTEST, _SMOOTHEST = 0.5, 0.2
"""How far a front moves in a step at most [px], and the largest product of time step and weight of the curvature."""

_AGAIN = 5
"""Steps after which the function is made a signed distance again."""

_EVERY, _REST = 40, 0.002
"""A front is at rest when within so many steps it has changed less than this fraction of its pixels."""


@dataclass(frozen=True, eq=False)
class Speeds:
    """What moves a level set; see `motion`: weights of curvature and pressure, shape (H, W), velocity, (2, H, W)."""

    curvature: Array
    pressure: Array
    velocity: Array

    @property
    def time_step(self) -> float:
        """The longest step that is stable."""
        drift = np.abs(self.pressure) + np.abs(self.velocity).sum(axis=0)
        fastest, bending = float(drift.max()), float(np.abs(self.curvature).max())
        return min(_FASTEST / max(fastest, 1e-9), _SMOOTHEST / max(bending, 1e-9))


@dataclass(frozen=True, eq=False)
class Band:
    """Pixels near a front, row by row, as `motion` takes them; see there."""

    first: Indices
    cols: Indices

    @classmethod
    def of(cls, taken: Mask) -> Band:
        """The pixels of a mask."""
        return cls(np.concatenate([[0], np.cumsum(taken.sum(axis=1))]), np.nonzero(taken)[1])

    @cached_property
    def pixels(self) -> tuple[Indices, Indices]:
        """Row and column of each pixel."""
        return np.repeat(np.arange(len(self.first) - 1), np.diff(self.first)), self.cols


_NO_BAND = Band(np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64))


@dataclass(frozen=True, eq=False)
class FrontState(RegionState):
    """A front: the values of a function at the pixels of a band, shape (N,); elsewhere it is `beyond`, shape (H, W)."""

    beyond: Array = field(default_factory=lambda: np.zeros((0, 0)))
    band: Band = _NO_BAND
    near: Array = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def values(self) -> Array:
        """The function, shape (H, W), above 0 inside: the distance from the front where that is near [px]."""
        whole = self.beyond.copy()
        whole[self.band.pixels] = self.near
        return whole

    def function(self) -> tuple[Array, float]:
        """The function, shape (H, W), and the level 0."""
        return self.values, 0.0

    @property
    def sides(self) -> tuple[bool, bool]:
        """Whether there are pixels inside and outside."""
        seen = bool((self.near > 0.0).any()), bool((self.near <= 0.0).any())
        return seen if all(seen) else super().sides


def distance_of(inside: Mask) -> Array:
    """Signed distance from the boundary of a region, shape (H, W), above 0 inside [px]."""
    edt = scipy.ndimage.distance_transform_edt
    return np.where(inside, edt(inside) - 0.5, 0.5 - edt(~inside))


def evolution(inside: Mask, speeds: Speeds, most_steps: int) -> Iterator[FrontState]:
    """States of a front that begins around a region, until it is at rest or vanishes."""
    return until_at_rest(_fronts(inside, speeds), _EVERY, _REST, most_steps)


def _fronts(inside: Mask, speeds: Speeds) -> Iterator[FrontState]:
    phi = np.clip(distance_of(inside), -FARTHEST, FARTHEST)
    band, time, step = Band.of(np.abs(phi) < FARTHEST), speeds.time_step, 0
    beyond, near = phi.copy(), phi[band.pixels]
    while True:
        yield FrontState(step, beyond=beyond, band=band, near=near)
        step += 1
        near = moved(phi, band.first, band.cols, speeds.curvature, speeds.pressure, speeds.velocity, time)
        phi[band.pixels] = near
        if step % _AGAIN == 0:
            phi, *found = signed_distance(phi, band.first, band.cols, REACH)
            band = Band(*found)
            beyond, near = phi.copy(), phi[band.pixels]
