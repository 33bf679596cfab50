"""One list of objects, proposals and contours: their figures, selection and commands, and the brush."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import Literal, TypeVar, get_args

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.document import contours, objects
from cpm_app.model.document.contours import MarkTarget
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.objects import apply_brush, paint_volume_object
from cpm_app.model.text.language import tr
from cpm_app.model.volume.surface_section import object_contains, object_size
from cpm_app.session.features.background import IdentityCache, LatestOnlyWorker, is_same_input
from cpm_app.session.features.contour_review import ContourReview
from cpm_app.session.scene import ContourItem, Proposal
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_core import Image, Surface
from cpm_core.contours import select_bridges_on
from cpm_core.numerics import Array, Place, Position, polyline
from cpm_core.numerics.types import Line, record
from cpm_core.objects.segmented import (
    Halves,
    SegmentedObject,
    SegmentedObjects,
    fill_between_slices,
    paint_boundary,
    split_painted_object,
    unite_objects,
    voxelize_brush,
)
from cpm_core.objects.segmented.in_volumes import Part
from cpm_core.shapes import relative_sides

Made = TypeVar("Made")

GRAY_HISTOGRAM_BINS = 32
"""Number of bars of a histogram."""


@dataclass(frozen=True)
class ObjectFigures:
    """Figures of an object.

    Attributes
    ----------
    gray : float
        Mean gray value; NaN if it has no pixel.
    counts : tuple of int
        Numbers of pixels in `GRAY_HISTOGRAM_BINS` equal steps of gray value, over the range of the image.
    volume, area : float
        Volume and surface area of an object in a volume, in the unit of the image; 0 in an image, as are the rest.
    parts, euler : int
        Number of connected parts of its surface, and its Euler characteristic.
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


RowKey = tuple[Literal["object", "proposal", "contour"], int]
"""Identity of a row: the number of an object, the key of a proposal, which is below 1, or the key of a contour."""

_DRAFT_KEY: RowKey = ("proposal", 0)
"""The key of the object that is being selected."""

RowKind = Literal["object", "proposal", "closed", "open", "rejected"]
"""Kind of a row; rejected are objects and contours."""

ROW_KINDS: tuple[RowKind, ...] = get_args(RowKind)
"""Kinds of rows, in the order shown."""


@record
class ObjectRow:
    """One row of the list: an object, a proposal or a contour.

    Attributes
    ----------
    key : tuple of str and int
        Its identity.
    kind : {"object", "proposal", "closed", "open", "rejected"}
        Its kind; rejected are objects and contours.
    title : str
        Its name, or its kind and number.
    item : SegmentedObject or None
        The object; for a proposal with a preliminary number until it is accepted.
    contour : Item or None
        The contour; None for objects and proposals.
    figures : Figures or None
        Figures of the object; None while unknown.
    """

    key: RowKey
    kind: RowKind
    title: str
    item: SegmentedObject | None = None
    contour: ContourItem | None = None
    figures: ObjectFigures | None = None

    @property
    def name(self) -> str:
        """The name given by the user, or ""."""
        return self.item.name if self.item is not None else self.contour.contour.name if self.contour else ""

    @property
    def drawn(self) -> SegmentedObject | None:
        """The object if it is shown; None for hidden and rejected ones, and for a contour."""
        return None if self.item is None or self.item.hidden or self.kind == "rejected" else self.item


def _surface_or_boundary(item: SegmentedObject) -> object:
    return item.surface or item.boundary


def gray_histogram(values: Array, image: Image) -> tuple[int, ...]:
    """Count the values, of any shape, in each of `GRAY_HISTOGRAM_BINS` equal steps of the gray range of an image."""
    low, high = image.gray_range
    return tuple(np.histogram(values, GRAY_HISTOGRAM_BINS, (low, max(high, low + 1e-9)))[0].tolist())


def _measure_object(item: SegmentedObject, image: Image) -> ObjectFigures:
    values = image.values[item.mask(image.shape)]
    gray, counts = float(values.mean()) if len(values) else float("nan"), gray_histogram(values, image)
    body = item.unpacked_surface
    if body is None:
        return ObjectFigures(gray, counts)
    # cached on this thread, because the window's thread needs it for limits and painting
    assert all(len(packed.shell.mask) and packed.as_packed_voxels for packed in item.surface)
    surface = replace(body, spacing=image.spacing, unit=image.unit)
    volume = item.surface[0].volume * math.prod(image.spacing)
    return ObjectFigures(gray, counts, volume, surface.area, surface.components, surface.euler, body)


def _objects_from_proposals(offered: tuple[Proposal, ...], known: SegmentedObjects) -> tuple[SegmentedObject, ...]:
    """Make the objects that proposals would become, each with a unique number."""
    found = enumerate((each for each in offered if each.selection.has_boundary), start=known.next_number)
    return tuple(
        replace(each.proposed_object, number=each.number or fresh, category=(each.followed_object or known).category)
        for fresh, each in found
    )


def _boundary_lines(items: Iterable[SegmentedObject]) -> list[Line]:
    return [line for item in items for line in item.boundary]


def _row_contains(row: ObjectRow, place: Place) -> bool:
    """Return whether a place (row, col) [px], or (plane, row, col), lies inside the object or contour of a row."""
    if row.drawn is None:
        line = row.contour.contour if row.kind == "closed" and row.contour is not None else None
        return line is not None and len(place) == 2 and bool(polyline.points_inside(line.points, np.array([place]))[0])
    return object_contains(row.drawn, place)


def _row_size(row: ObjectRow) -> float:
    return object_size(row.item) if row.item is not None else row.contour.contour.area if row.contour else 0.0


MIN_SURE_CONFIDENCE = 0.7
"""Confidence below which an object is doubtful."""

BRUSH_RADIUS_RANGE = 0.5, 500.0
"""Limits of the radius of the brush [px]."""


def default_brush_radius(image: ImageReference | None) -> float:
    """Return the default radius of the brush, which depends on the size of the image [px]."""
    return max(0.03 * max(image.shape), 4.0) if image is not None else 4.0


class ObjectList(QObject):
    """Lists objects, proposals and contours, selects among them, and carries out commands on the selected ones."""

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
        """Whether the brush paints in space, not in one slice; whether it takes voxels from other objects there."""
        self.painting = False
        """Whether a stroke is going on; objects are measured only after it."""
        self._listed_inputs: tuple[object, ...] = ()
        """Objects, image and proposals that the rows were made from."""
        self._figures: dict[int, tuple[Image, object, ObjectFigures]] = {}
        """Figures in an image by the identity of the boundary, which is the same once a proposal becomes an object."""
        self.bodies: Mapping[int, Surface] = {}
        """The surfaces of the objects of a volume by number, as last measured."""
        self._parts = IdentityCache()
        self._latest = LatestOnlyWorker(session, "cpm-object-measures", tr("measuring objects"))
        self._merging = LatestOnlyWorker(session, "cpm-merging", tr("merging objects"))
        session.document_changed.connect(self._on_scene_changed)
        session.store.scene_changed.connect(self._on_scene_changed)
        session.image_changed.connect(self._on_image_changed)
        review.changed.connect(self.changed)

    # State

    @property
    def objects(self) -> SegmentedObjects:
        """The objects of the document and their classes."""
        return self._session.document.objects

    @property
    def selected_numbers(self) -> frozenset[int]:
        """Numbers of the selected objects."""
        return frozenset(number for number in self._session.scene.objects.selected if number > 0)

    @property
    def selected_objects(self) -> tuple[SegmentedObject, ...]:
        """The selected objects, in the order in which they were accepted."""
        selected = self.selected_numbers
        return tuple(item for item in self.objects.items if item.number in selected)

    @property
    def rows(self) -> tuple[ObjectRow, ...]:
        """All rows: objects, proposals, contours that bound none of them, closed ones first, and rejected ones."""
        scene, image = self._session.scene, self._session.image
        made_of = self.objects, scene.objects.proposals, scene.contours, self._figures, image
        return self._parts.get_named("rows", self._list_rows, *made_of)

    def _list_rows(self) -> tuple[ObjectRow, ...]:
        known, proposals = self.objects, self._session.scene.objects.proposals
        offered = self._parts.get(_objects_from_proposals, proposals, known)
        lines = _boundary_lines((*known.items, *offered, *known.rejected))
        alike = frozenset(map(id, lines))  # unchanged when a proposal becomes an object
        own, self._lines = self._parts.get_named(
            "own", lambda: (self._review.not_on_boundary(lines), lines), self._session.scene.contours, alike
        )
        keys = [each.key for each in proposals if each.selection.has_boundary]

        def make_row(kind: RowKind, one: SegmentedObject, key: RowKey | None = None, title: str = "") -> ObjectRow:
            title = title or self.title_of(one)
            return ObjectRow(key or ("object", one.number), kind, title, one, figures=self.figures_of(one))

        rows = [
            *(make_row("object", one) for one in known.items),
            *(make_row("proposal", one, ("proposal", key), tr("proposal {number}", number=-key or 1 - min(keys)))
              for key, one in zip(keys, offered, strict=True)),
            *(make_row("rejected", one) for one in known.rejected),
            *(ObjectRow(("contour", one.key), "rejected" if one.reviewed.rejected else
                  "closed" if one.contour.closed else "open", one.title, contour=one) for one in own),
        ]  # fmt: skip
        return tuple(sorted(rows, key=lambda row: ROW_KINDS.index(row.kind)))

    @property
    def selected_keys(self) -> frozenset[RowKey]:
        """Keys of the selected rows."""
        scene = self._session.scene
        return frozenset((
            *(("object" if number > 0 else "proposal", number) for number in scene.objects.selected),
            *(("contour", key) for key in scene.selected_contours),
        ))  # fmt: skip

    @property
    def selected_rows(self) -> tuple[ObjectRow, ...]:
        """The selected rows that are in the list."""
        selected = self.selected_keys
        return tuple(row for row in self.rows if row.key in selected) if selected else ()

    def figures_of(self, item: SegmentedObject) -> ObjectFigures | None:
        """Return the figures of an object; None while unknown for its boundary in the present image."""
        image, _, figures = self._figures.get(id(_surface_or_boundary(item)), (None, None, None))
        return figures if image is self._session.image else None

    def title_of(self, item: SegmentedObject) -> str:
        """Return the name of an object, or the name of its class and its number."""
        return objects.object_title(self.objects, item)

    def object_number_at(self, at: Place) -> int:
        """Return the number of the smallest shown object at a place (row, col) or (plane, row, col), 0 for none."""
        if len(at) == 3:
            around = [item for item in self.objects.items if not item.hidden and object_contains(item, at)]
        else:
            place = np.array([at], float)
            around = [item for item in self.objects_near(place, 0.0) if item.encloses(place)[0]]
        return min(around, key=object_size).number if around else 0

    def objects_near(self, places: Array, distance: float) -> list[SegmentedObject]:
        """Find the shown objects whose bounding boxes are within `distance` of places, shape (N, 2) [px]."""
        shown = [item for item in self.objects.items if not item.hidden and item.boundary]
        low, high = np.array([item.box for item in shown]).reshape(-1, 2, 2).swapaxes(0, 1)
        meets = ((low <= places.max(axis=0) + distance) & (high >= places.min(axis=0) - distance)).all(axis=1)
        return [item for item, near in zip(shown, meets.tolist(), strict=True) if near]

    def row_at(self, place: Place, distance: float, inside_counts: bool = True) -> RowKey | None:
        """Find the row at a place: a contour within `distance` [px], or else the smallest row that contains it.

        The inside of a closed contour counts only if `inside_counts`; the inside of objects and proposals always does.
        """
        lines = self._review.contours_near(place, distance) if len(place) == 2 else []
        listed = {row.key for row in self.rows}
        for item in lines:
            if ("contour", item.key) in listed:
                return "contour", item.key
        close = (
            {("object", item.number) for item in self.objects_near(np.array([place]), 0.0)}
            if len(place) == 2
            else listed
        )
        rows = [row for row in self.rows if row.key in close or (row.kind != "object" and (inside_counts or row.item))]
        around = [row for row in rows if _row_contains(row, place)]
        if around:
            return min(around, key=_row_size).key
        away = [
            (polyline.distances_to_closed_paths(row.drawn.boundary, np.array([place]))[0], row.key)
            for row in self.rows if lines and row.drawn is not None and row.drawn.boundary
        ]  # fmt: skip
        return min(away)[1] if away else None

    def rows_inside(self, outline: Sequence[Position]) -> frozenset[RowKey]:
        """Find the keys of the shown rows at least half inside a closed outline of places (row, col)."""
        contours = self._review.contours_inside(outline)

        def is_inside(row: ObjectRow) -> bool:
            if row.contour is not None:
                return row.contour.key in contours
            corners = row.drawn.boundary if row.drawn is not None else ()
            return bool(corners) and bool(polyline.points_inside(outline, np.concatenate(corners)).mean() >= 0.5)

        return frozenset(row.key for row in self.rows if is_inside(row))

    # The brush

    @property
    def brush_radius(self) -> float:
        """Radius of the brush that paints objects [px of the image]."""
        return self._brush or default_brush_radius(self._session.document.image)

    def set_brush_radius(self, radius: float | None) -> None:
        """Set the radius of the brush [px]; for None it depends on the size of the image again."""
        self._brush = radius
        self.brush_changed.emit(self.brush_radius)

    def toggle_brush_option(self, option: Literal["ball", "over_others"]) -> None:
        """Toggle whether the brush paints in space or in a slice, or whether it paints over other objects."""
        setattr(self, option, not getattr(self, option))
        self.brush_changed.emit(self.brush_radius)

    # Selecting

    def select_rows(self, keys: Iterable[RowKey]) -> None:
        """Select only these rows."""
        keys = list(keys)
        lines = [number for kind, number in keys if kind == "contour"]
        self._review.select(lines, (number for kind, number in keys if kind != "contour"))

    def select_objects(self, numbers: Iterable[int]) -> None:
        """Select only the objects of these numbers, and the proposals of these keys."""
        self._review.select(objects=numbers)

    def set_hovered_row(self, key: RowKey | None) -> None:
        """Highlight a row, or nothing."""
        kind, number = key or ("", 0)
        self._review.set_hovered(number if kind == "contour" else None)
        scene = self._session.scene
        hovered = 0 if kind == "contour" else number
        if hovered != scene.objects.hovered:
            self._session.store.set_scene(replace(scene, objects=replace(scene.objects, hovered=hovered)))

    # Accepting and rejecting

    @property
    def pending_rows(self) -> list[ObjectRow]:
        """Rows that can be accepted: the object being selected, else the selected rows, else all proposals."""
        if self.objects.clicks:
            return [row for row in self.rows if row.key == _DRAFT_KEY]
        selected = [row for row in self.selected_rows if row.kind != "object"]
        return selected or [row for row in self.rows if row.kind == "proposal" and not self.selected_keys]

    @property
    def rows_to_accept(self) -> list[ObjectRow]:
        """The `pending_rows` that Enter accepts: doubtful ones among others only if they are selected."""
        rows, picked = self.pending_rows, bool(self.selected_keys)
        sure = [row for row in rows if picked or (row.item is not None and row.item.confidence >= MIN_SURE_CONFIDENCE)]
        return sure or rows

    def accept_pending(self) -> None:
        """Make objects of proposals and closed contours, and keep open ones; see `rows_to_accept`.

        Rejected rows among them are restored.
        """
        offered, rows = self.pending_rows, self.rows_to_accept
        if not rows:
            self._session.messages.show(tr("There is nothing to accept: click in an object first."))
            return
        self._accept_rows(tr("accept {what}"), rows)
        self._session.end_gesture()
        if len(rows) < len(offered):
            self._session.messages.show(
                tr("Doubtful proposals are left: select one to accept it."), category=EDITING_CATEGORY
            )

    def reject_selected(self) -> None:
        """Dismiss the selected proposals, remove objects, and reject contours, including those along their boundaries.

        Without a selection, all proposals are dismissed; the object being selected is dropped.
        """
        rows = [row for row in self.selected_rows or self.pending_rows if row.kind != "rejected"]
        draft = any(row.key == _DRAFT_KEY for row in rows)
        offered = [
            row.item for row in rows if row.item is not None and row.kind == "proposal" and row.key != _DRAFT_KEY
        ]
        numbers = [row.key[1] for row in rows if row.kind == "object"]
        lines = self._contour_targets(rows)

        def reject_rows(document: Document) -> Document:
            marked = contours.set_verdict(document, lines, "rejected")
            # the draft is not kept as a rejected object: the user selected it, and may select it again
            marked = objects.set_selection_clicks(marked, ()) if draft else marked
            return objects.reject_objects(marked, numbers, offered)

        self._edit_rows(tr("reject {what}"), rows, reject_rows)

    def delete_selected(self) -> None:
        """Remove the selected objects, and dismiss or reject the rest; rejected objects are removed for good."""
        rows = self.selected_rows
        if all(row.key[0] == "object" for row in rows):
            self._edit_rows(
                tr("delete {what}"), rows, lambda d: objects.delete_objects(d, [row.key[1] for row in rows])
            )
        else:
            self.reject_selected()

    # Editing

    def rename_row(self, key: RowKey, name: str) -> None:
        """Name a row, unless it has disappeared meanwhile; a proposal or a closed contour is accepted."""
        rows = [row for row in self.rows if row.key == key and row.name != name.strip()]
        if rows and (rows[0].kind in ("proposal", "closed")):
            self._accept_rows(tr("name {what}"), rows, lambda d, numbers: objects.rename_objects(d, numbers, name))
        elif rows and rows[0].contour is not None:
            targets = self._review.edit_targets([rows[0].contour])
            self._edit_rows(tr("name {what}"), rows, lambda d: contours.rename_contours(d, targets, name))
        else:
            self._edit_rows(tr("name {what}"), rows, lambda d: objects.rename_objects(d, (key[1],), name))

    def classify_selected(self, category: int) -> None:
        """Set the class of the selected objects and of new ones; proposals and closed contours are accepted.

        Without a selection, the object being selected is accepted.
        """
        known, rows = self.objects, [row for row in self.selected_rows if row.kind in ("object", "proposal", "closed")]
        if not rows and known.clicks:
            rows = self.pending_rows
        used = {item.category for item in known.items}
        words = tr("class of {what}") if rows else tr("class of the next objects")
        self._accept_rows(words, rows, lambda document, numbers: objects.classify_objects(document, numbers, category))
        if rows and category not in used and used - {category} and not known.classes[category - 1].name:
            self.class_begun.emit(category)

    def name_class(self, category: int, name: str, color: str = "") -> None:
        """Name a class, and change its color unless that is empty."""
        self._session.edit(tr("name class"), lambda document: objects.name_class(document, category, name, color))

    def color_selected(self, color: str) -> None:
        """Color the selected objects and contours; an empty color restores the color of their class, or of contours."""
        rows = [row for row in self.selected_rows if row.kind != "proposal"]
        numbers = [row.item.number for row in rows if row.item is not None]
        targets = self._review.edit_targets(row.contour for row in rows if row.contour is not None)

        def color_rows(document: Document) -> Document:
            return objects.update_objects(contours.color_contours(document, targets, color), numbers, color=color)

        self._edit_rows(tr("color {what}"), rows, color_rows)

    def toggle_state(self, state: Literal["frozen", "hidden"]) -> None:
        """Freeze or hide the selected objects, or unfreeze or show them if all of them are frozen or hidden."""
        on = not all(getattr(item, state) for item in self.selected_objects)
        words = {
            "hidden": (tr("show {what}"), tr("hide {what}")),
            "frozen": (tr("unfreeze {what}"), tr("freeze {what}")),
        }
        self.edit_selected(words[state][on], lambda d, numbers: objects.update_objects(d, numbers, **{state: on}))

    def edit_selected(self, undo_text: str, edit: Callable[[Document, Collection[int]], Document]) -> None:
        """Edit the selected objects; `undo_text` name the edit of ``{what}`` for undo."""
        rows = [row for row in self.selected_rows if row.kind == "object"]
        numbers = [row.key[1] for row in rows]
        self._edit_rows(undo_text, rows, lambda document: edit(document, numbers))

    def merge_selected(self) -> None:
        """Merge the selected objects into one; in a volume on another thread."""
        rows = [row for row in self.selected_rows if row.kind in ("object", "proposal", "closed")]
        if not self._session.document.has_volume:
            if len(rows) > 1:
                self._accept_rows(tr("merge {what}"), rows, objects.merge_objects)
            return
        items, rows = self.selected_objects, [row for row in rows if row.kind == "object"]

        def replace_by_union(whole: SegmentedObject) -> None:
            self._edit_rows(tr("merge {what}"), rows, lambda document: objects.merge_into(document, items, whole))
            self.select_objects((whole.number,))

        if len(items) > 1:
            self._change_in_background(items, lambda: reduce(unite_objects, items), replace_by_union)

    def fill_between_slices(self) -> None:
        """Fill the slices across the axis in use between those in which the selected object is painted."""
        slices, image, items = self._session.scene.slices, self._session.document.image, self.selected_objects
        if slices is None or image is None or len(items) != 1:
            return
        (item,), axis, over_others = items, slices.axis, self.over_others
        name = self.title_of(item)

        def add_part(found: tuple[Part, int]) -> None:
            part, count = found
            if not count:
                self._session.messages.show(tr("{name} has no gap between the slices across this axis.", name=name))
                return
            words = tr("fill {what} between slices", what=name)
            self._session.edit(
                words, partial(paint_volume_object, number=item.number, part=part, over_others=over_others)
            )
            self._session.messages.show(tr("Slices of {name} that were filled: {count}.", name=name, count=count))

        self._change_in_background(items, lambda: fill_between_slices(item.surface[0], axis, image.spacing), add_part)

    def object_of_row(self, row: ObjectRow) -> SegmentedObject | None:
        """Return the object of a row, or the one that accepting it would make; None if hidden, rejected or open."""
        return next(iter(self._objects_from_contours([row])), row.drawn)

    def split_object_in_volume(self, whole: SegmentedObject, first: Place, second: Place) -> None:
        """Split an object of a volume between two places, on another thread; discarded if it has changed meanwhile."""
        image = self._session.document.image
        if image is not None:
            sides, items = relative_sides(image.spacing), [one for one in self.objects.items if one is whole]
            cut: Callable[[], Halves] = lambda: split_painted_object(whole, first, second, sides)  # noqa: E731
            self._change_in_background(items, cut, partial(self.split_object, whole))

    def split_object(self, whole: SegmentedObject, halves: Halves) -> None:
        """Replace an object, or one that is not accepted yet, by its halves, and select them."""
        before = {item.number for item in self.objects.items} - {whole.number}
        words = tr("split {what}", what=self.title_of(whole))
        self._session.edit(words, lambda document: objects.replace_by_halves(document, whole, halves))
        self.select_objects(item.number for item in self.objects.items if item.number not in before)

    def close(self) -> None:
        """End the threads."""
        self._latest.close()
        self._merging.close()

    # Internal

    def _accept_rows(
        self,
        undo_text: str,
        rows: Sequence[ObjectRow],
        edit_accepted: Callable[[Document, Collection[int]], Document] = lambda document, _: document,
    ) -> None:
        """Make objects of rows, keep open contours, and then edit the objects with the numbers of all of them."""
        given = [
            row.item for row in rows if row.item is not None and row.kind != "object"
        ] + self._objects_from_contours(rows)
        kept, undecided = (
            self._contour_targets([row for row in rows if row.kind == kind]) for kind in ("open", "rejected")
        )
        ends = any(row.key == _DRAFT_KEY for row in rows)
        old = {row.key[1] for row in rows if row.kind == "object"}
        numbers: list[int] = []

        def accept_and_edit(document: Document) -> Document:
            before = {item.number for item in document.objects.items}
            document = contours.set_verdict(contours.set_verdict(document, kept, "kept"), undecided, "")
            document = objects.accept_objects(document, given, ends=ends)
            changed = old | {item.number for item in given}
            numbers[:] = [n.number for n in document.objects.items if n.number in changed or n.number not in before]
            return edit_accepted(document, numbers)

        with self._session.store.defer_status():
            self._edit_rows(undo_text, rows, accept_and_edit)
            if given:
                self.select_objects(item.number for item in self.objects.items if item.number in numbers)

    def _contour_targets(self, rows: Sequence[ObjectRow]) -> list[MarkTarget]:
        """Return the targets of the contours of rows, and of contours along the boundaries of rows."""
        apart = {
            item.key for item in self._review.not_on_boundary(_boundary_lines(row.item for row in rows if row.item))
        }
        left = apart - {row.contour.key for row in rows if row.contour}
        return self._review.edit_targets(item for item in self._review.items if item.key not in left)

    def _objects_from_contours(self, rows: Sequence[ObjectRow]) -> list[SegmentedObject]:
        """Make objects of the closed contours of rows, not accepted yet: each with its direct holes, and bridges.

        A contour in a hole of a selected one bounds an object of its own again.
        """
        known, result = self.objects, self._review.result
        closed = {item.measures.number: item for item in self._review.items
                  if item.contour.closed and not item.reviewed.rejected}  # fmt: skip
        selected = {row.contour.measures.number for row in rows if row.kind == "closed" and row.contour is not None}

        def enclosing(number: int) -> list[int]:
            found: list[int] = []
            while number := closed[number].measures.inside if number in closed else 0:
                found.append(number)
            return [each for each in found if each in closed]

        made = []
        for number in sorted(selected):
            outer = enclosing(number)
            highest = next((depth for depth in reversed(range(len(outer))) if outer[depth] in selected), -1)
            if result is not None and highest % 2:  # enclosed by none, or by an even number of contours
                holes = [each for each in closed if enclosing(each)[:1] == [number]]
                bounds = [closed[each].contour for each in (number, *holes)]
                gaps = (bridge.points for bridge in select_bridges_on(result.bridges, bounds))
                made.append(objects.object_from_contours(known.next_number, known.category, bounds, gaps))
        return made

    def _edit_rows(self, undo_text: str, rows: Sequence[ObjectRow], edit: Callable[[Document], Document]) -> None:
        """Edit the document, as an undo step that names the edited rows."""
        lines = all(row.contour is not None for row in rows)
        several = tr("{count} contours") if lines else tr("{count} objects")
        what = rows[0].title if len(rows) == 1 else several.format(count=len(rows))
        if rows or "{what}" not in undo_text:
            self._session.edit(undo_text.format(what=what), edit)

    def _on_scene_changed(self) -> None:
        """Deselect objects and proposals that have disappeared, and measure new ones."""
        scene, known = self._session.scene, self.objects
        seen = known, self._session.image, scene.objects.proposals
        if is_same_input(seen, self._listed_inputs):
            return
        self._listed_inputs = seen
        numbers = {item.number for item in (*known.items, *known.rejected)}
        numbers |= {each.key for each in scene.objects.proposals}
        self._review.select(scene.selected_contours, scene.objects.selected & numbers)
        self.measure_missing()
        self.changed.emit()

    def measure_missing(self) -> None:
        """Measure objects without figures, on another thread, because large ones have many pixels."""
        image, known = self._session.image, self.objects
        offered = self._parts.get(_objects_from_proposals, self._session.scene.objects.proposals, known)
        missing = [item for item in (*known.items, *known.rejected, *offered) if self.figures_of(item) is None]
        if image is None or not missing or self.painting:
            return

        there = {id(_surface_or_boundary(item)) for item in (*known.items, *known.rejected, *offered)}

        def keep_figures(measured: list[tuple[SegmentedObject, ObjectFigures]]) -> None:
            self._figures = {key: kept for key, kept in self._figures.items() if key in there}
            for item, figures in measured:
                self._figures[id(_surface_or_boundary(item))] = image, _surface_or_boundary(item), figures
            bodies = {item.number: figures.body for item, figures in measured if figures.body is not None}
            self.bodies = {**self.bodies, **bodies}
            self.changed.emit()

        self._latest.submit(lambda: [(item, _measure_object(item, image)) for item in missing], keep_figures)

    def _on_image_changed(self) -> None:
        """Remove the figures, because another image has been opened."""
        self._merging.drop_waiting()
        self._figures, self.bodies = {}, {}

    def _change_in_background(
        self, items: Sequence[SegmentedObject], compute: Callable[[], Made], on_result: Callable[[Made], object]
    ) -> None:
        """Change objects by a result of another thread, unless they have changed meanwhile."""

        def use_if_unchanged(made: Made) -> None:
            if all(any(known is item for known in self.objects.items) for item in items):
                on_result(made)
            else:
                self._session.messages.show(tr("The objects changed meanwhile: try again."), True)

        self._merging.submit(compute, use_if_unchanged)


_MIN_BRUSH_MOVE = 0.3
"""Smallest distance between two points of a stroke [px]."""


class ObjectBrush:
    """Paints one object from the press of the button to its release.

    Of the objects that the brush touches, a selected one comes first, then the one under the pointer. A brush that adds
    makes a new object if it touches none when pressed; one that removes waits until it touches one.
    """

    def __init__(self, session: Session, object_list: ObjectList) -> None:
        self._session, self._list = session, object_list
        self._path: list[Place] = []
        self._before: SegmentedObject | None = None
        self._boundary: tuple[Line, ...] = ()
        self._number, self._radius, self._gesture = 0, 0.0, ""
        self._axis: int | None = None
        self.adds = True
        """Whether the stroke adds; otherwise it removes."""

    @property
    def painting(self) -> bool:
        """Whether a stroke is going on."""
        return bool(self._path)

    def begin_stroke(
        self, at: Place, radius: float, adds: bool, gesture: str, axis: int | None, makes_new: bool
    ) -> None:
        """Begin a stroke at a place, in a volume across an axis; `gesture` merges it into one undo step.

        If `makes_new`, the stroke makes a new object.
        """
        self._path, self._radius, self.adds, self._gesture, self._axis = [at], radius, adds, gesture, axis
        self._number = self._list.objects.next_number if makes_new else 0
        self._before, self._boundary = None, ()
        self._list.painting = True
        self._paint_stretch()

    def extend_stroke(self, to: Place) -> None:
        """Extend the stroke to a place."""
        if self._path and math.dist(self._path[-1], to) >= _MIN_BRUSH_MOVE:
            self._path.append(to)
            self._paint_stretch()

    def end_stroke(self) -> None:
        """End the stroke, with a message if it has touched no object."""
        if self._path and not self._number:
            self._session.messages.show(tr("There is no object under the brush to erase from."))
        self._path = []
        self._list.painting = False
        self._list.measure_missing()

    def find_target(self, newest: Sequence[Place], radius: float) -> SegmentedObject | None:
        """Find the object that a stroke along some places would paint; None if it would begin a new one.

        In a volume, a selected object is painted even where the brush does not touch it, so that it continues in other
        slices.
        """
        under, selected = self._list.object_number_at(newest[-1]), self._list.selected_numbers
        if len(newest[-1]) == 3:
            near = [one for one in self._list.objects.items if one.number in {*selected, under} and not one.hidden]
        else:
            path = polyline.sample_path(np.array(newest), 0.5 * radius) if len(newest) > 1 else np.array(newest)
            near = [
                item for item in self._list.objects_near(path, radius)
                if item.encloses(path).any() or (polyline.distances_to_closed_paths(item.boundary, path) < radius).any()
            ]  # fmt: skip
        return min(near, key=lambda one: (one.number not in selected, one.number != under, one.area), default=None)

    def _paint_stretch(self) -> None:
        """Paint the newest stretch of the path; a frozen object stays as it is, with a message."""
        image, stretch = self._session.document.image, self._path[-2:]
        if image is None:
            return
        if not self._number:
            item = self.find_target(stretch, self._radius)
            if item is not None and item.frozen:
                words = tr("{name} is frozen: unfreeze it to paint it, or paint another object.")
                self._session.messages.show(words.format(name=self._list.title_of(item)))
                self._path = []
            if not self._path or not (item or self.adds):
                return
            self._before, self._boundary = item, item.boundary if item else ()
            self._number = item.number if item else self._list.objects.next_number
        self._session.edit(tr("paint object"), self._make_edit(image, stretch), self._gesture)
        there = any(item.number == self._number for item in self._list.objects.items)
        self._list.select_objects((self._number,) if there else ())

    def _make_edit(self, image: ImageReference, stretch: Sequence[Place]) -> Callable[[Document], Document]:
        """Make the edit that paints a stretch of the path."""
        if image.is_volume:
            part = voxelize_brush(image.shape, stretch, self._radius, relative_sides(image.spacing), self._axis)
            return partial(
                paint_volume_object,
                number=self._number,
                part=part,
                adds=self.adds,
                over_others=self._list.over_others,
            )
        self._boundary = paint_boundary(self._boundary, stretch, self._radius, self.adds, image.shape)
        return partial(
            apply_brush,
            before=self._before,
            number=self._number,
            boundary=self._boundary,
            path=tuple(self._path),
            radius=self._radius,
        )
