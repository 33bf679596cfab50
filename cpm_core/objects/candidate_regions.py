"""Regions of an image in which objects are looked for.

They are what closed contours enclose, what several contours enclose that meet, parts between contours with gaps, each
of which may be an object, and merged basins of the edge map. Most are no objects, and many nearly the same.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import scipy
import skimage

from cpm_core.contours.faces import find_faces
from cpm_core.contours.rasterize import fill_polygon
from cpm_core.image.region import Region
from cpm_core.numerics.grids import Window, expand_window, first_pixel
from cpm_core.numerics.types import Array, Mask, record
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.merged_basins import MIN_OBJECT_AREA
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Candidate

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

_MIN_SINGLE_SOLIDITY = 0.9
"""Solidity below which a region may be several objects."""

_NECK_SOLIDITY = 0.97
"""Solidity from which a region has no neck."""


def is_brighter_outside(region: Region, values: Array) -> bool:
    """Return whether an image of gray levels, shape (H, W), gets brighter outward across the boundary of a region."""
    inner, outer = _measure_rim_levels(region, values)
    return outer > inner


def _measure_rim_levels(region: Region, values: Array) -> tuple[float, float]:
    """Measure the mean gray level inside and outside of the outer boundary, in an image of shape (H, W)."""
    window = expand_window(region.window, _LEVEL_RIM_WIDTH, values.shape)
    mask = region.filled.cut_out(window)
    core = scipy.ndimage.binary_erosion(mask, iterations=_LEVEL_RIM_WIDTH, border_value=1)
    around = scipy.ndimage.binary_dilation(mask, iterations=_LEVEL_RIM_WIDTH) & ~mask
    rim = region.cut_out(window) & ~core
    levels = (float(values[window][part].mean()) if part.any() else math.nan for part in (rim, around))
    inner, outer = levels
    return inner, outer


def _measure_cut_share(region: Region, interest: Mask) -> float:
    """Measure the share of the outer boundary that runs along the border of the pixels of interest, shape (H, W).

    Where it runs along the border of the image does not count.
    """
    window = expand_window(region.window, 1, interest.shape)
    if interest[window].all():
        return 0.0
    mask = region.filled.cut_out(window)
    around = scipy.ndimage.binary_dilation(mask) & ~mask
    return float((~interest[window])[around].mean()) if around.any() else 0.0


@record
class CandidateRegions:
    """The regions of an image in which objects are looked for.

    Attributes
    ----------
    regions : list of Candidate
        The regions, each once.
    pierced : list of Region
        Those with a hole through which the surroundings are seen.
    values : ndarray, shape (H, W)
        Gray levels of the image.
    interest : ndarray of bool, shape (H, W)
        Pixels in the regions of interest, whose border bounds no object.
    """

    regions: list[Candidate]
    pierced: list[Region]
    values: Array
    interest: Mask

    @classmethod
    def from_parts(cls, parts: ImageParts) -> CandidateRegions:
        """Find the regions of an image; a contour around a region has the preference over a part."""
        partition = parts.partition
        whole = partition.shape if partition.parent is None else partition.parent.shape
        found = cls([], [], partition.values, partition.interest)
        enclosed = list(_find_enclosed_regions(parts))
        between = (Candidate(region, bounded=True) for region in _fill_masks(parts.masks, partition))
        bounded = [*enclosed, *between]
        for region in sorted((one.region for one in bounded), key=lambda one: -one.size):
            if _is_pierced(region, partition.values) and found.may_be_object(region):  # no hole of a larger one
                found.pierced.append(region)
        pixels = math.prod(whole)
        outer = [one.region for one in enclosed if one.region.size <= _MAX_WHOLE_SHARE * pixels]
        several = functools.cache(_may_be_several)
        merged = (
            Candidate(region)
            for region in _fill_masks(parts.merged_masks, partition)
            if not any(is_part_of(region, other) and not several(other) for other in outer)
            and not any(_is_joined_from(region, other) for other in outer)
        )
        for one in itertools.chain(bounded, merged):
            found._add_region(one, _MAX_REGION_SHARE * pixels)
        return found

    def _add_region(self, candidate: Candidate, most: float) -> None:
        """Add a region unless it is too small, too large, known, or no object."""
        region, known = candidate.region, (one.region for one in self.regions)
        may_be_object = MIN_OBJECT_AREA <= region.size <= most and self.may_be_object(region)
        if may_be_object and not is_known(region, known, _SAME_REGION_IOU):
            self.regions.append(candidate)

    def may_be_object(self, region: Region) -> bool:
        """Return whether a region is more than a cut-out of interest, no hole of another, nor one with its holes."""
        if _measure_cut_share(region, self.interest) > _MAX_CUT_SHARE:
            return False
        for other in self.pierced:
            filled = other.filled
            inside = region.count_shared(filled)
            if not inside:
                continue
            if region.compute_iou(filled) > max(region.compute_iou(other), _FILLED_IOU):
                return False
            in_holes = inside - region.count_shared(other)
            if in_holes > _HOLE_SHARE * region.size and (
                is_brighter_outside(region, self.values) != is_brighter_outside(other, self.values)
            ):
                return False
        return True


def _is_pierced(region: Region, values: Array) -> bool:
    """Return whether a region has a hole that is about as bright as its surroundings in an image, shape (H, W).

    Lines with several holes are a net, in which these may be objects.
    """
    parts, count = scipy.ndimage.label(region.filled.mask & ~region.mask)
    sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
    large = np.flatnonzero(sizes >= MIN_OBJECT_AREA) + 1
    if len(large) != 1:
        return False
    inner, outer = _measure_rim_levels(region, values)
    seen, _ = _measure_rim_levels(Region.from_mask(parts == large[0], region.origin), values)
    return abs(seen - outer) < _MAX_HOLE_DIFFERENCE * abs(seen - inner)


def is_known(region: Region, known: Iterable[Region], least_iou: float) -> bool:
    """Return whether a region overlaps by so much (intersection over union) with one of those that are known."""
    area = region.size
    alike = (one for one in known if least_iou * area <= one.size <= area / least_iou)
    return any(region.compute_iou(one) >= least_iou for one in alike)


def is_part_of(part: Region, whole: Region) -> bool:
    """Return whether a region lies in another that is larger."""
    return whole.size >= _MIN_WHOLE_AREA * part.size and part.count_shared(whole) >= _PART_SHARE * part.size


def _is_joined_from(whole: Region, part: Region) -> bool:
    """Return whether another region, and not merely a small one, lies in a region."""
    return part.size >= _MIN_JOINED_SHARE * whole.size and is_part_of(part, whole)


def _find_enclosed_regions(parts: ImageParts) -> Iterator[Candidate]:
    """Find all that contours enclose, alone or where several meet, with duplicates."""
    partition = parts.partition
    for mask in partition.find_unambiguous_objects():
        yield Candidate(Region.from_mask(mask), bounded=True, unambiguous=True)
    found: list[Region] = []
    for contour in partition.contours:
        if contour.encloses_area:
            found += _fill_rings([contour.points], partition.interest)
    for face in find_faces(partition.contours, links=partition.links):
        found += _fill_rings([face.outer], partition.interest)
        if face.holes:
            rings = _fill_rings([face.outer, *face.holes], partition.interest)
            found += (one for one in rings if _is_pierced(one, partition.values))
    for region in found:
        yield Candidate(region, bounded=True)


def _fill_masks(masks: Iterable[tuple[Window, Mask]], partition: Partition) -> Iterator[Region]:
    """Fill masks in boxes, except a hole through which the surroundings are seen, where they hold pixels."""
    for box, mask in masks:
        inside = mask & partition.interest[box]
        if inside.any():
            part = Region.from_mask(inside, first_pixel(box))
            yield part if _is_pierced(part, partition.values) else part.filled


def _fill_rings(rings: list[Array], interest: Mask) -> Iterator[Region]:
    """Fill the first of some rings, each of shape (K, 2) [px], without what is in the others, where it holds pixels."""
    corner = np.maximum(np.floor(rings[0].min(axis=0)).astype(int), 0)
    end = np.minimum(np.ceil(rings[0].max(axis=0)).astype(int) + 1, interest.shape)
    if (end <= corner).any():
        return
    mask = np.zeros(end - corner, bool)
    for number, ring in enumerate(rings):
        mask[fill_polygon(ring - corner, mask.shape)] = number == 0
    mask &= interest[tuple(map(slice, corner.tolist(), end.tolist()))]
    if mask.any():
        yield Region.from_mask(mask, corner)


def measure_solidity(region: Region) -> float:
    """Measure the area of a region with its holes, in areas of its convex hull."""
    find_hull: Callable[[Mask], Mask] = skimage.morphology.convex_hull_image
    return float(region.filled.size / np.count_nonzero(find_hull(region.mask)))


def _may_be_several(region: Region) -> bool:
    """Return whether a region may be several objects that touch: far from convex, or with a neck."""
    solidity = measure_solidity(region)
    return solidity < _MIN_SINGLE_SOLIDITY or has_neck(region, solidity)


def has_neck(region: Region, solidity: float) -> bool:
    """Return whether a region of some solidity has a neck between two bodies that may be objects."""
    if solidity >= _NECK_SOLIDITY or region.size < 2 * MIN_OBJECT_AREA:
        return False
    least = max(MIN_OBJECT_AREA, _MIN_BODY_SHARE * region.size)
    bodies = split_at_necks(np.pad(region.mask, 1))
    return bool(np.count_nonzero(np.bincount(bodies.ravel())[1:] >= least) > 1)
