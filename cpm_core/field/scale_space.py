"""The scale space of an image: the fields of each of its scales, built on first use.

A scale field depends on what its edges are taken from (`source_images`), the edge floor and the largest width of the
image border. With another edge floor or border only the field is built again, with another smoothing also the gradient.
The barriers do not depend on parameters.
"""

from __future__ import annotations

from collections import OrderedDict
from copy import copy
from threading import Lock

from cpm_core.field.scale_field import LARGE, ScaleField, build_scale_field
from cpm_core.field.source_images import SourceImages
from cpm_core.image.barriers import NO_BARRIERS, BarrierMap, build_barrier_map
from cpm_core.image.colors import Colors
from cpm_core.image.regions import Line, Regions
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_Key = tuple[int, str, str, float | str, float | str, float, float, float]

_SOURCE = 5
"""Entries of a key that say where and what the edges are taken from."""

_KEPT_SETTINGS = 2
"""Settings whose scale fields are kept, so that a return to the last one costs nothing."""


class ScaleSpace:
    r"""Scale fields of an image, shape (\*shape), for any parameters; threads may share it.

    `scales` is the number of scales; `regions` holds regions of interest and barriers in px of the image;
    `colors` those of a color image, whose luminance `image` is.
    """

    def __init__(self, image: Array, scales: int, regions: Regions | None = None, colors: Colors | None = None) -> None:
        self._image = image
        self._regions = regions
        self._sources = SourceImages(image, scales, colors)
        self._kept: OrderedDict[_Key, ScaleField] = OrderedDict()
        self._former: OrderedDict[_Key, ScaleField] = OrderedDict()
        self._lock = Lock()

    def with_regions(self, regions: Regions | None) -> ScaleSpace:
        """Scale space of the same image with other regions.

        With the same regions of interest all scale fields are taken over, except for the barriers; with other ones,
        only what does not depend on them.
        """
        other = copy(self)
        other._regions, other._lock = regions, Lock()
        with self._lock:
            kept, former = self._kept, self._former
            barrier_map = {scale: other._barriers(scale) for scale, *_ in [*kept, *former]}
            kept, former = (
                OrderedDict((key, field.with_barriers(barrier_map[key[0]])) for key, field in fields.items())
                for fields in (kept, former)
            )
        same = _interest(regions) == _interest(self._regions)
        other._kept = kept if same else OrderedDict()
        other._former = former if same else other._newest(OrderedDict({**former, **kept}))
        return other

    def __len__(self) -> int:
        return len(self._sources)

    def at(self, scale: int, parameters: Parameters) -> ScaleField:
        """Scale field; of the parameters it depends on those that invalidate the field."""
        with self._lock:
            self._keep([scale], parameters)
            return self._kept[_key(scale, parameters)]

    def prepare(self, parameters: Parameters) -> None:
        """Build the fields of all scales at once, side by side; of a large image nothing, until a run needs it."""
        if self._image.size > LARGE:
            return
        with self._lock:
            self._keep(list(range(len(self))), parameters)

    def _keep(self, scales: list[int], parameters: Parameters) -> None:
        """Build the missing fields of some scales, and drop those that have not been used for the longest time."""
        missing = [scale for scale in scales if _key(scale, parameters) not in self._kept]
        if missing:
            self._sources.at(0, parameters)  # once, before the scales are shared among the cores

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
        self._kept = self._newest(self._kept)

    def _newest(self, fields: OrderedDict[_Key, ScaleField]) -> OrderedDict[_Key, ScaleField]:
        """Those of some fields that are kept, the last ones."""
        return OrderedDict(list(fields.items())[-_KEPT_SETTINGS * len(self) :])

    def _build(self, scale: int, parameters: Parameters) -> ScaleField:
        regions = self._regions and self._regions.at_scale(scale, self._image.shape)
        source = self._sources.at(scale, parameters)
        floor = max(parameters.edge_floor, source.floor)
        known = self._similar(scale, parameters)
        exponent = parameters.exponent_in(self._image.ndim)
        return build_scale_field(
            source.values, source.smoothing, floor, regions, parameters.max_border, known, exponent
        )

    def _barriers(self, scale: int) -> BarrierMap:
        regions = self._regions and self._regions.at_scale(scale, self._image.shape)
        return build_barrier_map(regions, self._sources.shape(scale)) if regions else NO_BARRIERS

    def _similar(self, scale: int, parameters: Parameters) -> ScaleField | None:
        """The kept field of a scale that has most in common with the one to build: its source, if possible."""
        known = [*self._former.items(), *self._kept.items()]
        wanted = _key(scale, parameters)[:_SOURCE]
        found = [(key[:_SOURCE] == wanted, scale_field) for key, scale_field in known if key[0] == scale]
        return max(found, key=lambda one: one[0])[1] if found else None


def _interest(regions: Regions | None) -> tuple[Line, ...]:
    return regions.interest if regions is not None else ()


def _key(scale: int, parameters: Parameters) -> _Key:
    """What a scale field depends on."""
    own = parameters.channel, parameters.edges, parameters.gamma, parameters.smoothing
    return scale, *own, parameters.edge_floor, parameters.max_border, parameters.exponent_in(2)
