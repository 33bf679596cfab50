"""The fields that a run feels whose start decides on the edges that it reaches."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
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


class LocalFields:
    """Reach maps and limited fields of an image; threads may share them.

    `field_of` gives the unlimited field of the image for some parameters at a scale.
    """

    def __init__(self, field_of: Callable[[Parameters, int], ScaleField], regions: Regions | None) -> None:
        self._field_of = field_of
        self._regions = regions
        self._map: tuple[tuple[object, ...], Array, ReachMap | None] | None = None
        self._limited = lru_cache(_KEPT)(_limited)
        self._lock = Lock()

    def at(self, scale: int, start: Array, parameters: Parameters) -> ScaleField:
        """Field of a scale in a run from a start, shape (N, 2) [px of the image]."""
        plain = self._field_of(parameters, scale)
        reached = self.map_of(start, parameters) if is_limited(parameters) else None
        return plain if reached is None else self._limited(plain, reached, budget_of(parameters), scale)

    def map_of(self, start: Array, parameters: Parameters) -> ReachMap | None:
        """How a start, shape (N, 2) [px], reaches the edges of the image; None for one from everywhere."""
        plain = self._field_of(parameters, 0)
        made_of = (plain, id(start), parameters.beta, parameters.w2, parameters.weakest_edge)
        with self._lock:
            if self._map is None or self._map[0] != made_of:
                self._map = made_of, start, reach_map(plain, start, self._closed(plain), parameters)
            return self._map[2]

    def _closed(self, plain: ScaleField) -> Mask:
        """Where no particle goes, shape (H, W)."""
        closed = np.zeros(plain.shape, bool)
        if self._regions is not None and self._regions.interest:
            closed |= ~self._regions.pixels(plain.shape)
        if len(plain.barrier_map.segments):
            closed |= plain.barrier_map.clearance < _AT_BARRIER
        return closed


def _limited(plain: ScaleField, reached: ReachMap, budget: float, scale: int) -> ScaleField:
    """A field limited to the edges that are reached, on the pixels of its scale that contain one of theirs."""
    ridge = reached.within(budget)
    if scale:
        place = np.rint(to_scale(np.argwhere(ridge).astype(float), scale, ridge.shape)).astype(int)
        coarse = np.zeros(plain.shape, bool)
        coarse[tuple(np.clip(place, 0, np.array(plain.shape) - 1).T)] = True
        ridge = np.asarray(scipy.ndimage.binary_closing(coarse) | coarse)
    return limited_to(plain, ridge)
