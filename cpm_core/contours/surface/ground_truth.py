"""Ground truth of a volume: the voxels of objects that a surface is compared with."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.ground_truth import Labels, labels_of
from cpm_core.contours.surface import Surface
from cpm_core.contours.surface.of_labels import surface_of_labels
from cpm_core.numerics.real_numbers import real_numbers, voxel_sides
from cpm_core.numerics.types import Array
from cpm_core.parameters.quotation import counted, described, sized

_MOST_OBJECTS = np.iinfo(np.int32).max


@dataclass(frozen=True, eq=False)
class VolumeTruth:
    """The true objects of a volume.

    Attributes
    ----------
    labels : ndarray of int32, shape (P, R, C)
        Object of each voxel: 0 for the background, and 1, 2, ... for objects. With 1 alone the connected parts are the
        objects.
    spacing : tuple of float
        Size of a voxel along (plane, row, col), in `unit`.
    unit : str or None
        Unit of `spacing`; None when it is not known.
    source : str
        Name of the file for the user.
    boundary : Surface or None
        The boundaries of the objects, where they are known better than halfway between voxels.

    Raises
    ------
    ValueError
        When the labels are not whole numbers of at least 0 in three axes.

    Examples
    --------
    >>> volume = cpm.example("ball")
    >>> truth = cpm.VolumeTruth(volume.values > volume.values.mean())
    >>> truth
    <VolumeTruth ground truth, 31 x 31 x 31 voxels, 1 object>
    >>> truth.shape, int(truth.objects.max()), truth.surface.closed
    ((31, 31, 31), 1, True)
    """

    labels: Labels
    spacing: tuple[float, ...] = (1.0, 1.0, 1.0)
    unit: str | None = None
    source: str = "ground truth"
    boundary: Surface | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        given = real_numbers(self.labels)
        if given.ndim != 3 or given.size == 0 or not _are_labels(given):
            raise ValueError(
                "the labels of a volume must be whole numbers of at least 0 with three axes, but those of "
                f"{self.source} have the shape {given.shape} and lie between {given.min(initial=0):g} and "
                f"{given.max(initial=0):g}."
            )
        object.__setattr__(self, "labels", given.astype(np.int32))
        object.__setattr__(self, "spacing", tuple(voxel_sides("The spacing of labels", self.spacing).tolist()))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the volume."""
        return self.labels.shape

    @cached_property
    def objects(self) -> Labels:
        """Labels of the single objects, shape (P, R, C): those of a single class are its connected parts."""
        if self.labels.max(initial=0) > 1:
            return self.labels
        return np.asarray(scipy.ndimage.label(self.labels)[0], dtype=np.int32)

    @cached_property
    def surface(self) -> Surface:
        """The boundaries of the objects, halfway between voxels unless known; the border of the volume is none."""
        if self.boundary is not None:
            return replace(self.boundary, spacing=self.spacing, unit=self.unit)
        found = surface_of_labels(self.labels, self.spacing, self.unit, open_border=True)
        return replace(found, numbers=None)

    def __repr__(self) -> str:
        objects = len(np.unique(self.objects[self.objects > 0]))
        return described("VolumeTruth", self.source, sized(self.shape, "voxels"), counted(objects, "object"))


def _are_labels(values: Array) -> bool:
    """Whether values are whole numbers of at least 0 that a label can have."""
    return bool(values.min() >= 0.0 and values.max() <= _MOST_OBJECTS and (values == np.floor(values)).all())


def truth_of_volume(
    values: NDArray[np.generic], spacing: tuple[float, ...], unit: str | None, source: str = "ground truth"
) -> VolumeTruth:
    """Ground truth from a label volume: its lowest gray level is the background, each other an object.

    ValueError when all voxels are equal, or so many neighbors differ that it is no label volume.
    """
    return VolumeTruth(labels_of(values, source), spacing, unit, source)
