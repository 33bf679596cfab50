"""Regions of an image, each of which may be an object.

They are what closed contours enclose, what several contours enclose that meet, parts between contours with gaps, and
merged basins of the edge map. Most are no objects, and many nearly the same.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.contours.faces import find_faces
from cpm_core.numerics.grids import Window, bounding_window, expand_window
from cpm_core.numerics.types import Array, Extent, Mask, record
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.merged_basins import MIN_OBJECT_AREA
from cpm_core.objects.partition import Partition

_MAX_REGION_SHARE = 0.9
"""Largest share of the image that a region covers."""

_MAX_WHOLE_SHARE = 0.4
"""Largest share of the image that an enclosed region covers whose parts only contours bound."""

_MIN_WHOLE_AREA = 1.2
"""Least area of a region, in areas of a part of it."""

_PART_SHARE = 0.7
"""Share of a part that lies in it."""

_MIN_JOINED_SHARE = 0.25
"""Least share of a region that an enclosed one covers which was joined to others."""

_SAME_REGION_IOU = 0.9
"""Overlap (intersection over union) above which two regions are the same."""

_LEVEL_RIM_WIDTH = 3
"""Width of the rims on both sides of a boundary whose gray levels are compared [px]."""

_MAX_HOLE_DIFFERENCE = 0.33
"""Largest difference between a hole and the surroundings, as a fraction of that between the hole and the region."""

_HOLE_SHARE = 0.5
"""Share of a region above which it lies in the holes of another."""

_FILLED_IOU = 0.8
"""Overlap (intersection over union) with another and its holes above which a region is the two together."""

_MIN_BODY_SHARE = 0.1
"""Least area of a body beyond a neck, as a fraction of the region."""

_MAX_CUT_SHARE = 0.5
"""Largest share of the outer boundary of a region that may run along the border of the regions of interest."""


class BoundedRegion(NamedTuple):
    """Pixels of an image: `mask` in a `box`, and whether an unambiguous contour encloses them."""

    box: Window
    mask: Mask
    unambiguous: bool = False

    @classmethod
    def from_mask(cls, mask: Mask, corner: tuple[int, ...] = (0, 0), *, unambiguous: bool = False) -> BoundedRegion:
        """Make the region of the true pixels of a mask whose first pixel is at a corner of the image."""
        box = bounding_window(mask)
        place = tuple(slice(side.start + at, side.stop + at) for side, at in zip(box, corner, strict=True))
        return cls(place, mask[box], unambiguous)

    @property
    def area(self) -> int:
        """Number of its pixels."""
        return int(np.count_nonzero(self.mask))

    @property
    def has_holes(self) -> bool:
        """Whether it has holes."""
        return not np.array_equal(self.filled.mask, self.mask)

    @property
    def filled(self) -> BoundedRegion:
        """The region with its holes."""
        return self._replace(mask=scipy.ndimage.binary_fill_holes(self.mask))

    def paste(self, shape: Extent) -> Mask:
        """Paste it into a mask of the image, shape (H, W)."""
        whole = np.zeros(shape, bool)
        whole[self.box] = self.mask
        return whole

    def cut_out(self, window: Window) -> Mask:
        """Cut its pixels out of the image in a window that holds its box."""
        found = np.zeros([side.stop - side.start for side in window], bool)
        found[tuple(slice(a.start - w.start, a.stop - w.start) for a, w in zip(self.box, window, strict=True))] = (
            self.mask
        )
        return found

    def measure_overlap(self, other: BoundedRegion) -> int:
        """Measure the number of pixels that it has in common with another."""
        low = [max(a.start, b.start) for a, b in zip(self.box, other.box, strict=True)]
        high = [min(a.stop, b.stop) for a, b in zip(self.box, other.box, strict=True)]
        if any(first >= end for first, end in zip(low, high, strict=True)):
            return 0
        one, two = (
            region.mask[tuple(slice(a - s.start, b - s.start) for a, b, s in zip(low, high, region.box, strict=True))]
            for region in (self, other)
        )
        return int(np.count_nonzero(one & two))

    def compute_iou(self, other: BoundedRegion) -> float:
        """Compute the overlap (intersection over union) with another."""
        both = self.measure_overlap(other)
        return both / (self.area + other.area - both)

    def is_part_of(self, other: BoundedRegion) -> bool:
        """Return whether it lies in another that is larger."""
        return other.area >= _MIN_WHOLE_AREA * self.area and self.measure_overlap(other) >= _PART_SHARE * self.area

    def is_joined_from(self, other: BoundedRegion) -> bool:
        """Return whether another, and not merely a small one, lies in it."""
        return other.area >= _MIN_JOINED_SHARE * self.area and other.is_part_of(self)

    def is_brighter_outside(self, values: Array) -> bool:
        """Return whether an image of gray levels, shape (H, W), gets brighter outward across its boundary."""
        inner, outer = self.measure_rim_levels(values)
        return outer > inner

    def measure_cut_share(self, interest: Mask) -> float:
        """Measure the share of its outer boundary that runs along the border of the pixels of interest, shape (H, W).

        Where it runs along the border of the image does not count.
        """
        window = expand_window(self.box, 1, interest.shape)
        if interest[window].all():
            return 0.0
        mask = self.filled.cut_out(window)
        around = scipy.ndimage.binary_dilation(mask) & ~mask
        return float((~interest[window])[around].mean()) if around.any() else 0.0

    def measure_rim_levels(self, values: Array) -> tuple[float, float]:
        """Measure the mean gray level inside and outside of its outer boundary, in an image of shape (H, W)."""
        window = expand_window(self.box, _LEVEL_RIM_WIDTH, values.shape)
        mask = self.filled.cut_out(window)
        core = scipy.ndimage.binary_erosion(mask, iterations=_LEVEL_RIM_WIDTH, border_value=1)
        around = scipy.ndimage.binary_dilation(mask, iterations=_LEVEL_RIM_WIDTH) & ~mask
        rim = self.cut_out(window) & ~core
        levels = (float(values[window][part].mean()) if part.any() else math.nan for part in (rim, around))
        inner, outer = levels
        return inner, outer


@record
class CandidateRegions:
    """The regions of an image that may be objects.

    Attributes
    ----------
    regions : list of BoundedRegion
        The regions, each once.
    pierced : list of BoundedRegion
        Those with a hole through which the surroundings are seen.
    values : ndarray, shape (H, W)
        Gray levels of the image.
    interest : ndarray of bool, shape (H, W)
        Pixels in the regions of interest, whose border bounds no object.
    """

    regions: list[BoundedRegion]
    pierced: list[BoundedRegion]
    values: Array
    interest: Mask

    @classmethod
    def from_parts(cls, parts: ImageParts) -> CandidateRegions:
        """Find the regions of an image; a contour around a region has the preference over a part."""
        partition = parts.partition
        whole = partition.shape if partition.parent is None else partition.parent.shape
        found = cls([], [], partition.values, partition.interest)
        enclosed = list(_find_enclosed_regions(parts))
        bounded = [*enclosed, *_fill_masks(parts.masks, partition)]
        for region in sorted(bounded, key=lambda one: -one.area):
            if _is_pierced(region, partition.values) and found.may_be_object(region):  # no hole of a larger one
                found.pierced.append(region)
        pixels = math.prod(whole)
        outer = [one for one in enclosed if one.area <= _MAX_WHOLE_SHARE * pixels]
        basins = _fill_masks(parts.merged_masks, partition)
        merged = (
            one for one in basins if not any(one.is_part_of(other) or one.is_joined_from(other) for other in outer)
        )
        for region in itertools.chain(bounded, merged):
            found._add_region(region, _MAX_REGION_SHARE * pixels)
        return found

    def _add_region(self, region: BoundedRegion, most: float) -> None:
        """Add a region unless it is too small, too large, known, or no object."""
        area = region.area
        if not MIN_OBJECT_AREA <= area <= most or not self.may_be_object(region):
            return
        alike = (one for one in self.regions if _SAME_REGION_IOU * area <= one.area <= area / _SAME_REGION_IOU)
        if not any(region.compute_iou(one) >= _SAME_REGION_IOU for one in alike):
            self.regions.append(region)

    def may_be_object(self, region: BoundedRegion) -> bool:
        """Return whether a region is more than a cut-out of interest, no hole of another, nor one with its holes."""
        if region.measure_cut_share(self.interest) > _MAX_CUT_SHARE:
            return False
        for other in self.pierced:
            filled = other.filled
            inside = region.measure_overlap(filled)
            if not inside:
                continue
            if region.compute_iou(filled) > max(region.compute_iou(other), _FILLED_IOU):
                return False
            in_holes = inside - region.measure_overlap(other)
            if in_holes > _HOLE_SHARE * region.area and (
                region.is_brighter_outside(self.values) != other.is_brighter_outside(self.values)
            ):
                return False
        return True


def _is_pierced(region: BoundedRegion, values: Array) -> bool:
    """Return whether a region has a hole that is about as bright as its surroundings in an image, shape (H, W).

    Lines with several holes are a net, in which these may be objects.
    """
    parts, count = scipy.ndimage.label(region.filled.mask & ~region.mask)
    sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
    large = np.flatnonzero(sizes >= MIN_OBJECT_AREA) + 1
    if len(large) != 1:
        return False
    inner, outer = region.measure_rim_levels(values)
    hole = BoundedRegion.from_mask(parts == large[0], tuple(side.start for side in region.box))
    seen, _ = hole.measure_rim_levels(values)
    return abs(seen - outer) < _MAX_HOLE_DIFFERENCE * abs(seen - inner)


def _find_enclosed_regions(parts: ImageParts) -> Iterator[BoundedRegion]:
    """Find all that contours enclose, alone or where several meet, with duplicates."""
    partition = parts.partition
    for mask in partition.find_unambiguous_objects():
        yield BoundedRegion.from_mask(mask, unambiguous=True)
    for contour in partition.contours:
        if contour.closed and len(contour.points) > 2:
            yield from _fill_rings([contour.points], partition.interest)
    for face in find_faces(partition.contours, links=partition.links):
        yield from _fill_rings([face.outer], partition.interest)
        if face.holes:
            pierced = (
                one
                for one in _fill_rings([face.outer, *face.holes], partition.interest)
                if _is_pierced(one, partition.values)
            )
            yield from pierced


def _fill_masks(masks: Iterable[tuple[Window, Mask]], partition: Partition) -> Iterator[BoundedRegion]:
    """Fill masks in boxes, except a hole through which the surroundings are seen, where they hold pixels."""
    for box, mask in masks:
        inside = mask & partition.interest[box]
        if inside.any():
            part = BoundedRegion.from_mask(inside, tuple(side.start for side in box))
            yield part if _is_pierced(part, partition.values) else part.filled


def _fill_rings(rings: list[Array], interest: Mask) -> Iterator[BoundedRegion]:
    """Fill the first of some rings, each of shape (K, 2) [px], without what is in the others, where it holds pixels."""
    corner = np.maximum(np.floor(rings[0].min(axis=0)).astype(int), 0)
    end = np.minimum(np.ceil(rings[0].max(axis=0)).astype(int) + 1, interest.shape)
    if (end <= corner).any():
        return
    mask = np.zeros(end - corner, bool)
    for number, ring in enumerate(rings):
        rows, cols = (ring - corner).T
        mask[skimage.draw.polygon(rows, cols, mask.shape)] = number == 0  # type: ignore[no-untyped-call]
    mask &= interest[tuple(map(slice, corner.tolist(), end.tolist()))]
    if mask.any():
        yield BoundedRegion.from_mask(mask, tuple(corner.tolist()))


def has_neck(region: BoundedRegion) -> bool:
    """Return whether a region has a neck between two bodies that may be objects."""
    least = max(MIN_OBJECT_AREA, _MIN_BODY_SHARE * region.area)
    if region.area < 2 * MIN_OBJECT_AREA:
        return False
    bodies = split_at_necks(np.pad(region.mask, 1))
    return bool(np.count_nonzero(np.bincount(bodies.ravel())[1:] >= least) > 1)
