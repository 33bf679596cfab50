"""The levels of an image: what particles feel at each of its scales, built when it is first asked for."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from cpm_core.edge_map import automatic_smoothing, prepared
from cpm_core.level import Level, build_level
from cpm_core.multiscale import pyramid
from cpm_core.noise import Cleaned
from cpm_core.parameters import Parameters
from cpm_core.regions import Regions

Array = NDArray[np.float64]

_KEPT_SETTINGS = 2
"""Settings whose levels are kept for reuse, so that going back to the last one costs nothing."""


class Levels:
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
        self._kept: OrderedDict[tuple[object, ...], Level] = OrderedDict()
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._pyramid)

    def at(self, scale: int, parameters: Parameters) -> Level:
        """Level of a scale for `smoothing`, `edge_floor` and `max_frame`."""
        key = (scale, parameters.smoothing, parameters.edge_floor, parameters.max_frame)
        with self._lock:
            if key not in self._kept:
                self._kept[key] = self._build(scale, parameters)
                while len(self._kept) > _KEPT_SETTINGS * len(self):
                    self._kept.popitem(last=False)
            self._kept.move_to_end(key)
            return self._kept[key]

    def _build(self, scale: int, parameters: Parameters) -> Level:
        regions = self._regions and self._regions.at_scale(scale, self._image.shape)
        floor, smoothing = parameters.edge_floor, parameters.smoothing
        values = self._pyramid[scale]
        if smoothing == "auto":
            levels, ready = self._ready()
            values, floor = levels[scale], max(floor, ready.floor)
            told = scale == 0 or levels is not self._pyramid  # else the smoothing told is that of the image itself
            smoothing = ready.sigma if told else automatic_smoothing(values)
        return build_level(values, smoothing, floor, regions, parameters.max_frame)

    def _ready(self) -> tuple[tuple[Array, ...], Cleaned]:
        """What the automatic smoothing makes of the image, at all scales."""
        if self._prepared is None:
            ready = prepared(self._image)
            same = ready.image is self._image
            self._prepared = (self._pyramid if same else pyramid(ready.image, len(self)), ready)
        return self._prepared
