"""The scale space of a volume: the fields of each of its scales, built on first use."""

from __future__ import annotations

from collections import OrderedDict
from copy import copy
from dataclasses import replace
from threading import Lock

import numpy as np

from cpm_core.field.source_images import SourceImages
from cpm_core.field.volume.volume_field import VolumeField, build_volume_field
from cpm_core.image.image import Image
from cpm_core.image.pyramid import shape_of_scale, to_image
from cpm_core.image.volume_barriers import Walls
from cpm_core.image.volume_regions import VolumeRegions
from cpm_core.numerics.types import Mask
from cpm_core.numerics.vectors import Vector
from cpm_core.parameters import DEFAULTS, OF_PLANES, Parameters

_Key = tuple[int, float | str, float | str, float, float, str]
"""Scale, gamma, smoothing and edge floor, from which the edges follow, and exponent and accuracy of their field."""

_EDGES = 4
"""Entries of a key that the edges depend on."""

LONGEST = 10.0
"""Side that a voxel has at most for particles, in units of the smallest one.

Particles are about two units apart. Along a longer side they would stand closer than the voxels can tell them apart,
and be so many that a run takes minutes. Measures of the surface count the side as long as it is.
"""

_KEPT_SETTINGS = 1
"""Settings whose fields are kept: those of a volume take much memory."""


class VolumeSpace:
    """Fields of a volume at its scales, for any parameters; threads may share it."""

    def __init__(self, image: Image, scales: int, regions: VolumeRegions | None = None) -> None:
        self._pitch, self._shape = pitch_of(image.spacing), image.shape
        self._sources = SourceImages(image.values, scales)
        self._regions = regions
        self._kept: OrderedDict[_Key, VolumeField] = OrderedDict()
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._sources)

    def with_regions(self, regions: VolumeRegions | None) -> VolumeSpace:
        """The same volume with other regions; with the same regions of interest the fields are taken over."""
        other = copy(self)
        other._regions, other._kept, other._lock = regions, OrderedDict(), Lock()
        if _interest(regions) == _interest(self._regions):
            with self._lock:
                kept = tuple(self._kept.items())
            for key, field in kept:
                other._kept[key] = field.with_walls(other._walls(key[0]))
        return other

    def _walls(self, scale: int) -> Walls | None:
        """What no particle crosses at a scale."""
        return None if self._regions is None else self._regions.walls(self._shape).at_scale(scale, self._pitch)

    def _voxels(self, scale: int) -> Mask | None:
        """Which voxels of a scale are of interest: those whose centers are."""
        voxels = None if self._regions is None else self._regions.voxels(self._shape)
        if voxels is None or scale == 0:
            return voxels
        size = shape_of_scale(self._shape, scale)
        axes = []
        for axis, (count, full) in enumerate(zip(size, self._shape, strict=True)):
            centers = np.zeros((count, 3))
            centers[:, axis] = np.arange(count)
            centers = to_image(centers, scale, self._shape)[:, axis]
            axes.append(np.clip(np.rint(centers), 0, full - 1).astype(int))
        return np.asarray(voxels[np.ix_(*axes)])

    def at(self, scale: int, parameters: Parameters) -> VolumeField:
        """Fields of a scale; ValueError for parameters that have no meaning in a volume."""
        check_parameters(parameters)
        far = parameters.exponent_in(len(self._shape)), parameters.accuracy
        key = scale, parameters.gamma, parameters.smoothing, parameters.edge_floor, *far
        with self._lock:
            known = next((field for of, field in self._kept.items() if of[:_EDGES] == key[:_EDGES]), None)
            if key not in self._kept and known is not None:
                self._kept[key] = known.with_far_field(*far)
            elif key not in self._kept:
                values = self._sources.at(scale, replace(parameters, smoothing=0.0)).values  # not cleaned
                own = parameters.smoothing, parameters.edge_floor, self._voxels(scale), self._walls(scale)
                built = build_volume_field(values, self._pitch, *own)
                self._kept[key] = built.with_far_field(*far)
            self._kept.move_to_end(key)
            while len(self._kept) > _KEPT_SETTINGS * len(self):
                self._kept.popitem(last=False)
            return self._kept[key]

    def prepare(self, parameters: Parameters) -> None:
        """Check the parameters; the fields are built when a run needs them."""
        check_parameters(parameters)


def _interest(regions: VolumeRegions | None) -> tuple[object, ...]:
    return regions.interest if regions is not None else ()


def pitch_of(spacing: tuple[float, ...]) -> Vector:
    """Sides of the voxels of a volume for particles, in units of the smallest one: no more than `LONGEST`."""
    least = min(spacing)
    plane, row, col = (min(side / least, LONGEST) for side in spacing)
    return plane, row, col


def check_parameters(parameters: Parameters) -> None:
    """Raise a `ValueError` unless the parameters that have a meaning in the plane only have their default values."""
    for name in OF_PLANES:
        value = getattr(parameters, name)
        if value != DEFAULTS[name]:
            shown = f"{value:g}" if isinstance(value, float) else repr(value)
            raise ValueError(
                f"{name} is {shown} but has no meaning in a volume: leave it at {DEFAULTS[name]}, "
                'as PRESETS["volume"] does.'
            )
