"""Tracks: contours on one page after the other that bound the same object.

Contours are matched to tracks by their largest overlaps, measured by the Dice coefficient, 0 to 1, of the areas that
they alone enclose, as in the label mask; an open one encloses what lies between it and the line that joins its ends.
Objects keep their numbers, and are looked for where they would be at their last speed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from cpm_core.contours.contour import Contour, Contours
from cpm_core.contours.measurements import compute_centroid, containment
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.numerics.types import Array, Extent, Index, Integers, Position, frozen
from cpm_core.parameters.formatting import format_repr

MIN_TRACK_OVERLAP = 0.2
"""Least overlap of two contours of one track."""

MIN_PART_FRACTION = 0.5
"""Least share of an area that lies in another for it to be a part of that one."""

_BORDER_TOLERANCE = 3.0
"""Distance from the border of the image up to which a contour touches it [px]."""

EventKind = Literal["begins", "enters", "splits", "merges", "ends", "leaves"]
"""What happens to a track."""

_EVENT_SENTENCES: dict[EventKind, str] = {
    "begins": "track {track} begins",
    "enters": "track {track} enters the image",
    "splits": "track {others} splits off track {track}",
    "merges": "track {track} merges into track {others}",
    "ends": "track {track} ends",
    "leaves": "track {track} leaves the image",
}


@frozen
class TrackEvent:
    """What happens to a track from one page to the next.

    Attributes
    ----------
    kind : {"begins", "enters", "splits", "merges", "ends", "leaves"}
        What happens: the track begins, inside the image or at its border; others split off it; it merges into another;
        it ends, inside the image or at its border.
    page : int
        The page, from 1; for a track that has ended, the first page without it.
    track : int
        The track.
    others : tuple of int
        The tracks that split off it, or the one that it merges into.

    Examples
    --------
    >>> cpm.TrackEvent("splits", page=4, track=1, others=(2,)).sentence
    'Page 4: track 2 splits off track 1.'
    """

    kind: EventKind
    page: int
    track: int
    others: Integers = ()

    @property
    def sentence(self) -> str:
        """The event in words."""
        several = len(self.others) > 1
        others = " and ".join(map(str, self.others))
        words = _EVENT_SENTENCES[self.kind].format(track=self.track, others=others)
        if several:
            words = words.replace("track ", "tracks ", 1).replace("splits", "split")
        return f"Page {self.page}: {words}."

    def __repr__(self) -> str:
        return format_repr("TrackEvent", self.sentence)


def find_origins(events: Iterable[TrackEvent]) -> dict[int, int]:
    """Find the track that each track has split off, if any."""
    return {other: event.track for event in events if event.kind == "splits" for other in event.others}


class Tracker:
    """Numbers the contours of one page after the other by their tracks."""

    def __init__(self, contours: Contours = (), tracks: int = 0) -> None:
        """Start from the contours of the page before, numbered by their tracks, and the number of known tracks."""
        self._before = tuple(contours)
        self._centers: dict[int, Position] = {}
        self._tracks = tracks
        self._begun = tracks > 0

    def assign_tracks(
        self, page: int, contours: Contours, shape: Extent
    ) -> tuple[tuple[Contour, ...], tuple[TrackEvent, ...]]:
        """Give the contours of a page of this shape [px] their tracks as numbers, and report what happens to tracks.

        The track of an object, one contour each, is its number, which is the group. A page without contours is skipped:
        the next page is compared with the page before it.
        """
        if not contours:
            return (), ()
        before = self._before
        dice, part = measure_overlaps(before, contours, shape)
        known = {one.group: place for place, one in enumerate(contours) if one.group}
        pairs = {then: known[one.number] for then, one in enumerate(before) if one.number in known}
        if not known:
            pairs = _match_contours(dice)
        owner = {now: then for then, now in pairs.items()}
        numbered = []
        for place, one in enumerate(contours):
            track = one.group or (before[owner[place]].number if place in owner else self._tracks + 1)
            self._tracks = max(self._tracks, track)
            numbered.append(replace(one, number=track))
        events = tuple(self._find_events(page, numbered, pairs, part, shape))
        centers = {one.group: compute_centroid(one) for one in contours if one.group}
        speeds = {
            each: np.subtract(centers[each], self._centers[each]) for each in centers.keys() & self._centers.keys()
        }
        self._before = tuple(replace(one, points=one.points + speeds.get(one.group, 0.0)) for one in numbered)
        self._centers, self._begun = centers, True
        return tuple(numbered), events

    def _find_events(
        self, page: int, now: Contours, pairs: dict[int, int], part: Array, shape: Extent
    ) -> Iterable[TrackEvent]:
        """Find the tracks that merge into others, end or leave the image, and those that begin or split off others."""
        before, heirs = self._before, {heir: then for then, heir in pairs.items()}
        around = containment(before)
        for index, contour in enumerate(before):
            if index in pairs:
                continue
            into = [
                one
                for one, then in heirs.items()
                if part[index, one] >= MIN_PART_FRACTION and not _is_nested(around, index, then)
            ]
            if into:
                heir = max(into, key=lambda one: part[index, one])
                yield TrackEvent("merges", page, contour.number, (now[heir].number,))
            else:
                yield TrackEvent("leaves" if _touches_border(contour, shape) else "ends", page, contour.number)
        around, split = containment(now), dict[int, list[int]]()
        for index, contour in enumerate(now if self._begun else ()):
            if index in heirs:
                continue
            origins = [then for then, heir in pairs.items() if part[then, index] >= MIN_PART_FRACTION]
            apart = [then for then in origins if not _is_nested(around, index, pairs[then])]
            if apart:
                split.setdefault(max(apart, key=lambda then: part[then, index]), []).append(contour.number)
            else:
                yield TrackEvent("enters" if _touches_border(contour, shape) else "begins", page, contour.number)
        for then, parts in split.items():
            yield TrackEvent("splits", page, before[then].number, tuple(parts))


def _touches_border(contour: Contour, shape: Extent) -> bool:
    """Return whether a contour touches the border of an image of this shape [px]."""
    low, high = contour.box
    return bool((low < _BORDER_TOLERANCE).any() or (high > np.array(shape) - 1.0 - _BORDER_TOLERANCE).any())


def measure_overlaps(before: Contours, now: Contours, shape: Extent) -> tuple[Array, Array]:
    """Measure how contours of two pages overlap, on an image of this shape [px].

    Returns
    -------
    dice : ndarray, shape (N, M)
        Overlaps of N contours with M others, which decide which of them belong to one track.
    part_fraction : ndarray, shape (N, M)
        Shares of the smaller area that lie in the other; 0 for open contours.
    """
    if not (before and now):
        nothing = np.zeros((len(before), len(now)))
        return nothing, nothing
    dice, part = _measure_area_overlaps(before, now, shape)
    lines = np.array([not one.closed for one in before])[:, None] | np.array([not one.closed for one in now])[None]
    if lines.any():  # join the ends of open contours, which may be objects that the border of the image cuts
        then, later = ([replace(one, closed=len(one.points) > 2) for one in contours] for contours in (before, now))
        part[lines] = 0.0
        dice[lines] = _measure_area_overlaps(then, later, shape)[0][lines]
    return dice, part


def _measure_area_overlaps(before: Contours, now: Contours, shape: Extent) -> tuple[Array, Array]:
    """Measure the overlap of the areas of closed contours, by Dice and as a share of the smaller area."""
    one, other = (_label_regions(contours, shape) for contours in (before, now))
    shared = np.zeros((len(before) + 1, len(now) + 1))
    pairs, count = np.unique(one * (len(now) + 1) + other, return_counts=True)
    shared.ravel()[pairs] = count
    common = shared[1:, 1:]
    first, second = shared.sum(axis=1)[1:, None], shared.sum(axis=0)[1:][None]
    least = np.minimum(first, second)
    return 2.0 * common / np.maximum(first + second, 1.0), common / np.maximum(least, 1.0)


def _label_regions(contours: Contours, shape: Extent) -> Index:
    """Label each pixel with the innermost contour that encloses it, from 1; 0 for none."""
    alone = [replace(contour, group=0, hole=False) for contour in contours]
    places = np.array([0, *(index for index, one in enumerate(contours, 1) if one.closed)])
    return places[rasterize_labels(alone, shape)].ravel()


def _match_contours(dice: Array) -> dict[int, int]:
    """Match contours of the page before and of this one that belong to one track, the largest overlap first."""
    order = np.argsort(-dice, axis=None, kind="stable")
    pairs: dict[int, int] = {}
    taken: set[int] = set()
    for place in order.tolist():
        then, now = divmod(place, dice.shape[1])
        if dice[then, now] < MIN_TRACK_OVERLAP:
            break
        if then not in pairs and now not in taken:
            pairs[then] = now
            taken.add(now)
    return pairs


def _is_nested(around: Sequence[int | None], one: int, other: int) -> bool:
    """Return whether one of two contours lies in the other."""
    for inner, outer in ((one, other), (other, one)):
        at: int | None = inner
        while at is not None:
            at = around[at]
            if at == outer:
                return True
    return False
