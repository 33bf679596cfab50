"""Selections of growing lists of clicks on one partition."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.session.features.objects.body_selector import BodySelector
from app.session.features.objects.partitions import AnyPartition
from app.session.scene import Proposal
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.faces.space import VolumePartition
from cpm_core.objects.partition import Partition
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObject, places_of, selection_of
from cpm_core.objects.selection import Selection

_SAME_OBJECT = 0.5
"""Overlap (intersection over union) from which the selections of two starts are of one object."""

_UNCHANGED = 0.97
"""Overlap from which a selection is what an object is already."""

_PLACES = 100
"""About so many pixels tell which object a selection is."""

_MOST_KEPT = 200
"""Number of selections that are kept."""


class Selector:
    """Selects on one partition; a list of clicks is selected with the selection without the last one as evidence.

    Parameters
    ----------
    partition : Partition
        The partition.
    items : sequence of SegmentedObject
        The objects that there are.
    edited : int
        Number of the object that is being changed, 0 for none: with its own clicks it is as it is.
    """

    def __init__(self, partition: Partition, items: Sequence[SegmentedObject], edited: int) -> None:
        self.partition = partition
        self.items = items
        self.edited = edited
        self._known: dict[tuple[Click, ...], Selection] = {}
        nowhere = np.empty((0, 2))
        # What a first click begins with. Without it, the partition begins with its last answer to one of the places,
        # which may be what the pointer has shown where a stroke begins.
        self._nothing = Selection(np.zeros(partition.shape, np.bool_), (), (), 0.0, nowhere, nowhere)
        self._changed = next((item for item in items if item.number == edited), None)
        others = [item for item in items if item.frozen and item.number != edited]
        self._elsewhere = np.concatenate([np.empty((0, 2)), *(_enclosed(item) for item in others)])

    def selection(self, clicks: tuple[Click, ...]) -> Selection | None:
        """The object that clicks select; None while none of them is inside."""
        inside = places_of(clicks, inside=True)
        if not len(inside):
            return None
        if clicks not in self._known:
            if self._changed is not None and clicks == self._changed.clicks:
                return self._known.setdefault(clicks, selection_of(self._changed, self.partition.shape))
            outside = places_of(clicks, inside=False)
            previous = self.selection(clicks[:-1]) or self._nothing
            if previous is self._nothing and len(self._elsewhere):  # frozen objects only take away
                previous = self.partition.select(inside, outside, previous=previous)
            outside = np.concatenate([outside, self._elsewhere])
            if len(self._known) > _MOST_KEPT:
                del self._known[next(reversed(self._known))]  # a preview; those of the clicks came first
            self._known[clicks] = self.partition.select(inside, outside, previous=previous)
        return self._known[clicks]

    def proposals(self, starts: Sequence[Array]) -> tuple[Proposal, ...]:
        """The objects in which runs were started, given the seeds of each start; of frozen objects there are none.

        An object that exists already is offered only if it has become another one.
        """
        found: list[Proposal] = []
        for seeds in starts:
            clicks = (Click(tuple((row, col) for row, col in seeds.tolist())),)
            selection = self.selection(clicks)
            if selection is None or not selection.contours or selection.only_places:
                continue  # nothing was found, as from a start across an edge
            if any(overlap(selection.mask, other.selection.mask) > _SAME_OBJECT for other in found):
                continue
            known = self._known_at(_places_in(selection))
            if known is None:
                found.append(Proposal(selection, clicks))
            elif not known.frozen and overlap(known.mask(self.partition.shape), selection.mask) < _UNCHANGED:
                found.append(Proposal(selection, clicks, known.number))
        return tuple(found)

    def _known_at(self, places: Array) -> SegmentedObject | None:
        """The object that most of some places lie in."""
        return next((item for item in self.items if item.encloses(places).mean() > 0.5), None)


AnySelector = Selector | BodySelector
"""Selects objects in an image or in a volume."""


def selector_on(partition: AnyPartition, items: Sequence[SegmentedObject], edited: int) -> AnySelector:
    """A new selector on a partition; see `Selector`."""
    if isinstance(partition, VolumePartition):
        return BodySelector(partition, items, edited)
    return Selector(partition, items, edited)


def _enclosed(item: SegmentedObject) -> Array:
    """The places of an object that lie in it: not those of a line that was drawn around it."""
    return item.inside[item.encloses(item.inside)]


def _places_in(selection: Selection) -> Array:
    """The places that lie in a selection; of one that a line was drawn around, pixels all over it."""
    within = selection.inside[selection.holds(selection.inside)]
    pixels = np.argwhere(selection.mask)
    return within if len(within) else pixels[:: max(len(pixels) // _PLACES, 1)].astype(float)


def overlap(one: Mask, other: Mask) -> float:
    """Intersection over union of two masks; 0 when both are empty."""
    whole = np.count_nonzero(one | other)
    return np.count_nonzero(one & other) / whole if whole else 0.0
