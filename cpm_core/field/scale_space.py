"""The levels of an image: what particles feel at each of its scales, built when it is first asked for.

A level depends on the smoothing, the edge floor and the widest frame. Another edge floor or frame needs another field,
another smoothing also the gradient of what the pyramid holds; the pyramid and the walls stay whatever is asked for.
"""

from __future__ import annotations

from collections import OrderedDict
from copy import copy
from threading import Lock

from cpm_core.field.edge_map import automatic_smoothing, prepared
from cpm_core.field.scale_field import ScaleField, build_scale_field
from cpm_core.image.barriers import NO_BARRIERS, BarrierMap, build_barrier_map
from cpm_core.image.denoising import Cleaned
from cpm_core.image.pyramid import pyramid
from cpm_core.image.regions import Line, Regions
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_Key = tuple[int, float | str, float, float]

_KEPT_SETTINGS = 2
"""Settings whose levels are kept for reuse, so that going back to the last one costs nothing."""


class ScaleSpace:
    r"""Levels of an image for whatever parameters are asked for; safe to share between threads.

    Parameters
    ----------
    image : ndarray, shape (\*shape)
        Image.
    scales : int
        Number of scales.
    regions : Regions, optional
        Regions of interest and barriers, in px of the image.
    """

    def __init__(self, image: Array, scales: int, regions: Regions | None = None) -> None:
        self._image = image
        self._regions = regions
        self._pyramid = pyramid(image, scales)
        self._prepared: tuple[tuple[Array, ...], Cleaned] | None = None
        self._told: dict[int, float] = {}
        self._kept: OrderedDict[_Key, ScaleField] = OrderedDict()
        self._former: OrderedDict[_Key, ScaleField] = OrderedDict()
        self._lock = Lock()

    def with_regions(self, regions: Regions | None) -> ScaleSpace:
        """Levels of the same image with other regions.

        Where the regions of interest are the same all levels that there are are taken over, but for the walls; where
        they are others, what does not depend on them.
        """
        other = copy(self)
        other._regions, other._lock = regions, Lock()
        with self._lock:
            kept, former, other._told = self._kept, self._former, self._told.copy()
            barrier_map = {scale: other._walls(scale) for scale, *_ in [*kept, *former]}
            kept, former = (
                OrderedDict((key, scale_field.behind(barrier_map[key[0]])) for key, scale_field in levels.items())
                for levels in (kept, former)
            )
        same = _interest(regions) == _interest(self._regions)
        other._kept = kept if same else OrderedDict()
        other._former = former if same else OrderedDict({**former, **kept})
        return other

    def __len__(self) -> int:
        return len(self._pyramid)

    def at(self, scale: int, parameters: Parameters) -> ScaleField:
        """Level of a scale for `smoothing`, `edge_floor` and `max_border`; no other parameter makes it stale."""
        with self._lock:
            self._keep([scale], parameters)
            return self._kept[_key(scale, parameters)]

    def prepare(self, parameters: Parameters) -> None:
        """Build the levels of all scales at once, side by side."""
        with self._lock:
            self._keep(list(range(len(self))), parameters)

    def _keep(self, scales: list[int], parameters: Parameters) -> None:
        """Build what is missing of some scales, and forget what has not been asked for the longest."""
        missing = [scale for scale in scales if _key(scale, parameters) not in self._kept]
        if missing and parameters.smoothing == "auto":
            self._ready()

        def work(first: int, end: int) -> None:
            for scale in missing[first:end]:
                built[scale] = self._build(scale, parameters)

        built: dict[int, ScaleField] = {}
        share(work, len(missing), 1)
        for scale in scales:
            key = _key(scale, parameters)
            if scale in built:
                self._kept[key] = built[scale]
            self._kept.move_to_end(key)
        while len(self._kept) > _KEPT_SETTINGS * len(self):
            self._kept.popitem(last=False)

    def _build(self, scale: int, parameters: Parameters) -> ScaleField:
        regions = self._regions and self._regions.at_scale(scale, self._image.shape)
        floor, smoothing = parameters.edge_floor, parameters.smoothing
        values = self._pyramid[scale]
        if smoothing == "auto":
            levels, ready = self._ready()
            values, floor = levels[scale], max(floor, ready.floor)
            smoothing = self._smoothing(scale)
        return build_scale_field(
            values, smoothing, floor, regions, parameters.max_border, self._akin(scale, parameters)
        )

    def _walls(self, scale: int) -> BarrierMap:
        regions = self._regions and self._regions.at_scale(scale, self._image.shape)
        return build_barrier_map(regions, self._pyramid[scale].shape) if regions else NO_BARRIERS

    def _akin(self, scale: int, parameters: Parameters) -> ScaleField | None:
        """The kept level of a scale that has most in common with what is asked for: the smoothing, if there is one."""
        known = [*self._former.items(), *self._kept.items()]
        found = [(key[1] == parameters.smoothing, scale_field) for key, scale_field in known if key[0] == scale]
        return max(found, key=lambda one: one[0])[1] if found else None

    def _ready(self) -> tuple[tuple[Array, ...], Cleaned]:
        """What the automatic smoothing makes of the image, at all scales."""
        if self._prepared is None:
            ready = prepared(self._image)
            same = ready.image is self._image
            self._prepared = (self._pyramid if same else pyramid(ready.image, len(self)), ready)
        return self._prepared

    def _smoothing(self, scale: int) -> float:
        """What the automatic smoothing is at a scale."""
        levels, ready = self._ready()
        if scale == 0 or levels is not self._pyramid:  # else the smoothing told is that of the image itself
            return ready.sigma
        if scale not in self._told:
            self._told[scale] = automatic_smoothing(levels[scale])
        return self._told[scale]


def _interest(regions: Regions | None) -> tuple[Line, ...]:
    return regions.interest if regions is not None else ()


def _key(scale: int, parameters: Parameters) -> _Key:
    """What a level depends on."""
    return scale, parameters.smoothing, parameters.edge_floor, parameters.max_border
