"""Selections of clicks in a volume: the bodies that its surface encloses."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence

import numpy as np

from app.model.volume.surface_section import prepare
from app.session.scene import Proposal
from cpm_core.numerics.types import Array
from cpm_core.objects.faces.space import VolumePartition, VolumeSelection
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObject, places_of

_MOST_KEPT = 8
"""Number of answers that are kept: each has a surface."""

_MOST_PLACES = 20
"""Places of a start that tell which body it lies in."""


class BodySelector:
    """Selects on one partition; what has been selected once is the same object the next time.

    Parameters
    ----------
    partition : VolumePartition
        The partition.
    items : sequence of SegmentedObject
        The objects that there are.
    edited : int
        Number of the object that is being changed, 0 for none.
    """

    def __init__(self, partition: VolumePartition, items: Sequence[SegmentedObject], edited: int) -> None:
        self.partition = partition
        self.items = items
        self.edited = edited
        self._known: OrderedDict[tuple[bytes, str], VolumeSelection] = OrderedDict()

    def selection(self, clicks: tuple[Click, ...]) -> VolumeSelection | None:
        """The bodies that clicks select; None while none of them is inside."""
        inside = places_of(clicks, inside=True)
        if not len(inside):
            return None
        selection = self.partition.select(inside, places_of(clicks, inside=False))
        key = selection.bodies.tobytes(), selection.remark
        known = self._known.setdefault(key, selection)
        self._known.move_to_end(key)
        if len(self._known) > _MOST_KEPT:
            self._known.popitem(last=False)
        if known.found:
            prepare(known.surface)
        return known

    def proposals(self, starts: Sequence[Array]) -> tuple[Proposal, ...]:
        """The bodies in which runs were started, given the seeds of each start, unless they are objects already."""
        found: dict[int, Proposal] = {}
        taken = {body for item in self.items for body in self.partition.bodies_at(item.inside).tolist()}
        for seeds in starts:
            bodies = self.partition.bodies_at(seeds)
            within = bodies[bodies > 0]
            if not len(within):
                continue
            body = int(np.bincount(within).argmax())
            places = seeds[bodies == body][:_MOST_PLACES].tolist()
            clicks = (Click(tuple((plane, row, col) for plane, row, col in places)),)
            selection = self.selection(clicks)
            if body not in taken and body not in found and selection is not None and selection.found:
                _ = selection.packed  # so that it can be taken at once
                found[body] = Proposal(selection, clicks)
        return tuple(found.values())
