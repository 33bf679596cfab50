"""Objects followed from page to page: those of the page before, moved as they have moved, are looked for on the next.

Each is sought near where it would be at the speed that it had, where the page looks most like it (normalized cross-
correlation: Lewis, Vision Interface 1995). What particles have closed there beyond doubt is the object, elsewhere what
the prior makes of the moved object. Which is which, and what splits and merges, is decided as for contours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy
import skimage
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import centroid
from cpm_core.contours.result import Result
from cpm_core.image.image import Image
from cpm_core.numerics.grids import ends
from cpm_core.numerics.types import Array, Callback, Index, Mask, record
from cpm_core.objects import Partition, Selection, objects_result, overlap, partition
from cpm_core.pages.follow import trouble_of
from cpm_core.pages.page import Page, without_image
from cpm_core.pages.tracks import LEAST_OVERLAP, PART, Tracker, TrackEvent, origins_of

_AROUND, _FAR = 0.25, 0.1
"""Margin around an object that is compared as well, in lengths of it; and how much less a place that is a length away
from the one expected has to look like it."""

_ALIKE = 0.5
"""Overlap from which what is closed is the object that is sought."""

_CORE = 0.4
"""Depth from which the pixels of the moved object surely belong to it, as a share of the largest."""

_RING, _FAINT = 4, 0.5
"""Width of the rim that an object is compared with [px], and the share of its contrast with it that it has to keep."""

_PIECE = 0.2
"""Share of an object from which a part of it that is apart from the others is an object of its own."""


@record
class FollowedObject:
    """An object that has been found again, or that has split off another one.

    Attributes
    ----------
    number : int
        Its number, the same as on the page before; a new one for what has split off.
    origin : int
        Number of the object on the page before that it is, or has split off.
    selection : Selection
        The object.
    """

    number: int
    origin: int
    selection: Selection


class ObjectFollower:
    """Follows objects from page to page."""

    def __init__(self, tracks: int = 0) -> None:
        """So many `tracks` are known: new ones have larger numbers."""
        self._tracks = tracks
        self._values: Array = np.empty((0, 0))
        self._before: Mapping[int, Selection] = {}
        self._speeds: Mapping[int, Index] = {}

    def take(self, values: Array, objects: Mapping[int, Selection]) -> None:
        """Take the objects of a page by their numbers, with the gray levels of the page, shape (H, W)."""
        known = self._before.keys() & objects.keys()
        middles = {
            number: [np.argwhere(on[number].mask).mean(axis=0) for on in (self._before, objects)] for number in known
        }
        self._speeds = {number: np.rint(now - then).astype(int) for number, (then, now) in middles.items()}
        self._values, self._before, self._tracks = values, objects, max(self._tracks, *objects, 0)

    def follow(
        self, number: int, page: Partition, check: Callback = lambda: None
    ) -> tuple[tuple[FollowedObject, ...], tuple[TrackEvent, ...]]:
        """Find the objects of the page before on the page of a number; `check` is called again and again.

        Returns
        -------
        tuple of FollowedObject
            What has been found, by number; nothing on a page of another size.
        tuple of TrackEvent
            Which objects split, merge, end or leave the image.
        """
        if self._values.shape != page.shape:
            return (), ()
        sought = []
        for each, one in self._before.items():
            check()
            speed = self._speeds.get(each, np.zeros(2, int))
            seen = _seen(one.mask, self._values, page.values, speed)
            sought.append(_Sought(replace(_outer(one), number=each), one.mask, self._values, speed, seen))
        found = _found(sought, page, check)
        taken = np.logical_or.reduce([one.mask for one in found])
        before, now = [one.bound(taken) for one in sought], [_outer(one) for one in found]
        contours, events = Tracker(before, self._tracks).follow(number, now, page.shape)
        origins = origins_of(events)
        begun = {event.track for event in events if event.kind == "begins"}
        kept = [
            FollowedObject(contour.number, origins.get(contour.number, contour.number), one)
            for contour, one in zip(contours, found, strict=True)
            if contour.number not in begun
        ]
        return tuple(sorted(kept, key=lambda one: one.number)), tuple(one for one in events if one.kind != "begins")


def follow_objects(
    pages: Sequence[Image],
    found_on: Callable[[Image], Result],
    inside: ArrayLike,
    outside: ArrayLike,
    numbers: Sequence[int],
) -> Iterator[Page]:
    """Follow the object of some places on the first of some pages through the others, up to one without it.

    Parameters
    ----------
    pages : sequence of Image
        The pages.
    found_on : callable
        Gives the contours of a page.
    inside, outside : array_like, shape (M, 2) and (K, 2)
        Places in the object, and not in it [px].
    numbers : sequence of int
        Which pages, from 1, in the order in which they are followed.

    Yields
    ------
    Page
        Each page as soon as it is done; one that cannot be used, or without the object, has a sentence.
    """
    follower, objects = ObjectFollower(), dict[int, Selection]()
    for number in numbers:
        try:
            image = pages[number - 1]
            part = partition(found_on(image))
        except (ValueError, MemoryError) as error:
            yield Page(number, None, trouble=trouble_of(error))
            continue
        events: tuple[TrackEvent, ...] = ()
        if objects:
            found, events = follower.follow(number, part)
            objects = {one.number: one.selection for one in found}
        else:
            chosen = part.select(inside, outside)
            objects = {1: chosen} if chosen.found else {}
        if not objects:
            yield Page(number, None, events, "There is no object at this position.")
            return
        follower.take(part.values, objects)
        made = objects_result(list(objects.values()), image, [f"object {each}" for each in objects], part.channel)
        own = [0, *objects]
        contours = tuple(replace(one, number=own[one.group], group=own[one.group]) for one in made.contours)
        yield Page(number, without_image(replace(made, contours=contours)), events)


def pages_of(found: Mapping[int, Result]) -> tuple[Page, ...]:
    """The pages of objects that have been accepted, by number, with what happens to the objects from page to page.

    The contours of an object have its number as their group; an object is looked for where it would be at its speed.
    """
    pages: list[Page] = []
    before: dict[int, Contour] = {}
    speeds: dict[int, Array] = {}
    tracks = 0
    for number, result in sorted(found.items()):
        contours = tuple(replace(one, number=one.group) for one in result.contours)
        outer = {one.number: one for one in sorted(contours, key=lambda one: one.area)}
        tracker = Tracker(
            [replace(one, points=one.points + speeds.get(each, 0.0)) for each, one in before.items()], tracks
        )
        _, events = tracker.follow(number, tuple(outer.values()), result.shape, keep=True)
        speeds = {
            each: np.subtract(centroid(outer[each]), centroid(before[each])) for each in outer.keys() & before.keys()
        }
        before, tracks = outer, max(tracks, *outer)
        pages.append(Page(number, without_image(replace(result, contours=contours)), events))
    return tuple(pages)


class _Sought:
    """An object of the page before, moved as fast as before, and to where the page looks most like it."""

    def __init__(self, outer: Contour, mask: Mask, values: Array, speed: Index, seen: Index) -> None:
        self._bounds = [replace(outer, points=outer.points + by) for by in (speed, seen)]
        self.expected, self.mask = _moved(mask, speed), _moved(mask, seen)
        self._pieces = len(_pieces(mask))
        self._contrast = _contrast(mask, values)
        self._distinct = abs(self._contrast) > values[mask].std()

    def bound(self, taken: Mask) -> Contour:
        """Its boundary where it was expected, or where it is seen if nothing has been found there."""
        there = np.count_nonzero(self.expected & taken) > LEAST_OVERLAP * np.count_nonzero(self.expected)
        return self._bounds[not there]

    def like(self, other: Mask, values: Array) -> bool:
        """Whether something on the next page differs from what is around it as this object does, if it does clearly."""
        same = _contrast(other, values) / self._contrast if self._distinct and other.any() else 1.0
        return bool(same > _FAINT)

    def holds(self, other: Mask) -> bool:
        """Whether most of something else lies in it where it was expected."""
        return bool(np.count_nonzero(other & self.expected) > PART * np.count_nonzero(other))

    def apart(self, mask: Mask) -> list[Mask]:
        """What has been found, in as many parts as it has more than before."""
        several = _pieces(mask)
        return several if len(several) > self._pieces else [mask]


def _seen(mask: Mask, before: Array, now: Array, speed: Index) -> Index:
    """How far an object has moved to where a page looks most like it."""
    low, high = ends(mask)
    reach = int((high - low).max()) + 1
    around = int(_AROUND * reach) + 1
    first, last = np.maximum(low - around, 0), np.minimum(high + around + 1, mask.shape)
    rows, cols = (
        np.clip(np.arange(start - reach, stop + reach), 0, side - 1)
        for start, stop, side in zip(first + speed, last + speed, mask.shape, strict=True)
    )
    template = before[first[0] : last[0], first[1] : last[1]]
    likeness = skimage.feature.match_template(now[np.ix_(rows, cols)], template)  # type: ignore[no-untyped-call]
    away = np.hypot(*np.ogrid[-reach : reach + 1, -reach : reach + 1]) / reach
    place = np.unravel_index(np.argmax(likeness - _FAR * away**2), likeness.shape)
    return speed + place - reach


def _found(sought: Sequence[_Sought], page: Partition, check: Callback) -> list[Selection]:
    """What is where objects are sought, each once; of two that share pixels, what is more like before comes first."""
    certain, taken = [(one, *ends(one)) for one in page.certain()], np.zeros(page.shape, bool)
    found: list[Selection] = []

    def near(mask: Mask) -> list[Mask]:
        low, high = ends(mask)
        return [one for one, first, last in certain if (first <= high).all() and (last >= low).all()]

    def closed(mask: Mask) -> Mask | None:
        several = near(mask)
        parts = [one for one in several if np.count_nonzero(one & mask) > PART * np.count_nonzero(one)]
        whole = np.logical_or.reduce(parts) if parts else mask & False
        best = max((*several, whole), key=lambda one: overlap(one, mask))
        return best if overlap(best, mask) > _ALIKE else None

    def answer(mask: Mask) -> Mask:
        check()
        sure = closed(mask)
        if sure is not None:
            return sure
        likely = page.around(_core(mask), float(np.count_nonzero(mask)))
        sure = closed(likely) if likely.any() else None
        return likely if sure is None else sure

    def take(one: Mask) -> None:
        left = one & ~taken
        if np.count_nonzero(left) > PART * np.count_nonzero(one):
            taken[left] = True
            sure = any(np.array_equal(left, each) for each in near(left))
            found.append(page.selection_of(left, certain=sure))

    answers = [(each, answer(each.mask)) for each in sought if each.mask.any()]
    for each, mask in sorted(answers, key=lambda pair: -overlap(pair[0].mask, pair[1])):
        for part in each.apart(mask):
            if each.like(part, page.values):
                take(part)
    for each in sought:  # what has split off lies where nothing has been found
        rest = each.expected & ~taken
        if np.count_nonzero(rest) > _PIECE * np.count_nonzero(each.expected):
            for other in [one for one in near(rest) if each.holds(one)] or [answer(rest)]:
                if each.holds(other) and each.like(other, page.values):
                    take(other)
    return found


def _outer(one: Selection) -> Contour:
    """The boundary of an object, without its holes and smaller parts."""
    return max(one.contours, key=lambda contour: contour.area)


def _contrast(mask: Mask, values: Array) -> float:
    """How much brighter an object is than what is around it."""
    low, high = ends(mask)
    box = tuple(map(slice, np.maximum(low - _RING, 0), high + _RING + 1))
    mask, values = mask[box], values[box]
    ring = scipy.ndimage.binary_dilation(mask, iterations=_RING) & ~mask
    return float(np.median(values[mask]) - np.median(values[ring])) if ring.any() else 0.0


def _core(mask: Mask) -> Mask:
    """Pixels deep inside."""
    depth = scipy.ndimage.distance_transform_edt(mask)
    return np.asarray(depth > _CORE * depth.max())


def _moved(mask: Mask, by: Index) -> Mask:
    """Pixels moved by whole pixels; those beyond the border are gone."""
    places = np.argwhere(mask) + by
    places = places[((places >= 0) & (places < mask.shape)).all(axis=1)]
    moved = np.zeros_like(mask)
    moved[tuple(places.T)] = True
    return moved


def _pieces(mask: Mask) -> list[Mask]:
    """The larger parts of an object that are apart from each other."""
    parts, _ = scipy.ndimage.label(mask)
    sizes = np.bincount(parts.ravel())
    return [parts == part for part in range(1, len(sizes)) if sizes[part] >= _PIECE * sizes[1:].sum()]
