"""The brush that paints objects."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.objects import apply_brush, paint_volume_object
from cpm_app.model.text.language import tr
from cpm_app.session.features.object_list import ObjectList
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_core.numerics import Place, polyline
from cpm_core.numerics.types import Line
from cpm_core.objects.segmented import SegmentedObject, paint_boundary, voxelize_brush
from cpm_core.shapes import relative_sides

BRUSH_RADIUS_RANGE = 0.5, 500.0
"""Limits of the radius of the brush [px]."""

_MIN_BRUSH_MOVE = 0.3
"""Smallest distance between two points of a stroke [px]."""


def default_brush_radius(image: ImageReference | None) -> float:
    """Return the default radius of the brush, which depends on the size of the image [px]."""
    return max(round(0.03 * max(image.shape)), 4.0) if image is not None else 4.0


class ObjectBrush(QObject):
    """The brush for objects, which paints one of them from the press of the button to its release.

    It is the selected one, wherever the stroke begins; of several, the one under the pointer comes first. Without a
    selected one, a brush that adds makes a new object, and one that removes waits until it touches one.
    """

    changed = Signal(float)
    """The radius [px] or an option has changed."""

    def __init__(self, session: Session, object_list: ObjectList) -> None:
        super().__init__(session)
        self._session, self._list = session, object_list
        self._chosen_radius: float | None = None
        self.paints_in_space = False
        """Whether the brush paints balls through all slices of a volume, not disks in one slice."""
        self._path: list[Place] = []
        self._before: SegmentedObject | None = None
        self._limits: tuple[SegmentedObject, ...] = ()
        """Objects of the image that the stroke stays out of."""
        self._known = session.document.objects
        """The objects before the stroke."""
        self._boundary: tuple[Line, ...] = ()
        self._number, self._stroke_radius, self._gesture = 0, 0.0, ""
        self._axis: int | None = None
        self.adds = True
        """Whether the stroke adds; otherwise it removes."""

    # Settings

    @property
    def radius(self) -> float:
        """Radius of the brush [px of the image]."""
        return self._chosen_radius or default_brush_radius(self._session.document.image)

    def set_radius(self, radius: float | None) -> None:
        """Set the radius of the brush [px]; for None it depends on the size of the image again."""
        self._chosen_radius = radius
        self.changed.emit(self.radius)

    def toggle_space(self) -> None:
        """Toggle whether the brush paints in space or in a slice."""
        self.paints_in_space = not self.paints_in_space
        self.changed.emit(self.radius)

    # Strokes

    @property
    def painting(self) -> bool:
        """Whether a stroke is going on."""
        return bool(self._path)

    def begin_stroke(self, at: Place, adds: bool, gesture: str, axis: int | None, makes_new: bool) -> None:
        """Begin a stroke at a place, in a volume across an axis; `gesture` merges it into one undo step.

        If `makes_new`, the stroke makes a new object.
        """
        self._path, self._stroke_radius, self.adds, self._gesture, self._axis = [at], self.radius, adds, gesture, axis
        self._number = self._list.objects.next_number if makes_new else 0
        self._before, self._boundary, self._known = None, (), self._list.objects
        self._limits = self._find_limits(at, None, makes_new)
        self._list.pause_measuring()
        self._paint_stretch()

    def extend_stroke(self, to: Place) -> None:
        """Extend the stroke to a place."""
        if self._path and math.dist(self._path[-1], to) >= _MIN_BRUSH_MOVE:
            self._path.append(to)
            self._paint_stretch()

    def end_stroke(self) -> None:
        """End the stroke, with a message if it has changed no object."""
        if self._path and not self._number:
            nothing = tr("There is no object under the brush to erase from.")
            self._session.messages.show(nothing, category=EDITING_CATEGORY)
        elif self._path and self.adds and self._list.objects == self._known:
            others = (item for item in self._known.items if item.number != self._number)
            found = next((item for item in others if any(item.region.contains(at) for at in self._path)), None)
            if found is not None:
                self._session.messages.show(self._explain_obstacle(found), category=EDITING_CATEGORY)
        self._path = []
        self._list.resume_measuring()

    def find_target(self, newest: Sequence[Place], radius: float, adds: bool) -> SegmentedObject | None:
        """Find the object that a stroke along some places would paint; None for a new one, or none to erase from."""
        under = self._list.object_number_at(newest[-1])
        near = [one for one in self._list.selected_objects if not one.line]
        if not near and not adds and len(newest[-1]) == 3:
            near = [one for one in self._list.objects.items if one.number == under]
        elif not near and not adds:
            path = polyline.sample_path(np.array(newest), 0.5 * radius) if len(newest) > 1 else np.array(newest)
            near = [
                item for item in self._list.objects_near(path, radius) if not item.line and
                (item.region.encloses(path).any() or
                 (polyline.distances_to_closed_paths(item.region.boundary, path) < radius).any())
            ]  # fmt: skip
        return min(near, key=lambda one: (one.number != under, one.region.size), default=None)

    def find_obstacle(self, at: Place, target: SegmentedObject | None, adds: bool, makes_new: bool) -> str:
        """Find why a brush at a place would do nothing, as a sentence; empty if it would paint, or erase."""
        if target is not None and (target.frozen or target.hidden):
            return self._explain_obstacle(target)
        limits = self._find_limits(at, target, makes_new) if adds else ()
        found = next((item for item in limits if item.region.contains(at)), None)
        return "" if found is None else self._explain_obstacle(found)

    def _find_limits(self, at: Place, target: SegmentedObject | None, makes_new: bool) -> tuple[SegmentedObject, ...]:
        """Find the objects that a stroke from a place stays out of; a new one may begin inside another."""
        known, in_volume = self._list.objects, len(at) == 3
        limits = [
            item for item in known.items
            if item is not target and (item.frozen or not known.may_overlap or (in_volume and item.hidden))
        ]  # fmt: skip
        if makes_new and not in_volume:
            limits = [item for item in limits if item.frozen or not item.region.contains(at)]
        return tuple(limits)

    def _explain_obstacle(self, item: SegmentedObject) -> str:
        """Explain why an object is not painted, or not painted over."""
        if item.frozen:
            words = tr("{name} is frozen: unfreeze it to paint here.")
        elif item.hidden:
            words = tr("{name} is hidden: show it to paint here.")
        else:
            words = tr("This belongs to {name}: select it to paint it, or let objects overlap (menu Objects).")
        return words.format(name=self._list.title_of(item))

    def _paint_stretch(self) -> None:
        """Paint the newest stretch of the path; a frozen or hidden object stays as it is, with a message."""
        image, stretch = self._session.document.image, self._path[-2:]
        if image is None:
            return
        if not self._number:
            item = self.find_target(stretch, self._stroke_radius, self.adds)
            if item is not None and (item.frozen or item.hidden):
                self._session.messages.show(self._explain_obstacle(item), category=EDITING_CATEGORY)
                self._path = []
            if not self._path or not (item or self.adds):
                return
            self._before, self._boundary = item, item.region.boundary if item else ()
            self._number = item.number if item else self._list.objects.next_number
            self._limits = tuple(each for each in self._limits if each.number != self._number)
        self._session.edit(tr("paint object"), self._make_edit(image, stretch), self._gesture)
        there = any(item.number == self._number for item in self._list.objects.items)
        self._list.select_objects((self._number,) if there else ())

    def _make_edit(self, image: ImageReference, stretch: Sequence[Place]) -> Callable[[Document], Document]:
        """Make the edit that paints a stretch of the path."""
        if image.is_volume:
            part = voxelize_brush(image.shape, stretch, self._stroke_radius, relative_sides(image.spacing), self._axis)
            return partial(
                paint_volume_object,
                number=self._number,
                part=part,
                adds=self.adds,
            )
        radius = self._stroke_radius
        low, high = np.min(stretch, axis=0) - radius, np.max(stretch, axis=0) + radius
        near = (item for item in self._limits if (item.box[0] <= high).all() and (item.box[1] >= low).all())
        limits = [item.region.boundary for item in near]
        self._boundary = paint_boundary(self._boundary, stretch, radius, self.adds, image.shape, limits)
        return partial(
            apply_brush,
            before=self._before,
            number=self._number,
            boundary=self._boundary,
            path=tuple(self._path),
            radius=self._stroke_radius,
        )
