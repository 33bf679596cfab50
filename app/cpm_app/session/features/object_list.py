"""The objects in one list with what is proposed and the contours under them: figures, selection, verbs, the brush."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import Literal, TypeVar, get_args

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.document import contours, objects
from cpm_app.model.document.contours import Target
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.objects import brushed, paint_in_volume
from cpm_app.model.text.language import tr
from cpm_app.model.volume.surface_section import holds, size_of
from cpm_app.session.features.background import IdentityCache, LatestOnlyWorker, is_same
from cpm_app.session.features.contour_review import ContourReview
from cpm_app.session.scene import Item, Proposal
from cpm_app.session.session import Session
from cpm_app.session.signals import EDITING
from cpm_core import Image, Surface
from cpm_core.contours import bridges_on
from cpm_core.numerics import Array, Place, Position, polyline
from cpm_core.numerics.types import Line, record
from cpm_core.objects.segmented import (
    Halves,
    SegmentedObject,
    SegmentedObjects,
    between_slices,
    brush_in,
    painted,
    split_in_volume,
    union,
)
from cpm_core.objects.segmented.in_volumes import Part
from cpm_core.shapes import sides_of

T = TypeVar("T")

BINS = 32
"""Number of bars of a histogram."""


@dataclass(frozen=True)
class Figures:
    """Figures of an object.

    Attributes
    ----------
    gray : float
        Mean gray value; NaN where it has no pixel.
    counts : tuple of int
        Numbers of pixels for `BINS` equal steps of gray value, over the range of the image.
    volume, area : float
        Of an object in a volume, in the unit of the image; 0 in an image, as the rest.
    parts, euler : int
        Parts of its surface that do not hang together, and its Euler characteristic.
    body : Surface or None
        Its surface in a volume [voxels].
    """

    gray: float
    counts: tuple[int, ...] = ()
    volume: float = 0.0
    area: float = 0.0
    parts: int = 0
    euler: int = 0
    body: Surface | None = None


Key = tuple[Literal["object", "proposal", "contour"], int]
"""What identifies a row: the number of an object, the key of a proposal, which is below 1, or that of a contour."""

_DRAFT: Key = ("proposal", 0)
"""The key of the object that is being selected."""

Kind = Literal["object", "proposal", "closed", "open", "rejected"]
KINDS: tuple[Kind, ...] = get_args(Kind)
"""What a row can be, in the order shown."""


@record
class Row:
    """One row of the list: an object, what accepting it would make an object, or a contour.

    Attributes
    ----------
    key : tuple of str and int
        What identifies it.
    kind : {"object", "proposal", "closed", "open", "rejected"}
        What it is; rejected are objects and contours.
    title : str
        Its name, or what it is and its number.
    item : SegmentedObject or None
        The object; that of a proposal has a number that is only its own until it is accepted.
    contour : Item or None
        The contour; None for objects and proposals.
    figures : Figures or None
        Figures of the object; None while they are not known.
    """

    key: Key
    kind: Kind
    title: str
    item: SegmentedObject | None = None
    contour: Item | None = None
    figures: Figures | None = None

    @property
    def name(self) -> str:
        """The name that the user has given it, or empty."""
        return self.item.name if self.item is not None else self.contour.contour.name if self.contour else ""

    @property
    def drawn(self) -> SegmentedObject | None:
        """The object where it is shown, which hidden and rejected ones are not; None for a contour."""
        return None if self.item is None or self.item.hidden or self.kind == "rejected" else self.item


def _boundary(item: SegmentedObject) -> object:
    return item.surface or item.boundary


def histogram(values: Array, image: Image) -> tuple[int, ...]:
    """How many values lie in each of `BINS` equal steps of the gray values of an image."""
    low, high = image.gray_range
    return tuple(np.histogram(values, BINS, (low, max(high, low + 1e-9)))[0].tolist())


def _measured(item: SegmentedObject, image: Image) -> Figures:
    values = image.values[item.mask(image.shape)]
    gray, counts = float(values.mean()) if len(values) else float("nan"), histogram(values, image)
    body = item.body
    if body is None:
        return Figures(gray, counts)
    # limits are made of it, and it is painted, on the window's thread
    assert all(len(packed.shell.mask) and packed.painted for packed in item.surface)
    surface = replace(body, spacing=image.spacing, unit=image.unit)
    volume = item.surface[0].volume * math.prod(image.spacing)
    return Figures(gray, counts, volume, surface.area, surface.components, surface.euler, body)


def _as_objects(offered: tuple[Proposal, ...], known: SegmentedObjects) -> tuple[SegmentedObject, ...]:
    """The objects that proposals would become, each with a number that no other row has."""
    found = enumerate((each for each in offered if each.selection.found), start=known.next_number)
    return tuple(
        replace(each.item, number=each.number or fresh, category=(each.followed or known).category)
        for fresh, each in found
    )


def _boundaries(items: Iterable[SegmentedObject]) -> list[Line]:
    return [line for item in items for line in item.boundary]


def _holds(row: Row, place: Place) -> bool:
    """Whether a place (row, col) [px], or (plane, row, col), lies inside what a row shows."""
    if row.drawn is None:
        line = row.contour.contour if row.kind == "closed" and row.contour is not None else None
        return line is not None and len(place) == 2 and bool(polyline.inside(line.points, np.array([place]))[0])
    return holds(row.drawn, place)


def _size(row: Row) -> float:
    return size_of(row.item) if row.item is not None else row.contour.contour.area if row.contour else 0.0


DOUBTFUL = 0.7
"""Probability below which an object is doubtful."""

BRUSH = 0.5, 500.0
"""Limits of the radius of the brush [px]."""


def first_radius(image: ImageReference | None) -> float:
    """Radius of a brush at first, which depends on the size of the image [px]."""
    return max(0.03 * max(image.shape), 4.0) if image is not None else 4.0


class ObjectList(QObject):
    """Lists objects, proposals and contours, selects among all of them, and does what is done to the selected ones."""

    changed = Signal()
    """The rows, their classes or their gray values have changed."""
    class_begun = Signal(int)
    """A class without a name is used next to another one for the first time."""
    brush_changed = Signal(float)
    """The brush has another radius [px]."""

    def __init__(self, session: Session, review: ContourReview) -> None:
        super().__init__(session)
        self._session, self._review = session, review
        self.selection_changed = review.selection_changed
        self._brush: float | None = None
        self.ball, self.over_others = False, True
        """Whether the brush paints in space, and not only in one slice; whether it takes from other objects there."""
        self.painting = False
        """Whether a stroke has begun, after which objects are measured."""
        self._seen: tuple[object, ...] = ()
        """Objects, image and proposals that have been listed."""
        self._figures: dict[int, tuple[Image, object, Figures]] = {}
        """Figures in an image by the identity of the boundary, which stays when a proposal becomes an object."""
        self.bodies: Mapping[int, Surface] = {}
        """The surfaces of the objects of a volume by their numbers, as they were last measured."""
        self._parts = IdentityCache()
        self._latest = LatestOnlyWorker(session, "cpm-object-measures", tr("measuring objects"))
        self._merging = LatestOnlyWorker(session, "cpm-merging", tr("merging objects"))
        session.document_changed.connect(self._follow)
        session.scene_changed.connect(self._follow)
        session.image_changed.connect(self._forget)
        review.changed.connect(self.changed)

    # State

    @property
    def objects(self) -> SegmentedObjects:
        """The objects of the document and their classes."""
        return self._session.document.objects

    @property
    def chosen(self) -> frozenset[int]:
        """Numbers of the chosen objects."""
        return frozenset(number for number in self._session.scene.objects.chosen if number > 0)

    @property
    def items(self) -> tuple[SegmentedObject, ...]:
        """The chosen objects, in the order in which they were accepted."""
        chosen = self.chosen
        return tuple(item for item in self.objects.items if item.number in chosen)

    @property
    def rows(self) -> tuple[Row, ...]:
        """All rows: objects, proposals, contours that bound none of them, closed ones first, and what is rejected."""
        scene, image = self._session.scene, self._session.image
        made_of = self.objects, scene.objects.proposals, scene.contours, self._figures, image
        return self._parts.named("rows", self._listed, *made_of)

    def _listed(self) -> tuple[Row, ...]:
        known, proposals = self.objects, self._session.scene.objects.proposals
        offered = self._parts.get(_as_objects, proposals, known)
        lines = _boundaries((*known.items, *offered, *known.rejected))
        alike = frozenset(map(id, lines))  # no others when a proposal becomes an object
        own, self._lines = self._parts.named(
            "own", lambda: (self._review.apart(lines), lines), self._session.scene.contours, alike
        )
        keys = [each.key for each in proposals if each.selection.found]

        def row(kind: Kind, one: SegmentedObject, key: Key | None = None, title: str = "") -> Row:
            title = title or self.title(one)
            return Row(key or ("object", one.number), kind, title, one, figures=self.figures(one))

        rows = [
            *(row("object", one) for one in known.items),
            *(row("proposal", one, ("proposal", key), tr("proposal {number}", number=-key or 1 - min(keys)))
              for key, one in zip(keys, offered, strict=True)),
            *(row("rejected", one) for one in known.rejected),
            *(Row(("contour", one.key), "rejected" if one.reviewed.rejected else
                  "closed" if one.contour.closed else "open", one.title, contour=one) for one in own),
        ]  # fmt: skip
        return tuple(sorted(rows, key=lambda row: KINDS.index(row.kind)))

    @property
    def selected(self) -> frozenset[Key]:
        """Keys of the selected rows."""
        scene = self._session.scene
        return frozenset((
            *(("object" if number > 0 else "proposal", number) for number in scene.objects.chosen),
            *(("contour", key) for key in scene.selected_contours),
        ))  # fmt: skip

    @property
    def selected_rows(self) -> tuple[Row, ...]:
        """The selected rows, those among them that are listed."""
        selected = self.selected
        return tuple(row for row in self.rows if row.key in selected) if selected else ()

    def figures(self, item: SegmentedObject) -> Figures | None:
        """Figures of an object; None while they are not known for its boundary in the present image."""
        image, _, figures = self._figures.get(id(_boundary(item)), (None, None, None))
        return figures if image is self._session.image else None

    def title(self, item: SegmentedObject) -> str:
        """Name of an object, or the name of its class and its number."""
        return objects.title(self.objects, item)

    def under(self, at: Place) -> int:
        """Number of the smallest shown object at a place (row, col) [px], or (plane, row, col); 0 for none."""
        if len(at) == 3:
            around = [item for item in self.objects.items if not item.hidden and holds(item, at)]
        else:
            place = np.array([at], float)
            around = [item for item in self.near(place, 0.0) if item.encloses(place)[0]]
        return min(around, key=size_of).number if around else 0

    def near(self, places: Array, reach: float) -> list[SegmentedObject]:
        """The shown objects whose boxes come within reach of one of some places, shape (N, 2) [px]."""
        shown = [item for item in self.objects.items if not item.hidden and item.boundary]
        low, high = np.array([item.box for item in shown]).reshape(-1, 2, 2).swapaxes(0, 1)
        meets = ((low <= places.max(axis=0) + reach) & (high >= places.min(axis=0) - reach)).all(axis=1)
        return [item for item, near in zip(shown, meets.tolist(), strict=True) if near]

    def at(self, place: Place, reach: float, areas: bool = True) -> Key | None:
        """The row at a place: a contour within `reach` [px], or else the smallest one around it.

        The inside of a closed contour counts only where `areas` do; that of objects and proposals always does.
        """
        lines = self._review.near(place, reach) if len(place) == 2 else []
        listed = {row.key for row in self.rows}
        for item in lines:
            if ("contour", item.key) in listed:
                return "contour", item.key
        close = {("object", item.number) for item in self.near(np.array([place]), 0.0)} if len(place) == 2 else listed
        rows = [row for row in self.rows if row.key in close or (row.kind != "object" and (areas or row.item))]
        around = [row for row in rows if _holds(row, place)]
        if around:
            return min(around, key=_size).key
        away = [
            (polyline.distances_from_closed(row.drawn.boundary, np.array([place]))[0], row.key)
            for row in self.rows if lines and row.drawn is not None and row.drawn.boundary
        ]  # fmt: skip
        return min(away)[1] if away else None

    def within(self, outline: Sequence[Position]) -> frozenset[Key]:
        """Keys of the shown rows that lie inside a closed outline of places (row, col) for half of their length."""
        contours = self._review.within(outline)

        def inside(row: Row) -> bool:
            if row.contour is not None:
                return row.contour.key in contours
            corners = row.drawn.boundary if row.drawn is not None else ()
            return bool(corners) and bool(polyline.inside(outline, np.concatenate(corners)).mean() >= 0.5)

        return frozenset(row.key for row in self.rows if inside(row))

    # The brush

    @property
    def brush(self) -> float:
        """Radius of the brush that paints objects [px of the image]."""
        return self._brush or first_radius(self._session.document.image)

    def set_brush(self, radius: float | None) -> None:
        """Set the radius of the brush [px]; for None it depends on the size of the image again."""
        self._brush = radius
        self.brush_changed.emit(self.brush)

    def turn_brush(self, way: Literal["ball", "over_others"]) -> None:
        """Let the brush paint in space in a volume, or in a slice; over other objects, or beside them."""
        setattr(self, way, not getattr(self, way))
        self.brush_changed.emit(self.brush)

    # Selecting

    def select(self, keys: Iterable[Key]) -> None:
        """Select only these rows."""
        keys = list(keys)
        lines = [number for kind, number in keys if kind == "contour"]
        self._review.choose(lines, (number for kind, number in keys if kind != "contour"))

    def choose(self, numbers: Iterable[int]) -> None:
        """Select only the objects of these numbers, and the proposals of these keys."""
        self._review.choose(objects=numbers)

    def hover(self, key: Key | None) -> None:
        """Highlight a row, or nothing."""
        kind, number = key or ("", 0)
        self._review.hover(number if kind == "contour" else None)
        scene = self._session.scene
        hovered = 0 if kind == "contour" else number
        if hovered != scene.objects.hovered:
            self._session.show(replace(scene, objects=replace(scene.objects, hovered=hovered)))

    # Accepting and rejecting

    @property
    def open_rows(self) -> list[Row]:
        """What can be accepted: the object that is being selected, or else the selected rows; all proposals without."""
        if self.objects.clicks:
            return [row for row in self.rows if row.key == _DRAFT]
        selected = [row for row in self.selected_rows if row.kind != "object"]
        return selected or [row for row in self.rows if row.kind == "proposal" and not self.selected]

    @property
    def meant(self) -> list[Row]:
        """What is accepted of `open_rows`: doubtful ones next to others have to be selected."""
        rows, picked = self.open_rows, bool(self.selected)
        sure = [row for row in rows if picked or (row.item is not None and row.item.confidence >= DOUBTFUL)]
        return sure or rows

    def accept(self) -> None:
        """Make objects of what is meant: proposals and closed contours; open ones are kept.

        What has been rejected is there again.
        """
        offered, rows = self.open_rows, self.meant
        if not rows:
            self._session.say(tr("There is nothing to accept: click in an object first."))
            return
        self._with_objects(tr("accept {what}"), rows)
        self._session.seal()
        if len(rows) < len(offered):
            self._session.say(tr("Doubtful proposals are left: select one to accept it."), topic=EDITING)

    def reject(self) -> None:
        """Dismiss the selected proposals, remove objects, and mark contours as rejected, those around them too.

        Without a selection, all proposals are dismissed; the object that is being selected is dropped.
        """
        rows = [row for row in self.selected_rows or self.open_rows if row.kind != "rejected"]
        draft = any(row.key == _DRAFT for row in rows)
        offered = [row.item for row in rows if row.item is not None and row.kind == "proposal" and row.key != _DRAFT]
        numbers = [row.key[1] for row in rows if row.kind == "object"]
        lines = self._targets(rows)

        def edit(document: Document) -> Document:
            marked = contours.judge(document, lines, "rejected")
            marked = objects.select(marked, ()) if draft else marked  # the user has asked for it, and may ask again
            return objects.reject(marked, numbers, offered)

        self._edit(tr("reject {what}"), rows, edit)

    def delete(self) -> None:
        """Remove the selected objects, and dismiss or reject the rest; rejected objects are forgotten."""
        rows = self.selected_rows
        if all(row.key[0] == "object" for row in rows):
            self._edit(tr("delete {what}"), rows, lambda d: objects.delete(d, [row.key[1] for row in rows]))
        else:
            self.reject()

    # Editing

    def rename(self, key: Key, name: str) -> None:
        """Name a row, unless it has gone while its name was typed; a proposal and a closed contour are accepted."""
        rows = [row for row in self.rows if row.key == key and row.name != name.strip()]
        if rows and (rows[0].kind in ("proposal", "closed")):
            self._with_objects(tr("name {what}"), rows, lambda d, numbers: objects.rename(d, numbers, name))
        elif rows and rows[0].contour is not None:
            targets = self._review.targets([rows[0].contour])
            self._edit(tr("name {what}"), rows, lambda d: contours.rename(d, targets, name))
        else:
            self._edit(tr("name {what}"), rows, lambda d: objects.rename(d, (key[1],), name))

    def classify(self, category: int) -> None:
        """Give the selected objects, and the next ones, a class; proposals and closed contours are accepted.

        Without a selection the object that is being selected is accepted too.
        """
        known, rows = self.objects, [row for row in self.selected_rows if row.kind in ("object", "proposal", "closed")]
        if not rows and known.clicks:
            rows = self.open_rows
        used = {item.category for item in known.items}
        words = tr("class of {what}") if rows else tr("class of the next objects")
        self._with_objects(words, rows, lambda document, numbers: objects.classify(document, numbers, category))
        if rows and category not in used and used - {category} and not known.classes[category - 1].name:
            self.class_begun.emit(category)

    def name_class(self, category: int, name: str, color: str = "") -> None:
        """Name a class, and change its color unless that is empty."""
        self._session.edit(tr("name class"), lambda document: objects.name_class(document, category, name, color))

    def paint(self, color: str) -> None:
        """Color the selected objects and contours; an empty color is that of their class, or of contours."""
        rows = [row for row in self.selected_rows if row.kind != "proposal"]
        numbers = [row.item.number for row in rows if row.item is not None]
        targets = self._review.targets(row.contour for row in rows if row.contour is not None)

        def edit(document: Document) -> Document:
            return objects.amend(contours.paint(document, targets, color), numbers, color=color)

        self._edit(tr("color {what}"), rows, edit)

    def toggle(self, state: Literal["frozen", "hidden"]) -> None:
        """Freeze or hide objects, or take that back when all are so."""
        on = not all(getattr(item, state) for item in self.items)
        words = {
            "hidden": (tr("show {what}"), tr("hide {what}")),
            "frozen": (tr("unfreeze {what}"), tr("freeze {what}")),
        }
        self.do(words[state][on], lambda d, chosen: objects.amend(d, chosen, **{state: on}))

    def do(self, words: str, edit: Callable[[Document, Collection[int]], Document]) -> None:
        """Edit the selected objects; `words` say what is done to ``{what}``."""
        rows = [row for row in self.selected_rows if row.kind == "object"]
        numbers = [row.key[1] for row in rows]
        self._edit(words, rows, lambda document: edit(document, numbers))

    def merge(self) -> None:
        """Make one object of several; in a volume that is done on another thread."""
        rows = [row for row in self.selected_rows if row.kind in ("object", "proposal", "closed")]
        if not self._session.document.is_about_volume:
            if len(rows) > 1:
                self._with_objects(tr("merge {what}"), rows, objects.merge)
            return
        items, rows = self.items, [row for row in rows if row.kind == "object"]

        def use(whole: SegmentedObject) -> None:
            self._edit(tr("merge {what}"), rows, lambda document: objects.merge_into(document, items, whole))
            self.choose((whole.number,))

        if len(items) > 1:
            self._change_later(items, lambda: reduce(union, items), use)

    def fill_between(self) -> None:
        """Fill the slices between those across the axis in use that the selected object of a volume is painted in."""
        slices, image, items = self._session.scene.slices, self._session.document.image, self.items
        if slices is None or image is None or len(items) != 1:
            return
        (item,), axis, over_others = items, slices.axis, self.over_others
        name = self.title(item)

        def use(found: tuple[Part, int]) -> None:
            part, count = found
            if not count:
                self._session.say(tr("{name} has no gap between the slices across this axis.", name=name))
                return
            words = tr("fill {what} between slices", what=name)
            self._session.edit(words, partial(paint_in_volume, number=item.number, part=part, over_others=over_others))
            self._session.say(tr("Slices of {name} that were filled: {count}.", name=name, count=count))

        self._change_later(items, lambda: between_slices(item.surface[0], axis, image.spacing), use)

    def whole(self, row: Row) -> SegmentedObject | None:
        """The object that a row is, or would be once it is accepted; None for one that is hidden, rejected or open."""
        return next(iter(self._bounded([row])), row.drawn)

    def split_in_volume(self, whole: SegmentedObject, first: Place, second: Place) -> None:
        """Split an object of a volume between two places, on another thread, unless it has changed meanwhile."""
        image = self._session.document.image
        if image is not None:
            sides, items = sides_of(image.spacing), [one for one in self.objects.items if one is whole]
            cut: Callable[[], Halves] = lambda: split_in_volume(whole, first, second, sides)  # noqa: E731
            self._change_later(items, cut, partial(self.split, whole))

    def split(self, whole: SegmentedObject, halves: Halves) -> None:
        """Put the halves of an object, or of what is not accepted yet, in its place, and choose them."""
        before = {item.number for item in self.objects.items} - {whole.number}
        words = tr("split {what}", what=self.title(whole))
        self._session.edit(words, lambda document: objects.split(document, whole, halves))
        self.choose(item.number for item in self.objects.items if item.number not in before)

    def close(self) -> None:
        """End the threads."""
        self._latest.close()
        self._merging.close()

    # Internal

    def _with_objects(
        self,
        words: str,
        rows: Sequence[Row],
        then: Callable[[Document, Collection[int]], Document] = lambda document, _: document,
    ) -> None:
        """Make objects of rows, keep open ones, and do what follows with the numbers of all objects."""
        given = [row.item for row in rows if row.item is not None and row.kind != "object"] + self._bounded(rows)
        kept, undecided = (self._targets([row for row in rows if row.kind == kind]) for kind in ("open", "rejected"))
        ends = any(row.key == _DRAFT for row in rows)
        old = {row.key[1] for row in rows if row.kind == "object"}
        numbers: list[int] = []

        def edit(document: Document) -> Document:
            before = {item.number for item in document.objects.items}
            document = contours.judge(contours.judge(document, kept, "kept"), undecided, "")
            document = objects.accept(document, given, ends=ends)
            changed = old | {item.number for item in given}
            numbers[:] = [n.number for n in document.objects.items if n.number in changed or n.number not in before]
            return then(document, numbers)

        with self._session.gathering():
            self._edit(words, rows, edit)
            if given:
                self.choose(item.number for item in self.objects.items if item.number in numbers)

    def _targets(self, rows: Sequence[Row]) -> list[Target]:
        """The contours that rows are, and those that run along their boundaries."""
        apart = {item.key for item in self._review.apart(_boundaries(row.item for row in rows if row.item))}
        left = apart - {row.contour.key for row in rows if row.contour}
        return self._review.targets(item for item in self._review.items if item.key not in left)

    def _bounded(self, rows: Sequence[Row]) -> list[SegmentedObject]:
        """The objects that closed contours make, not accepted yet: each with the holes directly in it, and bridges.

        A contour in a hole of a selected one bounds an object of its own again.
        """
        known, result = self.objects, self._review.result
        closed = {item.measures.number: item for item in self._review.items
                  if item.contour.closed and not item.reviewed.rejected}  # fmt: skip
        chosen = {row.contour.measures.number for row in rows if row.kind == "closed" and row.contour is not None}

        def around(number: int) -> list[int]:
            found: list[int] = []
            while number := closed[number].measures.inside if number in closed else 0:
                found.append(number)
            return [each for each in found if each in closed]

        made = []
        for number in sorted(chosen):
            outer = around(number)
            highest = next((depth for depth in reversed(range(len(outer))) if outer[depth] in chosen), -1)
            if result is not None and highest % 2:  # none is around it, or an even number of contours
                holes = [each for each in closed if around(each)[:1] == [number]]
                bounds = [closed[each].contour for each in (number, *holes)]
                gaps = (bridge.points for bridge in bridges_on(result.bridges, bounds))
                made.append(objects.bounded(known.next_number, known.category, bounds, gaps))
        return made

    def _edit(self, words: str, rows: Sequence[Row], edit: Callable[[Document], Document]) -> None:
        """Edit the document, as a step of undo that names what is edited."""
        lines = all(row.contour is not None for row in rows)
        several = tr("{count} contours") if lines else tr("{count} objects")
        what = rows[0].title if len(rows) == 1 else several.format(count=len(rows))
        if rows or "{what}" not in words:
            self._session.edit(words.format(what=what), edit)

    def _follow(self) -> None:
        """Keep the objects and proposals selected that are still there."""
        scene, known = self._session.scene, self.objects
        seen = known, self._session.image, scene.objects.proposals
        if is_same(seen, self._seen):
            return
        self._seen = seen
        numbers = {item.number for item in (*known.items, *known.rejected)}
        numbers |= {each.key for each in scene.objects.proposals}
        self._review.choose(scene.selected_contours, scene.objects.chosen & numbers)
        self.measure()
        self.changed.emit()

    def measure(self) -> None:
        """Measure what has not been measured, on another thread: large objects have many pixels."""
        image, known = self._session.image, self.objects
        offered = self._parts.get(_as_objects, self._session.scene.objects.proposals, known)
        missing = [item for item in (*known.items, *known.rejected, *offered) if self.figures(item) is None]
        if image is None or not missing or self.painting:
            return

        there = {id(_boundary(item)) for item in (*known.items, *known.rejected, *offered)}

        def use(measured: list[tuple[SegmentedObject, Figures]]) -> None:
            self._figures = {key: kept for key, kept in self._figures.items() if key in there}
            for item, figures in measured:
                self._figures[id(_boundary(item))] = image, _boundary(item), figures
            bodies = {item.number: figures.body for item, figures in measured if figures.body is not None}
            self.bodies = {**self.bodies, **bodies}
            self.changed.emit()

        self._latest.ask(lambda: [(item, _measured(item, image)) for item in missing], use)

    def _forget(self) -> None:
        """Another image has been opened."""
        self._merging.forget()
        self._figures, self.bodies = {}, {}

    def _change_later(
        self, items: Sequence[SegmentedObject], work: Callable[[], T], use: Callable[[T], object]
    ) -> None:
        """Change objects by what is made on another thread, unless they have changed meanwhile."""

        def check(made: T) -> None:
            if all(any(known is item for known in self.objects.items) for item in items):
                use(made)
            else:
                self._session.say(tr("The objects changed meanwhile: try again."), True)

        self._merging.ask(work, check)


_LEAST_MOVE = 0.3
"""Distance that the brush moves before it paints on [px]."""


class ObjectBrush:
    """Paints one object from the press of the button to its release.

    Of the objects that the brush touches, one that is chosen comes first, then the one that it is in. A brush that adds
    and touches none when it is pressed makes a new object; one that takes away waits until it comes to one.
    """

    def __init__(self, session: Session, object_list: ObjectList) -> None:
        self._session, self._list = session, object_list
        self._path: list[Place] = []
        self._before: SegmentedObject | None = None
        self._boundary: tuple[Line, ...] = ()
        self._number, self._radius, self._gesture = 0, 0.0, ""
        self._axis: int | None = None
        self.adds = True
        """Whether the stroke adds, and does not take away."""

    @property
    def painting(self) -> bool:
        """Whether a stroke has begun."""
        return bool(self._path)

    def begin(self, at: Place, radius: float, adds: bool, gesture: str, axis: int | None, fresh: bool) -> None:
        """Begin a stroke at a place, in a volume across an axis; `gesture` makes one step of undo of it.

        A `fresh` one makes a new object.
        """
        self._path, self._radius, self.adds, self._gesture, self._axis = [at], radius, adds, gesture, axis
        self._number = self._list.objects.next_number if fresh else 0
        self._before, self._boundary = None, ()
        self._list.painting = True
        self._apply()

    def paint(self, to: Place) -> None:
        """Paint on to a place."""
        if self._path and math.dist(self._path[-1], to) >= _LEAST_MOVE:
            self._path.append(to)
            self._apply()

    def end(self) -> None:
        """End the stroke; say so if it has come to no object."""
        if self._path and not self._number:
            self._session.say(tr("There is no object under the brush to erase from."))
        self._path = []
        self._list.painting = False
        self._list.measure()

    def target(self, newest: Sequence[Place], radius: float) -> SegmentedObject | None:
        """The object that a stroke along some places would paint; None where it would begin a new one.

        In a volume it is a chosen one even where the brush does not touch it, so that it continues in other slices.
        """
        under, chosen = self._list.under(newest[-1]), self._list.chosen
        if len(newest[-1]) == 3:
            near = [one for one in self._list.objects.items if one.number in {*chosen, under} and not one.hidden]
        else:
            way = polyline.sampled(np.array(newest), 0.5 * radius) if len(newest) > 1 else np.array(newest)
            near = [
                item for item in self._list.near(way, radius)
                if item.encloses(way).any() or (polyline.distances_from_closed(item.boundary, way) < radius).any()
            ]  # fmt: skip
        return min(near, key=lambda one: (one.number not in chosen, one.number != under, one.area), default=None)

    def _apply(self) -> None:
        """Paint the newest stretch of the path; a frozen object is left alone, with a word to the user."""
        image, stretch = self._session.document.image, self._path[-2:]
        if image is None:
            return
        if not self._number:
            item = self.target(stretch, self._radius)
            if item is not None and item.frozen:
                words = tr("{name} is frozen: unfreeze it to paint it, or paint another object.")
                self._session.say(words.format(name=self._list.title(item)))
                self._path = []
            if not self._path or not (item or self.adds):
                return
            self._before, self._boundary = item, item.boundary if item else ()
            self._number = item.number if item else self._list.objects.next_number
        self._session.edit(tr("paint object"), self._painted(image, stretch), self._gesture)
        there = any(item.number == self._number for item in self._list.objects.items)
        self._list.choose((self._number,) if there else ())

    def _painted(self, image: ImageReference, stretch: Sequence[Place]) -> Callable[[Document], Document]:
        """The edit that paints a stretch of the path."""
        if image.is_volume:
            part = brush_in(image.shape, stretch, self._radius, sides_of(image.spacing), self._axis)
            return partial(
                paint_in_volume,
                number=self._number,
                part=part,
                adds=self.adds,
                over_others=self._list.over_others,
            )
        self._boundary = painted(self._boundary, stretch, self._radius, self.adds, image.shape)
        return partial(
            brushed,
            before=self._before,
            number=self._number,
            boundary=self._boundary,
            path=tuple(self._path),
            radius=self._radius,
        )
