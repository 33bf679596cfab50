"""The objects of the document: figures, which are chosen, what is done to them, and the brush that paints them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np
from PySide6.QtCore import QObject, Signal

from app.model.document import objects
from app.model.document.document import Document
from app.model.document.objects import brushed
from app.model.text.language import tr
from app.model.volume.surface_section import holds, size_of
from app.session.features.background import LatestOnlyWorker
from app.session.session import Session
from cpm_core import Image, Surface
from cpm_core.numerics import Array, Place, Position, polyline
from cpm_core.objects.segmented import Halves, Line, SegmentedObject, SegmentedObjects, painted, union


@dataclass(frozen=True, slots=True)
class Figures:
    """Figures of an object.

    Attributes
    ----------
    gray : float
        Mean gray value; NaN where it has no pixel.
    volume, area : float
        Of an object in a volume, in the unit of the image; 0 in an image, as the rest.
    parts, euler : int
        Parts of its surface that do not hang together, and its Euler characteristic.
    """

    gray: float
    volume: float = 0.0
    area: float = 0.0
    parts: int = 0
    euler: int = 0


def _boundary(item: SegmentedObject) -> object:
    return item.surface or item.boundary


def _measured(item: SegmentedObject, image: Image) -> Figures:
    inside = item.mask(image.shape)
    gray = float(image.values[inside].mean()) if inside.any() else float("nan")
    if item.body is None:
        return Figures(gray)
    # limits are made of it on the window's thread
    assert all(len(packed.shell.mask) for packed in item.surface)
    surface: Surface = replace(item.body, spacing=image.spacing, unit=image.unit)
    return Figures(gray, surface.volume, surface.area, surface.components, surface.euler)


BRUSH = 1.0, 500.0
"""Limits of the radius of the brush [px]."""

_BRUSH, _LEAST_BRUSH = 0.03, 4.0
"""Radius of the brush at first, in the longest side of the image, and at least [px]."""


class ObjectList(QObject):
    """Chooses objects of the document and edits them; what is not said otherwise is done to the chosen ones."""

    changed = Signal()
    """The objects, their classes or their gray values have changed."""
    selection_changed = Signal()
    """Other objects are chosen."""
    brush_changed = Signal(float)
    """The brush has another radius [px]."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._brush: float | None = None
        self._boxes: dict[int, tuple[tuple[Line, ...], tuple[float, ...]]] = {}
        """The boundary of each object, and the least and largest row and column of it."""
        self._known, self._measured_in = session.document.objects, session.image
        self._figures: dict[int, tuple[Image, object, Figures]] = {}
        self._latest = LatestOnlyWorker(session, "cpm-object-measures", tr("measuring objects"))
        self._merging = LatestOnlyWorker(session, "cpm-merging", tr("merging objects"))
        session.document_changed.connect(self._follow)
        session.image_changed.connect(self._merging.forget)

    # State

    @property
    def objects(self) -> SegmentedObjects:
        """The objects of the document and their classes."""
        return self._session.document.objects

    @property
    def chosen(self) -> frozenset[int]:
        """Numbers of the chosen objects."""
        return self._session.scene.objects.chosen

    @property
    def items(self) -> tuple[SegmentedObject, ...]:
        """The chosen objects, in the order in which they were taken."""
        return tuple(item for item in self.objects.items if item.number in self.chosen)

    def figures(self, item: SegmentedObject) -> Figures | None:
        """Figures of an object; None while they are not known for its boundary in the present image."""
        image, boundary, figures = self._figures.get(item.number, (None, None, None))
        return figures if image is self._session.image and boundary is _boundary(item) else None

    def title(self, item: SegmentedObject) -> str:
        """Name of an object, or its class and number."""
        return objects.title(self.objects, item)

    def under(self, at: Place) -> int:
        """Number of the smallest shown object at a place (row, col) [px], or (plane, row, col); 0 for none."""
        if len(at) == 3:
            around = [item for item in self.objects.items if not item.hidden and holds(item, at)]
        else:
            place = np.array([at], dtype=float)
            around = [item for item in self.near(place, 0.0) if item.encloses(place)[0]]
        return min(around, key=size_of).number if around else 0

    def near(self, places: Array, reach: float) -> list[SegmentedObject]:
        """The shown objects whose boxes come within reach of one of some places, shape (N, 2) [px]."""
        shown = [item for item in self.objects.items if not item.hidden and item.boundary]
        known, self._boxes = self._boxes, {}
        for item in shown:
            boundary, box = known.get(item.number, ((), ()))
            if boundary is not item.boundary:
                corners = np.concatenate([np.asarray(curve) for curve in item.boundary])
                box = (*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist())
            self._boxes[item.number] = item.boundary, box
        low, high = (places.min(axis=0) - reach).tolist(), (places.max(axis=0) + reach).tolist()

        def meets(top: float, left: float, bottom: float, right: float) -> bool:
            return top <= high[0] and left <= high[1] and bottom >= low[0] and right >= low[1]

        return [item for item in shown if meets(*self._boxes[item.number][1])]

    # The brush

    @property
    def brush(self) -> float:
        """Radius of the brush that paints objects [px of the image]."""
        image = self._session.document.image
        return self._brush or max(_BRUSH * max(image.shape if image is not None else (0,)), _LEAST_BRUSH)

    def set_brush(self, radius: float | None) -> None:
        """Set the radius of the brush within its limits [px]; for None it depends on the size of the image again."""
        self._brush = None if radius is None else min(max(radius, BRUSH[0]), BRUSH[1])
        self.brush_changed.emit(self.brush)

    # Choosing

    def choose(self, numbers: Iterable[int]) -> None:
        """Choose only these objects."""
        chosen = frozenset(numbers)
        if chosen != self.chosen:
            scene = self._session.scene
            self._session.show(replace(scene, objects=replace(scene.objects, chosen=chosen)))
            self.selection_changed.emit()

    def hover(self, number: int) -> None:
        """Highlight an object; 0 for none."""
        scene = self._session.scene
        if number != scene.objects.hovered:
            self._session.show(replace(scene, objects=replace(scene.objects, hovered=number)))

    # Editing

    def begin_change(self, number: int) -> None:
        """Select an object anew, beginning with what it is."""
        self._edit(tr("change {what}"), [self.objects[number]], lambda d: objects.begin_change(d, number))
        self.choose((number,))

    def rename(self, number: int, name: str) -> None:
        """Name an object, unless it has been taken back while its name was typed."""
        named = [item for item in self.objects.items if item.number == number]
        if named:
            self._edit(tr("name {what}"), named, lambda document: objects.rename(document, number, name))

    def classify(self, category: int) -> None:
        """Give the chosen objects, and the next ones, a class."""
        chosen = self.chosen
        self._session.edit(
            tr("class {title}").format(title=objects.class_title(self.objects, category)),
            lambda document: objects.classify(document, chosen, category),
        )

    def name_class(self, category: int, name: str, color: str = "") -> None:
        """Name a class, and change its color unless that is empty."""
        self._session.edit(tr("name class"), lambda document: objects.name_class(document, category, name, color))

    def paint(self, color: str) -> None:
        """Color objects; an empty color is that of their class."""
        self._edit_chosen(tr("color {what}"), lambda d, chosen: objects.amend(d, chosen, color=color))

    def toggle_frozen(self) -> None:
        """Freeze objects, or release them when all are frozen."""
        frozen = not all(item.frozen for item in self.items)
        words = tr("freeze {what}") if frozen else tr("release {what}")
        self._edit_chosen(words, lambda d, chosen: objects.amend(d, chosen, frozen=frozen))

    def toggle_hidden(self) -> None:
        """Hide objects, or show them again when all are hidden."""
        hidden = not all(item.hidden for item in self.items)
        words = tr("hide {what}") if hidden else tr("show {what}")
        self._edit_chosen(words, lambda d, chosen: objects.amend(d, chosen, hidden=hidden))

    def delete(self) -> None:
        """Remove objects."""
        self._edit_chosen(tr("delete {what}"), objects.delete)

    def merge(self) -> None:
        """Make one object of several; in a volume that is done on another thread."""
        image, items = self._session.document.image, self.items
        if len(items) < 2 or image is None:
            return
        if image.is_volume:
            self._merging.ask(lambda: reduce(union, items), partial(self._use_merged, items))
            return
        self._edit_chosen(tr("merge {what}"), objects.merge)
        self.choose((items[0].number,))

    def split(self, whole: SegmentedObject, halves: Halves) -> None:
        """Put the halves of an object, or of one that is not accepted yet, in its place, and choose them."""
        before = {item.number for item in self.objects.items} - {whole.number}
        self._edit(tr("split {what}"), [whole], lambda document: objects.split(document, whole, halves))
        self.choose(item.number for item in self.objects.items if item.number not in before)

    def as_starts(self) -> None:
        """Start the next run on their outlines too."""
        self._edit_chosen(tr("start from {what}"), objects.as_starts)

    def as_regions(self) -> None:
        """Hold the particles inside of them."""
        self._edit_chosen(tr("region of interest of {what}"), objects.as_regions)

    def as_barriers(self) -> None:
        """Hold the particles back at their boundaries."""
        self._edit_chosen(tr("barrier around {what}"), objects.as_barriers)

    def close(self) -> None:
        """End the threads."""
        self._latest.close()
        self._merging.close()

    # Internal

    def _edit_chosen(self, words: str, edit: Callable[[Document, frozenset[int]], Document]) -> None:
        chosen = self.chosen
        if chosen:
            self._edit(words, self.items, lambda document: edit(document, chosen))

    def _edit(self, words: str, items: Iterable[SegmentedObject], edit: Callable[[Document], Document]) -> None:
        items = list(items)
        what = self.title(items[0]) if len(items) == 1 else tr("{count} objects").format(count=len(items))
        self._session.edit(words.format(what=what), edit)

    def _follow(self, document: Document) -> None:
        image, items = self._session.image, document.objects.items
        if image is self._measured_in and document.objects is self._known:
            return
        self._known, self._measured_in = document.objects, image
        self.choose(self.chosen & {item.number for item in items})
        missing = [item for item in items if self.figures(item) is None]
        if image is not None and missing:  # large objects have many pixels

            def use(measured: dict[int, tuple[Image, object, Figures]]) -> None:
                self._figures |= measured
                self.changed.emit()

            self._latest.ask(
                lambda: {item.number: (image, _boundary(item), _measured(item, image)) for item in missing}, use
            )
        self.changed.emit()

    def _use_merged(self, items: tuple[SegmentedObject, ...], whole: SegmentedObject) -> None:
        """Put one object in the place of several, unless they have changed meanwhile."""
        if not all(any(known is item for known in self.objects.items) for item in items):
            self._session.say(tr("The objects have changed while they were merged: merge them again."), True)
            return
        self._edit(tr("merge {what}"), items, lambda document: objects.merge_into(document, items, whole))
        self.choose((whole.number,))


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
        self._boundary: tuple[Line, ...] = ()
        self._shape: tuple[int, ...] = ()
        self._path: list[Position] = []
        self._before: SegmentedObject | None = None
        self._number, self._radius, self._gesture = 0, 0.0, ""
        self.adds = True
        """Whether the stroke adds, and does not take away."""

    @property
    def painting(self) -> bool:
        """Whether a stroke has begun."""
        return bool(self._path)

    def begin(self, at: Position, radius: float, adds: bool, gesture: str) -> None:
        """Begin a stroke at a place; `gesture` makes one step of undo of it."""
        self._path, self._radius, self.adds, self._gesture = [at], radius, adds, gesture
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

    def target(self, at: Position, radius: float) -> SegmentedObject | None:
        """The object that a stroke from a place would paint; None where it would begin a new one."""
        return self._touched(np.array([at]), radius)

    def _find(self) -> None:
        """Find the object to be painted, unless it is known; a frozen one is left alone, with a word to the user."""
        image = self._session.document.image
        if self._number or image is None:
            return
        item = self._touched(np.array(self._path[-2:]), self._radius)
        if item is not None and item.frozen:
            name = self._list.title(item)
            self._session.say(tr("{name} is frozen: release it to paint it, or paint another one.").format(name=name))
            self._path = []
        elif item is not None or self.adds:
            self._before = item
            self._number = self._session.document.objects.next_number if item is None else item.number
            self._boundary, self._shape = () if item is None else item.boundary, image.shape

    def _touched(self, newest: Array, radius: float) -> SegmentedObject | None:
        """The object that a stretch of the path touches."""
        way = polyline.sampled(newest, 0.5 * radius) if len(newest) > 1 else newest
        near = [
            item for item in self._list.near(way, radius)
            if item.encloses(way).any() or (polyline.distances_from_closed(item.boundary, way) < radius).any()
        ]  # fmt: skip
        under = self._list.under(tuple(newest[-1].tolist()))
        near.sort(key=lambda item: (item.number not in self._list.chosen, item.number != under, item.area))
        return near[0] if near else None

    def _apply(self) -> None:
        """Paint the newest stretch of the path."""
        if not self._path or not self._number:
            return
        boundary = painted(self._boundary, self._path[-2:], self._radius, self.adds, self._shape)
        before, number, radius = self._before, self._number, self._radius
        self._boundary, path = boundary, tuple(self._path)
        self._session.edit(
            tr("paint object"),
            lambda document: brushed(document, before, number, boundary, path, radius),
            self._gesture,
        )
        self._list.choose((number,) if boundary else ())
