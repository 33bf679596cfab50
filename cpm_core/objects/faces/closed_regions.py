"""Closed regions: what a contour encloses that particles have closed, and about which the image leaves no doubt.

Particles close contours around objects, but also around flecks of texture. A closed contour is an object as it is, with
its holes, where it is certain (`segmentation.reach.certain`). Then nothing has to be guessed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
import skimage

from cpm_core.contours.contour import Contour
from cpm_core.field.interpolation import interpolate
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.segmentation.reach.certain import MARGIN, is_certain
from cpm_core.segmentation.reach.drawn_area import drawn_area

_LEAST_PLACES = 8
"""Fewer places are clicks; more are a drawn shape, which counts as a whole."""

_AT_CONTOUR = 2
"""Distance from a certain contour up to which a place is at odds with the contour rather than beyond it [px]."""


@dataclass(frozen=True, eq=False)
class ClosedRegion:
    """What a certain contour encloses.

    Attributes
    ----------
    filled : ndarray of bool, shape (H, W)
        Pixels whose centers lie inside the contour.
    mask : ndarray of bool, shape (H, W)
        The same without its holes: the certain regions in it whose edge rises the same way, as from the region to what
        is around it. One that rises the other way, such as a nucleus in a cell, is a part.
    rises : bool
        Whether the image gets brighter outward across the contour.
    """

    filled: Mask
    mask: Mask
    rises: bool


class ClosedRegions:
    """The certain regions among closed contours.

    Parameters
    ----------
    contours : sequence of Contour
        Contours; open ones enclose nothing.
    values, strength : ndarray, shape (H, W)
        Image, and its edge map.
    """

    def __init__(self, contours: Sequence[Contour], values: Array, strength: Array) -> None:
        closed = [contour for contour in contours if contour.closed and len(contour.points) > 2]
        self._contours = sorted(closed, key=lambda contour: contour.area)
        self._values, self._strength = values, strength
        self._known: dict[int, ClosedRegion | None] = {}

    def around(self, places: Array) -> Mask | None:
        """The object, shape (H, W), that a start or clicks mean, shape (M, 2) [px]; None unless that is certain.

        It is the smallest certain region that holds more than half of each connected piece of the start.
        """
        if not len(places):
            return None
        found = np.zeros(self._values.shape, np.bool_)
        for piece in self._pieces(places):
            region = next((region for region in self._over(piece.mean(axis=0)) if _holds(region.mask, piece)), None)
            if region is None:
                return None
            found |= region.mask
        return found

    def changed(self, mask: Mask, pixel: Index, adds: bool, kept: Index) -> Mask | None:
        """An object, shape (H, W), after a place that contradicts it; None unless it is certain what that means.

        Parameters
        ----------
        mask : ndarray of bool, shape (H, W)
            The object so far.
        pixel : ndarray of int64, shape (2,)
            The place.
        adds : bool
            Whether it is inside the object that is meant.
        kept : ndarray of int64, shape (N, 2)
            Places of the other kind, which must not change sides.
        """
        near = tuple(slice(max(at - _AT_CONTOUR, 0), at + _AT_CONTOUR + 1) for at in pixel.tolist())
        for region in self._over(pixel):
            if not region.filled[near].all() and mask[near].any() and not mask[near].all():
                return _flipped(mask, pixel)
            changed = (mask | region.mask) if adds else (mask & ~region.filled)
            decided = changed[tuple(pixel)] == adds and changed.any() and not (changed != mask)[tuple(kept.T)].any()
            if decided:
                return np.asarray(changed)
        for region in self._beside(pixel):
            if region.filled[near].any() and mask[near].any() and not mask[near].all():
                return _flipped(mask, pixel)
        return None

    def _pieces(self, places: Array) -> Iterator[Index]:
        """The pixels of each connected piece of a start, each of shape (N, 2)."""
        shape = self._values.shape
        if len(places) < _LEAST_PLACES:
            yield from np.rint(np.clip(places, 0, np.array(shape) - 1)).astype(np.int64)[:, None]
            return
        labels, count = scipy.ndimage.label(drawn_area(places, shape), np.ones((3, 3), bool))
        for number in range(1, count + 1):
            yield np.argwhere(labels == number)

    def _over(self, place: Array | Index) -> Iterator[ClosedRegion]:
        """The certain regions whose box holds a place, the smallest first."""
        return self._certain((self._boxes[:, 0] <= place) & (place <= self._boxes[:, 1]))

    def _beside(self, pixel: Index) -> Iterator[ClosedRegion]:
        """The certain regions whose box comes near to a pixel."""
        return self._certain((self._boxes[:, 0] - _AT_CONTOUR <= pixel) & (pixel <= self._boxes[:, 1] + _AT_CONTOUR))

    def _certain(self, candidates: Mask) -> Iterator[ClosedRegion]:
        for index in np.flatnonzero(candidates.all(axis=1)).tolist():
            region = self._region(index)
            if region is not None:
                yield region

    @cached_property
    def _boxes(self) -> Array:
        """Lowest and highest row and column of each contour, shape (K, 2, 2)."""
        return np.array([contour.box for contour in self._contours]).reshape(-1, 2, 2)

    def _region(self, index: int) -> ClosedRegion | None:
        """What a contour encloses; None unless it is certain."""
        if index not in self._known:
            self._known[index] = self._made(self._contours[index], self._within(index))
        return self._known[index]

    def _within(self, index: int) -> list[int]:
        """The contours whose boxes lie in that of another one."""
        low, high = self._boxes[index]
        inside = (self._boxes[:index, 0] >= low).all(axis=1) & (self._boxes[:index, 1] <= high).all(axis=1)
        return np.flatnonzero(inside).tolist()

    def _made(self, contour: Contour, within: Sequence[int]) -> ClosedRegion | None:
        shape = self._values.shape
        filled = np.zeros(shape, np.bool_)
        rows, cols = contour.points.T
        filled[skimage.draw.polygon(rows, cols, shape)] = True  # type: ignore[no-untyped-call]
        if not filled.any():
            return None
        box = scipy.ndimage.find_objects(filled.view(np.uint8))[0]
        off = np.ones(filled[box].shape, np.bool_)
        _mark(off, contour, box)
        mask, rises, others = filled.copy(), self._rises(contour, filled), []
        for index in within:
            if not _holds(filled, _pixels(self._contours[index], shape)):
                continue
            inner = self._region(index)
            if inner is not None:
                others.append(inner)
                _mark(off, self._contours[index], box)
        away = scipy.ndimage.distance_transform_edt(off)
        inside = self._strength[box][filled[box] & (away > MARGIN)]
        along = interpolate(self._strength[None], polyline.sampled(contour.path, 0.5))[:, 0]
        if not is_certain(along, inside):
            return None
        for inner in others:
            if inner.rises != rises:  # outward of the hole lies the region
                mask &= ~inner.filled
        return ClosedRegion(filled, mask, rises)

    def _rises(self, contour: Contour, filled: Mask) -> bool:
        """Whether the image is brighter outside of a contour than inside, next to it."""
        pixels = np.zeros_like(filled)
        pixels[tuple(_pixels(contour, filled.shape).T)] = True
        near = scipy.ndimage.binary_dilation(pixels, iterations=int(MARGIN))
        inside, outside = self._values[near & filled], self._values[near & ~filled]
        return bool(inside.size and outside.size and outside.mean() > inside.mean())


def _holds(mask: Mask, pixels: Index) -> bool:
    """Whether more than half of some pixels, shape (N, 2), lie in a mask."""
    return bool(mask[tuple(pixels.T)].mean() > 0.5)


def _pixels(contour: Contour, shape: tuple[int, ...]) -> Index:
    """Pixels that a contour runs through, shape (N, 2)."""
    points = polyline.sampled(contour.path, 0.5)
    return np.rint(np.clip(points, 0, np.array(shape) - 1)).astype(np.int64)


def _mark(off: Mask, contour: Contour, box: tuple[slice, ...]) -> None:
    """Mark where a contour runs in a box by False."""
    corner = np.array([side.start for side in box])
    place = np.clip(np.rint(polyline.sampled(contour.path, 0.5)).astype(np.int64) - corner, 0, np.array(off.shape) - 1)
    off[tuple(place.T)] = False


def _flipped(mask: Mask, pixel: Index) -> Mask:
    """A mask in which one pixel has changed sides."""
    changed = mask.copy()
    changed[tuple(pixel)] = ~changed[tuple(pixel)]
    return changed
