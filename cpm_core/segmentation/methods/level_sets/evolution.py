"""Runs of level sets: from the start, by steps as long as is stable, with signed distances every few steps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask
from cpm_core.segmentation.methods.level_sets.motion import moved, signed_distance
from cpm_core.segmentation.methods.states import LevelSetState, until_at_rest

_FARTHEST, _SMOOTHEST = 0.5, 0.2
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
        return min(_FARTHEST / max(fastest, 1e-9), _SMOOTHEST / max(bending, 1e-9))


def distance_of(inside: Mask) -> Array:
    """Signed distance from the boundary of a region, shape (H, W), above 0 inside [px]."""
    edt = scipy.ndimage.distance_transform_edt
    return np.where(inside, edt(inside) - 0.5, 0.5 - edt(~inside))


def evolution(inside: Mask, speeds: Speeds, most_steps: int) -> Iterator[LevelSetState]:
    """States of a front that begins around a region, until it is at rest or vanishes."""
    return until_at_rest(_fronts(inside, speeds), _EVERY, _REST, most_steps)


def _fronts(inside: Mask, speeds: Speeds) -> Iterator[LevelSetState]:
    phi, time, step = distance_of(inside), speeds.time_step, 0
    while True:
        yield LevelSetState(step, values=phi)
        step += 1
        phi = moved(phi, speeds.curvature, speeds.pressure, speeds.velocity, time)
        if step % _AGAIN == 0:
            phi = signed_distance(phi)
