"""The fields that a run feels whose start decides on the edges that it reaches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock

import numpy as np
import scipy

from cpm_core.field.scale_field import ScaleField, limited_to
from cpm_core.image.pyramid import to_scale
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Array, Mask
from cpm_core.parameters import Parameters
from cpm_core.segmentation.reach.reach_map import ReachMap, budget_of, is_limited, reach_map

_AT_BARRIER = 1.0
"""Distance to a barrier under which it covers a pixel [px]."""

_KEPT = 6
"""Limited fields that are kept: those of all scales of a run."""


@dataclass(frozen=True, eq=False, slots=True)
class _Known:
    """A reach map and what it has been made from."""

    plain: ScaleField
    start: Array
    setting: tuple[float, ...]
    map: ReachMap | None


class LocalFields:
    """Reach maps and limited fields of an image; threads may share them.

    `field_of` gives the unlimited field of the image for some parameters at a scale.
    """

    def __init__(self, field_of: Callable[[Parameters, int], ScaleField], regions: Regions | None) -> None:
        self._field_of = field_of
        self._regions = regions
        self._known: _Known | None = None
        self._limited: list[tuple[ScaleField, ReachMap, float, ScaleField]] = []
        self._lock = Lock()

    def at(self, scale: int, start: Array, parameters: Parameters) -> ScaleField:
        """Field of a scale in a run from a start, shape (N, 2) [px of the image]."""
        plain = self._field_of(parameters, scale)
        if not is_limited(parameters):
            return plain
        reached = self.map_of(start, parameters)
        if reached is None:
            return plain
        budget = budget_of(parameters)
        with self._lock:
            for known, of, most, limited in self._limited:
                if known is plain and of is reached and most == budget:
                    return limited
        limited = limited_to(plain, _at_scale(reached.within(budget), scale, plain.shape))
        with self._lock:
            self._limited = [*self._limited[1 - _KEPT :], (plain, reached, budget, limited)]
        return limited

    def map_of(self, start: Array, parameters: Parameters) -> ReachMap | None:
        """How a start, shape (N, 2) [px], reaches the edges of the image; None for one from everywhere."""
        plain = self._field_of(parameters, 0)
        setting = (parameters.beta, parameters.w2, parameters.weakest_edge)
        with self._lock:
            known = self._known
            if known is None or known.plain is not plain or known.start is not start or known.setting != setting:
                known = _Known(plain, start, setting, reach_map(plain, start, self._closed(plain), parameters))
                self._known = known
            return known.map

    def _closed(self, plain: ScaleField) -> Mask:
        """Where no particle goes, shape (H, W)."""
        closed = np.zeros(plain.shape, bool)
        if self._regions is not None and self._regions.interest:
            closed |= ~self._regions.pixels(plain.shape)
        if len(plain.barrier_map.segments):
            closed |= plain.barrier_map.clearance < _AT_BARRIER
        return closed


def _at_scale(ridge: Mask, scale: int, shape: tuple[int, ...]) -> Mask:
    """Pixels of a scale that contain one of the image."""
    if scale == 0:
        return ridge
    place = np.rint(to_scale(np.argwhere(ridge).astype(float), scale, ridge.shape)).astype(int)
    coarse = np.zeros(shape, bool)
    coarse[tuple(np.clip(place, 0, np.array(shape) - 1).T)] = True
    return np.asarray(scipy.ndimage.binary_closing(coarse) | coarse)
