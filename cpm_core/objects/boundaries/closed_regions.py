"""Closed regions: the insides of closed contours that the image confirms unambiguously.

Particles close contours around objects, but also around specks of texture. A closed contour is an object as it is, with
its holes, where it is unambiguous (`is_unambiguous`): then no prediction is needed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Literal

import numpy as np
import scipy

from cpm_core.contours.contour import Contour
from cpm_core.contours.rasterize import fill_polygon
from cpm_core.field.edge_map import edge_map
from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.start_area.drawn_area import MIN_DRAWN_PLACES, drawn_area
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import (
    first_pixel,
    flood_from_markers,
    label_parts,
    lie_inside,
    measure_depth,
    nearest_pixels,
)
from cpm_core.numerics.types import Array, Extent, Index, Mask, record

_MAJORITY_SHARE = 0.5
"""Share of a start above which it lies in a region, and of a contour above which it lies in another."""

_DUPLICATE_AREA_RATIO = 0.85
"""Ratio of the area of a region to that of an enclosing one above which the two are the same region."""

_MAX_NECK_RATIO = 0.7
"""Largest width of a neck between two bodies, as a fraction of the width of the narrower one."""

_CONTOUR_TOLERANCE = 2
"""Distance from an unambiguous contour up to which a point contradicts the contour itself [px]."""

_ALLOWED_PERCENTAGE = 5.0
"""Percentage of an edge, and of its inside, that need not fit."""

_MIN_EDGE_RATIO = 3.0
"""Least ratio of the strength of the edge to that of its inside."""

_MIN_WEAK_FRACTION = 0.5
"""Least strength of weak stretches of the edge, in multiples of its median: a weaker edge lies in something larger."""

OWN_EDGE_DISTANCE = 3.0
"""Distance from an edge up to which the edge strength is its own [px]."""


def is_unambiguous(along: Array, inside: Array) -> bool:
    """Return whether the image leaves no doubt about a closed edge.

    Parameters
    ----------
    along : ndarray, shape (N,)
        Edge strength along it.
    inside : ndarray, shape (M,)
        Edge strength of the pixels that it encloses, farther than `OWN_EDGE_DISTANCE` from it. Without any it is a
        detail, which stays ambiguous.
    """
    if not along.size or not inside.size:
        return False
    weak, usual = np.percentile(along, [_ALLOWED_PERCENTAGE, 50.0])
    return bool(
        weak > max(_MIN_EDGE_RATIO * np.percentile(inside, 100.0 - _ALLOWED_PERCENTAGE), _MIN_WEAK_FRACTION * usual)
    )


@record
class ClosedRegion:
    """The region that an unambiguous contour encloses.

    Attributes
    ----------
    box : tuple of slice
        Rows and columns of the image around it, with a margin.
    filled : ndarray of bool, shape of the box
        Pixels whose centers lie inside the contour.
    mask : ndarray of bool, shape of the box
        The filled region without its holes: unambiguous regions directly inside it whose edge rises the other way. An
        inner region whose edge rises the same way, such as a nucleus in a cell, is a part of it.
    brighter_outside : bool
        Whether the image gets brighter outward across the contour.
    """

    box: tuple[slice, slice]
    filled: Mask
    mask: Mask
    brighter_outside: bool

    def box_overlaps(self, other: ClosedRegion) -> bool:
        """Return whether its box has pixels in common with that of another region."""
        sides = zip(self.box, other.box, strict=True)
        return all(one.start < two.stop and two.start < one.stop for one, two in sides)

    def measure_fraction_inside(self, pixels: Index, *, filled: bool = False) -> float:
        """Measure the fraction of pixels, shape (N, 2), that lie in it, or in it with its holes."""
        place = pixels - (self.box[0].start, self.box[1].start)
        place = place[lie_inside(place, self.mask.shape)]
        return float(np.count_nonzero((self.filled if filled else self.mask)[tuple(place.T)])) / len(pixels)

    def cut_at_neck(self, pixel: Index, others: Index) -> Mask | None:
        """Cut off the part around a pixel at a neck towards others, shape (N, 2); None without a neck.

        Returns a mask of the shape of the box.
        """
        markers = np.zeros(self.mask.shape, np.int32)
        for number, pixels in ((2, others), (1, pixel[None])):
            place = pixels - (self.box[0].start, self.box[1].start)
            markers[tuple(place[lie_inside(place, markers.shape)].T)] = number
        depth = measure_depth(self.mask)
        parts = flood_from_markers(-depth, markers, self.mask)
        own, other = parts == 1, parts == 2
        if not own.any() or not other.any():
            return None
        neck = depth[own & scipy.ndimage.binary_dilation(other)].max(initial=0.0)
        return own if neck <= _MAX_NECK_RATIO * min(depth[own].max(), depth[other].max()) else None


class ClosedRegions:
    """The unambiguous regions among closed contours.

    Parameters
    ----------
    contours : sequence of Contour
        Contours; open ones enclose nothing.
    values : ndarray, shape (H, W)
        Image.
    smoothing : float or "auto"
        Sigma of its edge map [px].
    """

    def __init__(self, contours: Sequence[Contour], values: Array, smoothing: float | Literal["auto"] = "auto") -> None:
        closed = [contour for contour in contours if contour.encloses_area]
        self._contours = sorted(closed, key=lambda contour: contour.area)
        self._values, self._smoothing = values, smoothing
        self._regions_by_contour: dict[int, ClosedRegion | None] = {}

    def find_object_around(self, places: Array) -> Mask | None:
        """Find the object, shape (H, W), that points, shape (M, 2) [px], lie in; None unless it is unambiguous.

        It is the smallest unambiguous region that holds more than half of each connected piece of the start.
        """
        if not len(places):
            return None
        found = np.zeros(self._values.shape, bool)
        for piece in self._split_start(places):
            region = next(
                (
                    region
                    for region in self._find_regions_around(piece.mean(axis=0))
                    if region.measure_fraction_inside(piece) > _MAJORITY_SHARE
                ),
                None,
            )
            if region is None:
                return None
            found[region.box] |= region.mask
        return found

    def find_enclosing_masks(self, pixels: Index) -> Iterator[Mask]:
        """Find what closed contours enclose around pixels, shape (N, 2); unambiguous regions first, each (H, W)."""
        unsure = []
        for index in self._find_contours_around(pixels.mean(axis=0)):
            region = self._find_region(index)
            if region is None:
                unsure.append(index)
            elif region.measure_fraction_inside(pixels) > _MAJORITY_SHARE:
                yield self._paste_mask(region)
        for index in sorted(unsure, key=lambda index: -self._contours[index].strength):
            mask = fill_polygon(self._contours[index].points, self._values.shape)
            if mask[tuple(pixels.T)].mean() > _MAJORITY_SHARE:
                yield mask

    def find_objects(self) -> Iterator[Mask]:
        """Find the objects that unambiguous contours enclose, each of shape (H, W), the largest first.

        Holes of other objects are left out: their edge rises the other way than the outermost one.
        """
        found: list[ClosedRegion] = []
        for index in reversed(range(len(self._contours))):
            region = self._find_region(index)
            if region is None:
                continue
            pixels = np.argwhere(region.filled) + first_pixel(region.box)
            near = [other for other in found if other.box_overlaps(region)]
            shares = [other.measure_fraction_inside(pixels, filled=True) for other in near]
            around = [other for other, share in zip(near, shares, strict=True) if share > _MAJORITY_SHARE]
            if any(0.0 < share <= _MAJORITY_SHARE for share in shares) or (
                around and len(pixels) > _DUPLICATE_AREA_RATIO * np.count_nonzero(around[-1].filled)
            ):
                continue
            found.append(region)
            if not around or around[0].brighter_outside == region.brighter_outside:
                yield self._paste_mask(region)

    def correct_mask(self, mask: Mask, pixel: Index, adds: bool, fixed_pixels: Index) -> Mask | None:
        """Correct an object, shape (H, W), by a point that contradicts it; None unless the correction is unambiguous.

        Parameters
        ----------
        mask : ndarray of bool, shape (H, W)
            The object so far.
        pixel : ndarray of int64, shape (2,)
            The point.
        adds : bool
            Whether it is a positive point.
        fixed_pixels : ndarray of int64, shape (N, 2)
            Points of the other kind, which must not change sides.
        """
        steps = np.stack(np.meshgrid(*2 * [np.arange(-_CONTOUR_TOLERANCE, _CONTOUR_TOLERANCE + 1)]), axis=-1).reshape(
            -1, 2
        )
        near = np.clip(pixel + steps, 0, np.array(mask.shape) - 1)
        if 0.0 < mask[tuple(near.T)].mean() < 1.0 and any(
            0.0 < region.measure_fraction_inside(near, filled=True) < 1.0
            for region in self._find_regions_around(pixel, _CONTOUR_TOLERANCE)
        ):
            changed = mask.copy()
            changed[tuple(pixel)] = adds
            return changed
        for region in self._find_regions_around(pixel):
            changed = mask.copy()
            if adds:
                changed[region.box] |= region.mask
            else:
                changed[region.box] &= ~region.filled
            stays = np.array_equal(changed[tuple(fixed_pixels.T)], mask[tuple(fixed_pixels.T)])
            if changed[tuple(pixel)] == adds and stays and changed.any():
                return changed
            part = region.cut_at_neck(pixel, fixed_pixels) if not stays else None
            if part is not None:
                changed = mask.copy()
                changed[region.box][part] = adds
                return changed if changed.any() else None
        return None

    def _paste_mask(self, region: ClosedRegion) -> Mask:
        """Paste the pixels of a region into a mask of the image, shape (H, W)."""
        mask = np.zeros(self._values.shape, bool)
        mask[region.box] = region.mask
        return mask

    def _split_start(self, places: Array) -> Iterator[Index]:
        """Split a start into the pixels of its connected pieces, each of shape (N, 2)."""
        shape = self._values.shape
        if len(places) < MIN_DRAWN_PLACES:
            yield from nearest_pixels(places, shape)[:, None]
            return
        labels, count = label_parts(drawn_area(places, shape))
        for number in range(1, count + 1):
            yield np.argwhere(labels == number)

    def _find_regions_around(self, place: Array | Index, margin: float = 0.0) -> Iterator[ClosedRegion]:
        """Find the unambiguous regions whose box, widened by a margin, holds a point; the smallest first."""
        for index in self._find_contours_around(place, margin):
            region = self._find_region(index)
            if region is not None:
                yield region

    def _find_contours_around(self, place: Array | Index, margin: float = 0.0) -> list[int]:
        """Find the contours whose box, widened by a margin, holds a point; the smallest first."""
        low, high = self._boxes[:, 0] - margin, self._boxes[:, 1] + margin
        return np.flatnonzero(((low <= place) & (place <= high)).all(axis=1)).tolist()

    @cached_property
    def _edge_strength(self) -> Array:
        """Edge map, smoothed so that noise is no evidence against a contour, shape (H, W)."""
        return edge_map(self._values, self._smoothing)

    @cached_property
    def _boxes(self) -> Array:
        """Lowest and highest row and column of each contour, shape (K, 2, 2)."""
        return np.array([contour.box for contour in self._contours]).reshape(-1, 2, 2)

    def _find_region(self, index: int) -> ClosedRegion | None:
        """Find the region that a contour encloses; None unless it is unambiguous."""
        if index not in self._regions_by_contour:
            self._regions_by_contour[index] = self._build_region(
                self._contours[index], self._find_contours_within(index)
            )
        return self._regions_by_contour[index]

    def _find_contours_within(self, index: int) -> list[int]:
        """Find the contours whose boxes lie in that of another contour."""
        low, high = self._boxes[index]
        inside = (self._boxes[:index, 0] >= low).all(axis=1) & (self._boxes[:index, 1] <= high).all(axis=1)
        return np.flatnonzero(inside).tolist()

    def _build_region(self, contour: Contour, within: Sequence[int]) -> ClosedRegion | None:
        """Build the region of a contour around others, and return it if it is unambiguous."""
        margin = int(OWN_EDGE_DISTANCE) + 1
        low = np.maximum(np.floor(contour.box[0]).astype(int) - margin, 0)
        high = np.minimum(np.ceil(contour.box[1]).astype(int) + margin + 1, self._values.shape)
        box = slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))
        strength, values = self._edge_strength[box], self._values[box]
        filled, off = fill_polygon(contour.points - low, strength.shape), np.ones(strength.shape, bool)
        off[_rasterize_contour(contour, low, off.shape)] = False
        at_contour = scipy.ndimage.distance_transform_edt(off) <= OWN_EDGE_DISTANCE
        if not (at_contour & filled).any() or not (at_contour & ~filled).any():
            return None
        rises = bool(values[at_contour & ~filled].mean() > values[at_contour & filled].mean())
        mask, known = filled.copy(), np.zeros_like(filled)
        for index in reversed(within):  # the largest first: contours inside a hole or a part belong to it
            place = _rasterize_contour(self._contours[index], low, off.shape)
            inner = self._find_region(index) if filled[place].mean() > _MAJORITY_SHARE else None
            if inner is not None:
                off[place] = False
                top, left = inner.box[0].start - low[0], inner.box[1].start - low[1]
                part = slice(top, top + inner.filled.shape[0]), slice(left, left + inner.filled.shape[1])
                if inner.brighter_outside != rises and not (known[part] & inner.filled).any():
                    mask[part] &= ~inner.filled
                known[part] |= inner.filled
        inside = strength[filled & (scipy.ndimage.distance_transform_edt(off) > OWN_EDGE_DISTANCE)]
        along = interpolate_field(self._edge_strength[None], polyline.sample_path(contour.path, 0.5))[:, 0]
        return ClosedRegion(box, filled, mask, rises) if is_unambiguous(along, inside) else None


def _rasterize_contour(contour: Contour, corner: Index, shape: Extent) -> tuple[Index, ...]:
    """Rasterize a contour: rows and columns of its pixels in a box of this shape at a corner."""
    points = np.rint(polyline.sample_path(contour.path, 0.5)).astype(np.int64) - corner
    return tuple(np.clip(points, 0, np.array(shape) - 1).T)
