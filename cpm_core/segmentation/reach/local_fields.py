"""The fields of a run, limited to the edges that its start reaches."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from threading import Lock

import numpy as np
import scipy

from cpm_core.field.scale_field import LARGE_IMAGE_PIXELS, ScaleField, limit_field_to
from cpm_core.image.pyramid import to_scale
from cpm_core.image.regions import Regions
from cpm_core.model.plane.enclosed_regions import BARRIER_CLEARANCE
from cpm_core.model.plane.state import window_around
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, Mask
from cpm_core.parameters import Parameters
from cpm_core.segmentation.reach.reach_map import ReachMap, build_reach_map, creeping_distance, is_limited

_KEPT_LOCAL_FIELDS = 6
"""Number of limited fields, and of parts of fields, that are kept: those of all scales of a run."""

_MAX_START_ROOM = 1024.0
"""Largest room around a start in which its area is searched in a large image [px]."""


class LocalFields:
    """Reach maps of starts in an image, and its fields limited to what they reach; threads may share them.

    `field_of` gives the unlimited field of the image for some parameters at a scale.
    """

    def __init__(self, field_of: Callable[[Parameters, int], ScaleField], regions: Regions | None) -> None:
        self._field_of = field_of
        self._regions = regions
        self._map: tuple[tuple[object, ...], Array, ReachMap | None] | None = None
        self._limited, self._part = (
            lru_cache(_KEPT_LOCAL_FIELDS)(_limit_to_reached),
            lru_cache(_KEPT_LOCAL_FIELDS)(_crop_field),
        )
        self._lock = Lock()

    def field_at(self, scale: int, start: Array, parameters: Parameters, window: Window | None) -> ScaleField:
        """Return the field of a scale, or of a window of it, in a run from a start, shape (N, 2) [px of the image]."""
        plain = self._field_of(parameters, scale)
        part = plain if window is None else self._part(plain, *((side.start, side.stop) for side in window))
        reached = self.reach_map_of(start, parameters) if is_limited(parameters) else None
        return part if reached is None else self._limited(part, reached, creeping_distance(parameters), scale)

    def reach_map_of(self, start: Array, parameters: Parameters) -> ReachMap | None:
        """Return how a start, shape (N, 2) [px], reaches the edges of the image; None for one from everywhere."""
        plain = self._field_of(parameters, 0)
        made_of = (plain, id(start), parameters.beta, parameters.w2, parameters.weakest_edge)
        with self._lock:
            if self._map is None or self._map[0] != made_of:
                self._map = made_of, start, self._build_map(plain, start, parameters)
            return self._map[2]

    def _build_map(self, plain: ScaleField, start: Array, parameters: Parameters) -> ReachMap | None:
        """Build the map of a start; of a large image in a window that the area of the start does not leave."""
        found, room = None, 0.0
        while plain.values.size > LARGE_IMAGE_PIXELS and (found is None or found.leaves) and room < _MAX_START_ROOM:
            window = window_around(start, plain.shape, room)
            if window is None:
                break
            part = plain.crop(window)
            found = build_reach_map(part, start - part.corner, self._closed_pixels(part), parameters)
            room = float(max(part.shape))
        return found if room else build_reach_map(plain, start, self._closed_pixels(plain), parameters)

    def _closed_pixels(self, field: ScaleField) -> Mask:
        """Return the pixels where no particle goes, in the window of the image that a field covers."""
        closed = np.zeros(field.shape, bool)
        if self._regions is not None and self._regions.interest:
            closed |= ~self._regions.pixel_mask((field.whole or field).shape)[field.window]
        if len(field.barrier_map.segments):
            closed |= field.barrier_map.clearance < BARRIER_CLEARANCE
        return closed


def _crop_field(plain: ScaleField, *sides: tuple[int, int]) -> ScaleField:
    """Return a scale field cropped to a window, given as ranges along both axes."""
    return plain.crop(tuple(slice(*side) for side in sides))


def _limit_to_reached(plain: ScaleField, reached: ReachMap, budget: float, scale: int) -> ScaleField:
    """Limit a field to the edges that are reached, on the pixels of its scale that contain one of theirs."""
    place = (np.argwhere(reached.ridge_within(budget)) + reached.corner).astype(float)
    place = np.rint(to_scale(place, scale, reached.shape)).astype(int) - plain.corner
    ridge = np.zeros(plain.shape, bool)
    ridge[tuple(place[((place >= 0) & (place < plain.shape)).all(axis=1)].T)] = True
    if scale:
        ridge = np.asarray(scipy.ndimage.binary_closing(ridge) | ridge)
    return limit_field_to(plain, ridge)
