"""The partition of an image into faces, and the choice of an object among them by clicks.

Contours, closed and open, and the ridges of the edge map between them cut the image into faces (`faces`). An object is
what the best of many candidates encloses (`candidates`): sets of faces with the cheapest boundary (`boundary`,
`minimum_cut`) between what has been said to be inside and what to be outside, and regions of like gray levels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.field.edge_map import edge_map
from cpm_core.image import drawing
from cpm_core.image.image import Image, as_image, as_plane
from cpm_core.image.regions import Regions
from cpm_core.model.starts import uniform_grid
from cpm_core.model.volume.starts import everywhere
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.candidates.appearance import Appearance, appearance
from cpm_core.objects.candidates.choice import chosen
from cpm_core.objects.candidates.clicks import as_places, clicked
from cpm_core.objects.faces.basins import Labels
from cpm_core.objects.faces.closed_regions import ClosedRegions
from cpm_core.objects.faces.faces import Faces, Ground, find_faces, ground
from cpm_core.objects.outline import SMOOTHING, outlines
from cpm_core.objects.selection import Selection, confidence_of
from cpm_core.objects.volume_partition import VolumePartition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.quotation import counted, described, sized
from cpm_core.segmentation.evolve import segment
from cpm_core.segmentation.reach.bounding import thing_within

NOWHERE = np.empty((0, 2))
"""No places."""

EVERYWHERE = Parameters(smoothing=1.5)
"""Parameters of the run from everywhere that finds the contours of an image."""


_NOTHING = "No object was found around these places: only their own pixels are chosen."


def partition(values: ArrayLike | Image | Result, params: Parameters | None = None) -> Any:
    """Cut an image into faces along its contours, or a volume into the bodies that its surface encloses.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image, or Result
        An image or a volume, in which a run from everywhere finds the contours or the surface, or the result of a run.
    params : Parameters, optional
        Of the run on an image.

    Returns
    -------
    Partition or VolumePartition
        To select objects from.

    Raises
    ------
    ValueError
        For an unusable image, a result that does not know its image, or a volume without a closed surface.

    Examples
    --------
    >>> partition = cpm.partition(cpm.example("disks"))
    >>> partition.select([(32, 18)])
    <Selection 301 px, 1 contour, 0 gaps, confidence 1.00>
    """
    if not isinstance(values, Result):
        image = as_image(values)
        if image.ndim == 3:
            return partition(segment(image, everywhere(image), params or PRESETS["volume"]))
        return partition(segment(image, uniform_grid(image.shape), params or EVERYWHERE))
    if values.image is None:
        raise ValueError("the result does not know its image: make a partition of the image itself.")
    if values.surface is not None:
        return VolumePartition(values.image, values.surface)
    regions = values.regions if isinstance(values.regions, Regions) else None
    return Partition(as_plane(values.image), tuple(values.contours), regions, values.channel)


@dataclass(frozen=True, eq=False)
class Partition(drawing.Pictured):
    """An image that contours cut into faces.

    Attributes
    ----------
    image : Image
        The image.
    contours : tuple of Contour
        The contours along which it is cut.
    regions : Regions or None
        Outside the regions of interest nothing is selected; barriers are boundaries.
    channel : str
        Channel of a color image that is cut.

    Examples
    --------
    >>> partition = cpm.partition(cpm.example("disks"))
    >>> partition.shape, partition.labels.shape, len(partition.means) > 1, partition.values.shape
    ((64, 64), (64, 64), True, (64, 64))
    >>> chosen = partition.select([(32, 18)], outside=[(32, 46)])
    >>> again = partition.selection_of(chosen.mask, chosen.inside)
    >>> int(chosen.mask.sum()), bool((again.mask == chosen.mask).all())
    (301, True)
    >>> axes = partition.plot()
    """

    image: Image
    contours: tuple[Contour, ...]
    regions: Regions | None = None
    channel: str = "luminance"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the image."""
        return self.image.shape

    @property
    def labels(self) -> Labels:
        """Face of every pixel, shape (H, W); -1 outside the regions of interest."""
        return self._faces.labels

    @property
    def means(self) -> Array:
        """Mean gray level of each face, shape (F,)."""
        return self._faces.graph.mean

    def select(self, inside: ArrayLike, outside: ArrayLike = (), *, previous: Selection | None = None) -> Selection:
        """Choose the object that some places lie in, and others do not.

        Parameters
        ----------
        inside, outside : array_like, shape (M, 2) and (K, 2)
            Places (row, col) [px]. A place outside the image counts as the nearest one in it. The first places inside
            may be a closed line around the object, such as the seeds of a circle.
        previous : Selection, optional
            What was chosen before the last places were added. A new place inside only adds to it, and one outside only
            takes away.

        Returns
        -------
        Selection
            The object; empty when no place is inside.

        Raises
        ------
        ValueError
            When the places are not rows and columns.
        """
        within, beyond = as_places(inside), as_places(outside)
        former = previous.mask if previous is not None and previous.mask.any() else None
        if former is None:
            former = thing = self._closed.around(within)
            if thing is None and not len(beyond):
                thing = thing_within(self.values, within, ~self._ground.interest)
            if thing is not None and thing.any() and not len(beyond):
                return self.selection_of(thing, within)
        meant = within if previous is None else _not_around(within, previous)
        newer = None if previous is None else ~_among(meant, previous.inside)
        found = clicked(self._faces, self._ground, meant, beyond, newer)
        mask = np.zeros(self.shape, np.bool_)
        if len(found.within):
            mask = chosen(self._look, found, self._ground.strong, former, self._closed)
        selection = self.selection_of(mask, within, beyond, found.remark)
        if selection.only_places and not selection.remark:
            return replace(selection, remark=_NOTHING)
        return selection

    def selection_of(
        self, mask: Mask, inside: Array = NOWHERE, outside: Array = NOWHERE, remark: str = ""
    ) -> Selection:
        """Make an object of a set of pixels, shape (H, W); its boundary follows the contours that pass next to it."""
        found = outlines(mask, self._ground)
        contours = tuple(outline.contour for outline in found)
        gaps = tuple(gap for outline in found for gap in outline.gaps)
        return Selection(mask, contours, gaps, confidence_of(found, self._ground), inside, outside, remark)

    @cached_property
    def values(self) -> Array:
        """Gray levels that are cut, shape (H, W)."""
        return self.image.gray(self.channel)

    @cached_property
    def _ground(self) -> Ground:
        values = self.values
        paths = [contour.path for contour in self.contours]
        return ground(values, edge_map(values, SMOOTHING), paths, self.regions)

    @cached_property
    def _faces(self) -> Faces:
        return find_faces(self._ground)

    @cached_property
    def _closed(self) -> ClosedRegions:
        free = self.regions is None or not (self.regions.interest or self.regions.barriers)
        return ClosedRegions(self.contours if free else (), self.values, edge_map(self.values, "auto"))

    @cached_property
    def _look(self) -> Appearance:
        return appearance(self._ground.values, self._ground.strength)

    def __repr__(self) -> str:
        return described("Partition", self.image.source, sized(self.shape), counted(len(self.contours), "contour"))

    def plot(self, ax: drawing.Axes | None = None) -> drawing.Axes:
        """Draw the image with the contours by matplotlib."""
        ax = drawing.axes_for(ax)
        drawing.show_image(ax, self.image.values, self.image.spacing)
        drawing.show_curves(ax, self.contours)
        return ax


def _among(places: Array, others: Array) -> Mask:
    """Which places, shape (N, 2), are among others."""
    return np.asarray((places[:, None] == others[None]).all(axis=2).any(axis=1))


def _not_around(inside: Array, before: Selection) -> Array:
    """Places without those around the object chosen before; instead of them the middle of each part without a place."""
    around = before.inside[~before.holds(before.inside)]
    if not len(around) or not before.mask.any():
        return inside
    rest = inside[~_among(inside, around)]
    parts, count = scipy.ndimage.label(np.pad(before.mask, 1), np.ones((3, 3), bool))
    place = np.clip(np.rint(rest[before.holds(rest)]), 0, np.array(before.mask.shape) - 1).astype(int) + 1
    empty = np.setdiff1d(np.arange(1, count + 1), parts[tuple(place.T)])
    depth = scipy.ndimage.distance_transform_edt(parts > 0)
    middles = np.array(scipy.ndimage.maximum_position(depth, parts, empty), float).reshape(-1, 2) - 1.0
    return np.concatenate([middles, rest])
