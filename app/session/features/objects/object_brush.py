"""A round brush that paints objects: what it goes over is added to an object, or taken away from it."""

from __future__ import annotations

import math

import numpy as np

from app.model.document.brushed import brushed
from app.model.text.language import tr
from app.session.features.objects.object_list import ObjectList
from app.session.session import Session
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Position
from cpm_core.objects.segmented.painted_area import PaintedArea
from cpm_core.objects.segmented.segmented_object import SegmentedObject

_LEAST_MOVE = 0.3
"""Distance that the brush moves before it paints on [px]."""


class ObjectBrush:
    """Paints one object from the press of the button to its release.

    Of the objects that the brush touches, one that is chosen comes first, then the one that it is in. A brush that adds
    and touches none when it is pressed makes a new object; one that takes away waits until it comes to one.
    """

    def __init__(self, session: Session, object_list: ObjectList) -> None:
        self._session = session
        self._list = object_list
        self._area = PaintedArea((), ())
        self._path: list[Position] = []
        self._before: SegmentedObject | None = None
        self._number, self._radius, self._adds, self._gesture = 0, 0.0, True, ""

    @property
    def painting(self) -> bool:
        """Whether a stroke has begun."""
        return bool(self._path)

    def begin(self, at: Position, radius: float, adds: bool, gesture: str) -> None:
        """Begin a stroke at a place; `gesture` makes one step of undo of it."""
        self._path, self._radius, self._adds, self._gesture = [at], radius, adds, gesture
        self._number, self._before = 0, None
        self._find()
        self._apply()

    def paint(self, to: Position) -> None:
        """Paint on to a place."""
        if self._path and math.dist(self._path[-1], to) >= _LEAST_MOVE:
            self._path.append(to)
            self._find()
            self._apply()

    def end(self) -> None:
        """End the stroke; say so if it has come to no object."""
        if self._path and not self._number:
            self._session.say(tr("There is no object under the brush from which it could take away."))
        self._path = []

    def _find(self) -> None:
        """Find the object to be painted, unless it is known; a frozen one is left alone, with a word to the user."""
        image = self._session.document.image
        if self._number or image is None:
            return
        item = self._touched()
        if item is not None and item.frozen:
            name = self._list.title(item)
            self._session.say(tr("{name} is frozen: release it to paint it, or paint another one.").format(name=name))
            self._path = []
        elif item is not None or self._adds:
            self._before = item
            self._number = self._session.document.objects.next_number if item is None else item.number
            self._area = PaintedArea(() if item is None else item.boundary, image.shape)

    def _touched(self) -> SegmentedObject | None:
        """The object that the newest stretch of the path touches."""
        items, newest = self._session.document.objects.items, np.array(self._path[-2:])
        way = polyline.sampled(newest, 0.5 * self._radius) if len(newest) > 1 else newest
        near = [item for item in items if not item.hidden and _touches(item, way, self._radius)]
        under = self._list.under(self._path[-1])
        near.sort(key=lambda item: (item.number not in self._list.chosen, item.number != under, item.area))
        return near[0] if near else None

    def _apply(self) -> None:
        """Paint the newest stretch of the path."""
        if not self._path or not self._number:
            return
        self._area = self._area.painted(self._path[-2:], self._radius, self._adds)
        before, number, radius = self._before, self._number, self._radius
        boundary, path = self._area.boundary, tuple(self._path)
        self._session.edit(
            tr("paint object"),
            lambda document: brushed(document, before, number, boundary, path, radius),
            self._gesture,
        )
        self._list.choose((number,) if boundary else ())


def _touches(item: SegmentedObject, way: Array, radius: float) -> bool:
    """Whether a disk touches an object at one of some places, shape (N, 2)."""
    return bool(item.encloses(way).any() or (polyline.distances_from_closed(item.boundary, way) < radius).any())
