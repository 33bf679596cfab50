"""The fields of a run, limited to the area of its start and to the edges that hold particles there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from threading import Lock

import numpy as np

from cpm_core.field.scale_field import LARGE_IMAGE_PIXELS, ScaleField, limit_field
from cpm_core.field.start_area.start_area import find_start_area
from cpm_core.image.pyramid import to_image
from cpm_core.image.regions import Regions
from cpm_core.model.plane.enclosed_regions import BARRIER_CLEARANCE
from cpm_core.model.plane.state import window_around
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, Mask, record
from cpm_core.parameters import UNLIMITED_REACH, Parameters

_KEPT_LOCAL_FIELDS = 6
"""Number of limited fields, and of parts of fields, that are kept: those of all scales of a run."""

_MAX_START_ROOM = 1024.0
"""Largest room around a start in which its area is searched in a large image [px]."""

_SAME_AREA = 0.05
"""Fraction by which an area may change from one window of a large image to the next larger one and be the same."""


@record
class StartArea:
    """Area of a start in an image.

    Attributes
    ----------
    inside : ndarray of bool, shape (H, W)
        Its pixels.
    strength : float
        Usual edge strength along its boundary, as a fraction of the largest one.
    """

    inside: Mask
    strength: float


class LocalFields:
    """Areas of starts in an image, and its fields limited to them; threads may share them.

    `field_of` gives the unlimited field of the image for some parameters at a scale.
    """

    def __init__(self, field_of: Callable[[Parameters, int], ScaleField], regions: Regions | None) -> None:
        self._field_of = field_of
        self._regions = regions
        self._known: tuple[ScaleField, Array, StartArea | None] | None = None
        self._limited, self._part = lru_cache(_KEPT_LOCAL_FIELDS)(_limit), lru_cache(_KEPT_LOCAL_FIELDS)(_crop_field)
        self._lock = Lock()

    def field_at(self, scale: int, start: Array, parameters: Parameters, window: Window | None) -> ScaleField:
        """Return the field of a scale, or of a window of it, in a run from a start, shape (N, 2) [px of the image]."""
        field, area = self._field_of(parameters, scale), self.area_of(start, parameters)
        if area is not None:
            field = self._limited(field, area, parameters.weakest_edge, scale)
        return field if window is None else self._part(field, *((side.start, side.stop) for side in window))

    def area_of(self, start: Array, parameters: Parameters) -> StartArea | None:
        """Return the area of a start, shape (N, 2) [px of the image]; None where it does not limit a run."""
        if parameters.reach >= UNLIMITED_REACH:
            return None
        field = self._field_of(parameters, 0)
        with self._lock:
            if self._known is None or self._known[0] is not field or not np.array_equal(self._known[1], start):
                self._known = field, start, self._find_area(field, start)
            return self._known[2]

    def _find_area(self, field: ScaleField, start: Array) -> StartArea | None:
        """Find the area of a start; in a large image in windows, until a larger one has the same."""
        size, found = 0, None
        for part in _parts_around(field, start):
            before = size
            found = find_start_area(part.values.astype(float), start - part.corner, self._closed_pixels(part))
            size = 0 if found is None else int(np.count_nonzero(found[0]))
            if abs(size - before) < _SAME_AREA * size:
                break
        if found is None:
            return None
        area, boundary = found
        along = boundary & _find_ridge(part)
        strength = float(np.median(part.edge_map[along])) if along.any() else 0.0
        inside = np.zeros(field.shape, bool)
        inside[part.window] = area
        return StartArea(inside, strength / max(field.strongest, 1e-300))

    def _closed_pixels(self, field: ScaleField) -> Mask:
        """Return the pixels where no particle goes, in the window of the image that a field covers."""
        closed = np.zeros(field.shape, bool)
        if self._regions is not None and self._regions.interest:
            closed |= ~self._regions.pixel_mask((field.whole or field).shape)[field.window]
        if len(field.barrier_map.segments):
            closed |= field.barrier_map.clearance < BARRIER_CLEARANCE
        return closed


def _parts_around(field: ScaleField, start: Array) -> Iterator[ScaleField]:
    """Yield larger and larger parts of the field of a large image around a start, and at last all of it."""
    room = 0.0
    while field.values.size > LARGE_IMAGE_PIXELS and len(start) and room < _MAX_START_ROOM:
        window = window_around(start, field.shape, room)
        if window is None:
            break
        part = field.crop(window)
        yield part
        room = float(max(part.shape))
    yield field


def _find_ridge(scale_field: ScaleField) -> Mask:
    """Return the pixels on the ridge of an edge: neither of the two neighbors across it is stronger."""
    strength = scale_field.edge_map
    ridge = np.zeros(strength.shape, bool)
    place = np.argwhere(strength >= scale_field.floor)
    if not len(place):
        return ridge
    here = strength[tuple(place.T)]
    normal = scale_field.gradient[(slice(None), *place.T)].T / np.maximum(here, 1e-300)[:, None]
    both = [scale_field.strength_at(place + sign * normal) for sign in (-1.0, 1.0)]
    top = (here >= both[0]) & (here >= both[1])
    ridge[tuple(place[top].T)] = True
    return ridge


def _crop_field(field: ScaleField, *sides: tuple[int, int]) -> ScaleField:
    """Return a scale field cropped to a window, given as ranges along both axes."""
    return field.crop(tuple(slice(*side) for side in sides))


def _limit(field: ScaleField, area: StartArea, weakest_edge: float, scale: int) -> ScaleField:
    """Limit the field of a scale to the area of a start, and to edges not much weaker than those around it."""
    inside = area.inside
    if scale:
        rows, cols = (
            np.rint(to_image(np.arange(n)[:, None].astype(float), scale, (m,))[:, 0]).astype(int).clip(0, m - 1)
            for n, m in zip(field.shape, inside.shape, strict=True)
        )
        inside = inside[np.ix_(rows, cols)]
    return limit_field(field, inside, weakest_edge * area.strength * field.strongest)
