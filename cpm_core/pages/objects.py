"""Objects followed from page to page: each object of a page is sought on the next one.

It is sought near where its last speed would take it, at the place where the page looks most like it (normalized cross-
correlation: Lewis, Vision Interface 1995). An unambiguous closed region there is the object; elsewhere the network
completes the moved object. Identity, splits and merges are decided as for contours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy
import skimage
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.image.image import Image
from cpm_core.numerics.grids import bounding_window, first_pixel, lie_inside, measure_depth, true_bounds
from cpm_core.numerics.types import Array, Callback, Index, Mask, record
from cpm_core.objects import Partition, Selection, compute_iou
from cpm_core.objects.partition import drop_fragments
from cpm_core.objects.prior.object_predictor import SAME_OBJECT_IOU
from cpm_core.pages.follow import PageFollower, describe_error
from cpm_core.pages.page import Page
from cpm_core.pages.tracks import MIN_PART_FRACTION, MIN_TRACK_OVERLAP, Tracker, TrackEvent, find_origins
from cpm_core.results import objects_result
from cpm_core.results.result import Result

_TEMPLATE_MARGIN = 0.25
"""Margin around an object that is compared as well, in lengths of the object."""

_DISTANCE_PENALTY = 0.1
"""Penalty of the likeness of a place one object length away from the expected one."""

_MIN_CLOSED_IOU = 0.5
"""Overlap from which a closed region is the object that is sought."""

_CORE_DEPTH = 0.4
"""Depth from which pixels of the moved object surely belong to it, as a share of the largest depth."""

_CONTRAST_RING_WIDTH = 4
"""Width of the ring that an object is compared with [px]."""

_MIN_CONTRAST_KEPT = 0.5
"""Share of its contrast with that ring that an object has to keep."""

_MIN_PIECE_SHARE = 0.2
"""Share of an object from which a separate part of it is an object of its own."""


@record
class FollowedObject:
    """An object that has been found again, or that has split off another one.

    Attributes
    ----------
    number : int
        Its number, the same as on the page before; a new one if it has split off.
    origin : int
        Number of the object on the page before that it continues, or that it has split off.
    selection : Selection
        The object.
    """

    number: int
    origin: int
    selection: Selection


class ObjectFollower:
    """Follows objects from page to page."""

    def __init__(self, tracks: int = 0) -> None:
        """Start with a number of `tracks` that are known: new ones get larger numbers."""
        self._tracks = tracks
        self._values: Array = np.empty((0, 0))
        self._before: Mapping[int, Selection] = {}
        self._speeds: Mapping[int, Index] = {}

    def remember_page(self, values: Array, objects: Mapping[int, Selection]) -> None:
        """Remember the objects of a page by their numbers, with the gray levels of the page, shape (H, W).

        One without a pixel, between the centers of all, cannot be found again.
        """
        self._tracks = max(self._tracks, *objects, 0)
        objects = {number: one for number, one in objects.items() if one.mask.any()}
        known = self._before.keys() & objects.keys()
        middles = {
            number: [np.argwhere(on[number].mask).mean(axis=0) for on in (self._before, objects)] for number in known
        }
        self._speeds = {number: np.rint(now - then).astype(int) for number, (then, now) in middles.items()}
        self._values, self._before = values, objects

    def find_on_page(
        self, number: int, page: Partition, check: Callback = lambda: None
    ) -> tuple[tuple[FollowedObject, ...], tuple[TrackEvent, ...]]:
        """Find the objects of the page before on the page of a number; `check` is called between objects.

        Returns
        -------
        tuple of FollowedObject
            What has been found, by number; nothing on a page of another size, or without objects before it.
        tuple of TrackEvent
            Which objects split, merge, end or leave the image.
        """
        if self._values.shape != page.shape or not self._before:
            return (), ()
        sought = []
        for each, one in self._before.items():
            check()
            speed = self._speeds.get(each, np.zeros(2, int))
            seen = _find_best_match(one.mask, self._values, page.values, speed)
            sought.append(
                _SoughtObject(replace(_find_outer_contour(one), number=each), one.mask, self._values, speed, seen)
            )
        for jumped in [one for one in sought if one.has_jumped]:
            if any(other.is_nearer_to(jumped) for other in sought):
                jumped.stay_where_expected()
        found = _find_sought_objects(sought, page, check)
        taken = np.logical_or.reduce([one.mask for one in found])
        before, now = [one.select_boundary(taken) for one in sought], [_find_outer_contour(one) for one in found]
        contours, events = Tracker(before, self._tracks).assign_tracks(number, now, page.shape)
        origins = find_origins(events)
        begun = {event.track for event in events if event.kind in ("begins", "enters")}
        kept = [
            FollowedObject(contour.number, origins.get(contour.number, contour.number), one)
            for contour, one in zip(contours, found, strict=True)
            if contour.number not in begun
        ]
        return tuple(sorted(kept, key=lambda one: one.number)), tuple(one for one in events if one.track not in begun)


def follow_objects(
    pages: Sequence[Image],
    found_on: Callable[[Image], Result],
    inside: ArrayLike,
    outside: ArrayLike,
    numbers: Sequence[int],
    model: str = "",
) -> Iterator[Page]:
    """Follow the object that points select on the first page through the others, up to a page without it.

    Parameters
    ----------
    pages : sequence of Image
        The pages.
    found_on : callable
        Finds the contours of a page.
    inside, outside : array_like, shape (M, 2) and (K, 2)
        Positive and negative points [px].
    numbers : sequence of int
        Which pages, from 1, in the order in which they are followed.
    model : str
        The larger model that answers in place of the network.

    Yields
    ------
    Page
        Each page as soon as it is done; a page that cannot be used, or without the object, has an error message.
    """
    follower, followed, objects = ObjectFollower(), PageFollower(), dict[int, Selection]()
    for number in numbers:
        try:
            image = pages[number - 1]
            part = Partition.from_result(found_on(image), model)
        except (ValueError, MemoryError) as error:
            yield Page(number, None, error=describe_error(error))
            continue
        if objects:
            found, _ = follower.find_on_page(number, part)
            objects = {one.number: one.selection for one in found}
        else:
            chosen = part.select(inside, outside)
            objects = {1: chosen} if chosen.has_boundary else {}
        if not objects:
            yield Page(number, None, error="There is no object at this position.")
            return
        follower.remember_page(part.values, objects)
        made = objects_result(list(objects.values()), image, [f"object {each}" for each in objects], part.channel)
        own = [0, *objects]
        contours = tuple(replace(one, group=own[one.group]) for one in made.contours)
        yield followed.add_page(number, replace(made, contours=contours))


class _SoughtObject:
    """An object of the page before, moved at its last speed, and to where the page looks most like it."""

    def __init__(self, outer: Contour, mask: Mask, values: Array, speed: Index, seen: Index) -> None:
        self._bounds = [replace(outer, points=outer.points + by) for by in (speed, seen)]
        self.expected, self.mask = _shift_mask(mask, speed), _shift_mask(mask, seen)
        self._away = float(np.hypot(*(seen - speed)))
        self._pieces = len(_find_large_pieces(mask))
        self._contrast = _measure_contrast(mask, values)
        self._distinct = abs(self._contrast) > values[mask].std()

    @property
    def has_jumped(self) -> bool:
        """Whether it is seen apart from where it was expected."""
        return bool(self.mask.any() and not (self.mask & self.expected).any())

    def is_nearer_to(self, other: _SoughtObject) -> bool:
        """Return whether it is seen where another object is, but was expected nearer to there."""
        if self._away >= other._away:
            return False
        low, high = true_bounds(other.mask)
        box = tuple(map(slice, low, high + 1))
        shared, own = np.count_nonzero(self.mask[box] & other.mask[box]), np.count_nonzero(self.mask)
        return bool(shared > MIN_PART_FRACTION * max(own, np.count_nonzero(other.mask[box])))

    def stay_where_expected(self) -> None:
        """Seek it only where it was expected: what looks like it elsewhere is another object."""
        self.mask, self._bounds = self.expected, self._bounds[:1] * 2

    def select_boundary(self, taken: Mask) -> Contour:
        """Select its boundary where it was expected, or where it is seen if nothing has been found there.

        `taken`, shape (H, W), are the pixels of all objects found.
        """
        there = np.count_nonzero(self.expected & taken) > MIN_TRACK_OVERLAP * np.count_nonzero(self.expected)
        return self._bounds[not there]

    def resembles_object(self, other: Mask, values: Array) -> bool:
        """Return whether an object, shape (H, W), contrasts with its surroundings as this one did, if it did."""
        same = _measure_contrast(other, values) / self._contrast if self._distinct and other.any() else 1.0
        return bool(same > _MIN_CONTRAST_KEPT)

    def contains_most_of(self, other: Mask) -> bool:
        """Return whether most of another object, shape (H, W), lies in it where it was expected."""
        return bool(np.count_nonzero(other & self.expected) > MIN_PART_FRACTION * np.count_nonzero(other))

    def split_if_divided(self, mask: Mask) -> list[Mask]:
        """Split what has been found, shape (H, W), if it has more pieces than the object had before."""
        several = _find_large_pieces(mask)
        return several if len(several) > self._pieces else [mask]


def _find_best_match(mask: Mask, before: Array, now: Array, speed: Index) -> Index:
    """Find how far an object has moved to where a page looks most like it."""
    low, high = true_bounds(mask)
    reach = int((high - low).max()) + 1
    around = int(_TEMPLATE_MARGIN * reach) + 1
    first, last = np.maximum(low - around, 0), np.minimum(high + around + 1, mask.shape)
    rows, cols = (
        np.clip(np.arange(start - reach, stop + reach), 0, side - 1)
        for start, stop, side in zip(first + speed, last + speed, mask.shape, strict=True)
    )
    template = before[first[0] : last[0], first[1] : last[1]]
    likeness = skimage.feature.match_template(now[np.ix_(rows, cols)], template)  # type: ignore[no-untyped-call]
    away = np.hypot(*np.ogrid[-reach : reach + 1, -reach : reach + 1]) / reach
    place = np.unravel_index(np.argmax(likeness - _DISTANCE_PENALTY * away**2), likeness.shape)
    return speed + place - reach


def _find_sought_objects(sought: Sequence[_SoughtObject], page: Partition, check: Callback) -> list[Selection]:
    """Find the sought objects on a page, each once; of two that share pixels, the more similar one comes first."""
    certain, taken = [(one, *true_bounds(one)) for one in page.find_unambiguous_objects()], np.zeros(page.shape, bool)
    found: list[Selection] = []

    def find_certain_near(mask: Mask) -> list[Mask]:
        """Return the unambiguous objects whose box meets that of a mask, each of its shape (H, W)."""
        low, high = true_bounds(mask)
        return [one for one, first, last in certain if (first <= high).all() and (last >= low).all()]

    def find_closed_region(mask: Mask) -> Mask | None:
        several = find_certain_near(mask)
        parts = [one for one in several if np.count_nonzero(one & mask) > MIN_PART_FRACTION * np.count_nonzero(one)]
        whole = np.logical_or.reduce(parts) if parts else mask & False
        best = max((*several, whole), key=lambda one: compute_iou(one, mask))
        return best if compute_iou(best, mask) > _MIN_CLOSED_IOU else None

    def find_object(mask: Mask, own: _SoughtObject) -> Mask:
        check()
        sure = find_closed_region(mask)
        if sure is not None:
            return sure
        core, area = _find_core(mask), float(np.count_nonzero(mask))
        likely = page.complete_object(core, area)
        others = [one.mask for one in sought if one is not own and (one.mask & likely).any()]
        if compute_iou(likely, np.logical_or.reduce([mask, *others])) > max(compute_iou(likely, mask), SAME_OBJECT_IOU):
            likely = page.complete_object(core, area, _find_beside(mask, others))  # they touch, and are what they were
        sure = find_closed_region(likely) if likely.any() else None
        return likely if sure is None else sure

    def add_selection(one: Mask) -> None:
        left = drop_fragments(one & ~taken, one & taken)
        if np.count_nonzero(left) > MIN_PART_FRACTION * np.count_nonzero(one):
            taken[left] = True
            sure = any(np.array_equal(left, each) for each in find_certain_near(left))
            found.append(page.build_selection(left, unambiguous=sure))

    answers = [(each, find_object(each.mask, each)) for each in sought if each.mask.any()]
    for each, mask in sorted(answers, key=lambda pair: -compute_iou(pair[0].mask, pair[1])):
        for part in each.split_if_divided(mask):
            if each.resembles_object(part, page.values):
                add_selection(part)
    for each in sought:  # objects that have split off lie where nothing has been found
        rest = each.expected & ~taken
        if np.count_nonzero(rest) > _MIN_PIECE_SHARE * np.count_nonzero(each.expected):
            parts = [one for one in find_certain_near(rest) if each.contains_most_of(one)]
            for other in parts or [find_object(rest, each)]:
                if each.contains_most_of(other) and each.resembles_object(other, page.values):
                    add_selection(other)
    return found


def _find_outer_contour(one: Selection) -> Contour:
    """Find the outer contour of an object, without its holes and smaller parts."""
    return max(one.contours, key=lambda contour: contour.area)


def _measure_contrast(mask: Mask, values: Array) -> float:
    """Measure how much brighter an object is than its surroundings."""
    low, high = true_bounds(mask)
    box = tuple(map(slice, np.maximum(low - _CONTRAST_RING_WIDTH, 0), high + _CONTRAST_RING_WIDTH + 1))
    mask, values = mask[box], values[box]
    ring = scipy.ndimage.binary_dilation(mask, iterations=_CONTRAST_RING_WIDTH) & ~mask
    return float(np.median(values[mask]) - np.median(values[ring])) if ring.any() else 0.0


def _find_core(mask: Mask) -> Mask:
    """Find the pixels deep inside."""
    depth = scipy.ndimage.distance_transform_edt(mask)
    return np.asarray(depth > _CORE_DEPTH * depth.max())


def _find_beside(mask: Mask, others: Sequence[Mask]) -> Index:
    """Find the deepest pixel of each of the others, as shape (K, 2), that lies beside a mask, within its box."""
    box = bounding_window(mask)
    beside = (measure_depth(other[box] & ~mask[box]) for other in others)
    deepest = [np.unravel_index(depth.argmax(), depth.shape) for depth in beside if depth.any()]
    return np.array(deepest, np.int64).reshape(-1, 2) + first_pixel(box)


def _shift_mask(mask: Mask, by: Index) -> Mask:
    """Shift a mask by whole pixels; those beyond the border are dropped."""
    places = np.argwhere(mask) + by
    places = places[lie_inside(places, mask.shape)]
    moved = np.zeros_like(mask)
    moved[tuple(places.T)] = True
    return moved


def _find_large_pieces(mask: Mask) -> list[Mask]:
    """Find the larger pieces of an object that are apart from each other."""
    parts, _ = scipy.ndimage.label(mask)
    sizes = np.bincount(parts.ravel())
    return [parts == part for part in range(1, len(sizes)) if sizes[part] >= _MIN_PIECE_SHARE * sizes[1:].sum()]
