"""The scale space of a volume: the fields of each of its scales, built on first use."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import lru_cache, partial
from threading import RLock
from typing import Literal

import numpy as np

from cpm_core.field.scale_space import SourceImages
from cpm_core.field.volume.volume_field import VolumeField, build_volume_field
from cpm_core.image.image import Image
from cpm_core.image.pyramid import shape_of_scale, to_image
from cpm_core.image.volume_regions import VolumeRegions
from cpm_core.numerics.types import Mask
from cpm_core.numerics.vectors import Vector
from cpm_core.parameters import DEFAULTS, OF_PLANES, Parameters
from cpm_core.parameters.choices import Accuracy

LONGEST = 10.0
"""Side that a voxel has at most for particles, in units of the smallest one.

Particles are about two units apart. Along a longer side they would stand closer than the voxels can tell them apart,
and be so many that a run takes minutes. Measures of the surface count the side as long as it is.
"""


class VolumeSpace:
    """Fields of a volume at its scales, for any parameters; threads may share it."""

    def __init__(self, image: Image, scales: int, regions: VolumeRegions | None = None) -> None:
        self._pitch, self._sources = pitch_of(image.spacing), SourceImages(image.values, scales)
        self._limit(regions, None)

    def _limit(self, regions: VolumeRegions | None, known: Callable[..., VolumeField] | None) -> None:
        """Take other regions; `known` has the fields of the same regions of interest."""
        kept = lru_cache(len(self))
        self._regions, self._lock = regions, RLock()
        self._edges = known or kept(partial(_edges_of, self._sources, self._pitch, regions))
        self._fields = kept(partial(_field_of, self._edges, self._sources.original[0].shape, self._pitch, regions))

    def __len__(self) -> int:
        return len(self._sources.original)

    def with_regions(self, regions: VolumeRegions | None) -> VolumeSpace:
        """The same volume with other regions; with the same regions of interest the fields are taken over."""
        other = copy(self)
        other._limit(regions, self._edges if _interest(regions) == _interest(self._regions) else None)
        return other

    def at(self, scale: int, parameters: Parameters) -> VolumeField:
        """Fields of a scale; ValueError for parameters that have no meaning in a volume."""
        check_parameters(parameters)
        edges = scale, parameters.gamma, parameters.smoothing, parameters.edge_floor
        with self._lock:
            return self._fields(parameters.exponent_in(3), parameters.accuracy, *edges)

    def prepare(self, parameters: Parameters) -> None:
        """Check the parameters; the fields are built when a run needs them."""
        check_parameters(parameters)


def _edges_of(
    sources: SourceImages,
    pitch: Vector,
    regions: VolumeRegions | None,
    scale: int,
    gamma: float | Literal["auto"],
    smoothing: float | Literal["auto"],
    edge_floor: float,
) -> VolumeField:
    """Fields of a scale without walls."""
    values = sources.at(scale, "luminance", "gradient", gamma, 0.0).values  # not cleaned
    return build_volume_field(values, pitch, smoothing, edge_floor, _voxels(regions, sources.original[0].shape, scale))


def _field_of(
    edges: Callable[..., VolumeField],
    shape: tuple[int, ...],
    pitch: Vector,
    regions: VolumeRegions | None,
    exponent: float,
    accuracy: Accuracy,
    scale: int,
    *key: object,
) -> VolumeField:
    """Fields of a scale with the walls that no particle crosses."""
    found = edges(scale, *key)
    if (found.exponent, found.accuracy) != (exponent, accuracy):
        found = found.with_far_field(exponent, accuracy)
    return found if regions is None else found.with_walls(regions.walls(shape).at_scale(scale, pitch))


def _voxels(regions: VolumeRegions | None, shape: tuple[int, ...], scale: int) -> Mask | None:
    """Which voxels of a scale are of interest: those whose centers are."""
    voxels = None if regions is None else regions.voxels(shape)
    if voxels is None or scale == 0:
        return voxels
    axes = []
    for axis, (count, full) in enumerate(zip(shape_of_scale(shape, scale), shape, strict=True)):
        centers = np.zeros((count, 3))
        centers[:, axis] = np.arange(count)
        centers = to_image(centers, scale, shape)[:, axis]
        axes.append(np.clip(np.rint(centers), 0, full - 1).astype(int))
    return np.asarray(voxels[np.ix_(*axes)])


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
