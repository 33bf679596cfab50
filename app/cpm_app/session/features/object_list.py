"""One list of objects, proposals and contours, and the selection among them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.document import objects
from cpm_app.model.volume.surface_section import object_contains, object_size
from cpm_app.session.features.background import IdentityCache, is_same_input
from cpm_app.session.features.contour_review import ContourReview
from cpm_app.session.features.object_measures import ObjectMeasurer
from cpm_app.session.features.object_rows import (
    DRAFT_KEY,
    ObjectRow,
    RowKey,
    boundary_lines,
    list_rows,
    objects_from_proposals,
    row_contains,
    row_size,
)
from cpm_app.session.session import Session
from cpm_core.numerics import Array, Place, Position, polyline
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects

MIN_SURE_CONFIDENCE = 0.7
"""Confidence below which an object is doubtful."""


class ObjectList(QObject):
    """Lists objects, proposals and contours, finds them at places, and selects among them."""

    changed = Signal()
    """The rows, their classes or their gray values have changed."""
    selection_changed = Signal()
    """The selection has changed."""

    def __init__(self, session: Session, review: ContourReview) -> None:
        super().__init__(session)
        self._session, self._review = session, review
        self._listed_inputs: tuple[object, ...] = ()
        """Objects, image and proposals that the rows were made from."""
        self._parts = IdentityCache()
        self.measurer = ObjectMeasurer(session)
        """The figures of the objects and of the proposals."""
        self._measuring_paused = False
        session.document_changed.connect(self._on_scene_changed)
        session.store.scene_changed.connect(self._on_scene_changed)
        self.measurer.measured.connect(self.changed)
        review.changed.connect(self.changed)
        review.selection_changed.connect(self.selection_changed)

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
        made_of = self.objects, scene.objects.proposals, scene.contours, self.measurer.figures, image
        return self._parts.get_named("rows", self._list_rows, *made_of)

    def _list_rows(self) -> tuple[ObjectRow, ...]:
        known, proposals, offered = self.objects, self._session.scene.objects.proposals, self._offered_objects
        lines = boundary_lines((*known.items, *offered, *known.rejected))
        alike = frozenset(map(id, lines))  # unchanged when a proposal becomes an object
        separate, _ = self._parts.get_named(  # with the lines, because the identity of a deleted one could come again
            "separate", lambda: (self._review.not_on_boundary(lines), lines), self._session.scene.contours, alike
        )
        return list_rows(known, proposals, offered, separate, self.measurer.figures_of)

    @property
    def _offered_objects(self) -> tuple[SegmentedObject, ...]:
        """The objects that the proposals would become."""
        return self._parts.get(objects_from_proposals, self._session.scene.objects.proposals, self.objects)

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
        around = [row for row in rows if row_contains(row, place)]
        if around:
            return min(around, key=row_size).key
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

    # Accepting

    @property
    def pending_rows(self) -> list[ObjectRow]:
        """Rows that can be accepted: the object being selected, else the selected rows, else all proposals."""
        if self.objects.clicks:
            return [row for row in self.rows if row.key == DRAFT_KEY]
        selected = [row for row in self.selected_rows if row.kind != "object"]
        return selected or [row for row in self.rows if row.kind == "proposal" and not self.selected_keys]

    @property
    def rows_to_accept(self) -> list[ObjectRow]:
        """The `pending_rows` that Enter accepts: doubtful ones among others only if they are selected."""
        rows, picked = self.pending_rows, bool(self.selected_keys)
        sure = [row for row in rows if picked or (row.item is not None and row.item.confidence >= MIN_SURE_CONFIDENCE)]
        return sure or rows

    # Measuring

    def pause_measuring(self) -> None:
        """Pause measuring while an object is being painted."""
        self._measuring_paused = True

    def resume_measuring(self) -> None:
        """Measure again, also what has changed meanwhile."""
        self._measuring_paused = False
        self._measure_missing()

    def close(self) -> None:
        """End the thread."""
        self.measurer.close()

    # Internal

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
        self._measure_missing()
        self.changed.emit()

    def _measure_missing(self) -> None:
        if not self._measuring_paused:
            known = self.objects
            self.measurer.measure_objects((*known.items, *known.rejected, *self._offered_objects))
