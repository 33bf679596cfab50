"""The list of objects and proposals, and the selection among them and the contours."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.document import objects
from cpm_app.session.features.background import IdentityCache, is_same_input
from cpm_app.session.features.contour_selection import CONTOUR_PREFERENCE, ContourSelection
from cpm_app.session.features.object_measures import ObjectMeasurer
from cpm_app.session.features.object_rows import (
    DRAFT_KEY,
    ItemKey,
    ObjectRow,
    list_rows,
    objects_from_proposals,
)
from cpm_app.session.session import Session
from cpm_core.numerics import Array, Place, Position, polyline
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects
from cpm_core.results import is_likely
from cpm_core.shapes import Everywhere


class ObjectList(QObject):
    """Lists objects and proposals, and finds and selects them and the contours of the run."""

    changed = Signal()
    """The rows, their classes or their gray values have changed."""
    selection_changed = Signal()
    """The selection has changed."""

    def __init__(self, session: Session, contour_selection: ContourSelection) -> None:
        super().__init__(session)
        self._session, self._contour_selection = session, contour_selection
        self._listed_inputs: tuple[object, ...] = ()
        """Objects, image and proposals that the rows were made from."""
        self._parts = IdentityCache()
        self.measurer = ObjectMeasurer(session)
        """The figures of the objects and of the proposals."""
        self._measuring_paused = False
        session.document_changed.connect(self._on_scene_changed)
        session.store.scene_changed.connect(self._on_scene_changed)
        self.measurer.measured.connect(self.changed)
        contour_selection.selection_changed.connect(self.selection_changed)

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
        """All rows: objects, and then proposals."""
        scene, image = self._session.scene, self._session.image
        made_of = self.objects, scene.objects.proposals, self.measurer.figures, image
        return self._parts.get_named("rows", self._list_rows, *made_of)

    def _list_rows(self) -> tuple[ObjectRow, ...]:
        proposals = self._session.scene.objects.proposals
        return list_rows(self.objects, proposals, self._offered_objects, self.measurer.figures_of)

    @property
    def _offered_objects(self) -> tuple[SegmentedObject, ...]:
        """The objects that the proposals would become."""
        return self._parts.get(objects_from_proposals, self._session.scene.objects.proposals, self.objects)

    @property
    def selected_keys(self) -> frozenset[ItemKey]:
        """Keys of everything that is selected."""
        scene = self._session.scene
        return frozenset((
            *(("object" if number > 0 else "proposal", number) for number in scene.objects.selected),
            *(("contour", index) for index in scene.selected_contours),
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
            around = [item for item in self.objects.items if not item.hidden and item.region.contains(at)]
        else:
            place = np.array([at], float)
            around = [item for item in self.objects_near(place, 0.0) if item.region.contains(at)]
        return min(around, key=lambda item: item.region.size).number if around else 0

    def objects_near(self, places: Array, distance: float) -> list[SegmentedObject]:
        """Find the shown objects whose bounding boxes are within `distance` of places, shape (N, 2) [px]."""
        return _items_near(self.objects.items, places, distance)

    def item_at(self, place: Place, distance: float) -> ItemKey | None:
        """Find what lies at a place: an outline or a contour within `distance` [px], or else the smallest area.

        Contours along the outlines of objects and proposals yield to these.
        """
        rows = {id(row.item): row for row in self.rows}
        if len(place) == 3:
            around = [row.item for row in self.rows if not row.item.hidden and row.item.region.contains(place)]
        else:
            at = np.array([place], float)
            near = _items_near([row.item for row in self.rows], at, distance)
            found: list[tuple[float, ItemKey]] = []
            for item in near:
                away = min(polyline.distances_to_path(path, at)[0] for path in item.paths)
                if away <= distance:
                    found.append((float(away) - CONTOUR_PREFERENCE, rows[id(item)].key))
            for index in self._contour_selection.contours_near(place, distance)[:1]:
                path = self._session.scene.contours[index].path
                found.append((polyline.distance_to_path(path, place), ("contour", index)))
            if found:
                return min(found)[1]
            around = [item for item in near if item.region.contains(place)]
        return rows[id(min(around, key=lambda item: item.region.size))].key if around else None

    def items_inside(self, outline: Sequence[Position]) -> frozenset[ItemKey]:
        """Find what lies at least half inside a closed outline of (row, col); contours only if nothing else does."""
        shown = ((row.key, row.item.paths) for row in self.rows if not row.item.hidden)
        found = frozenset(
            key
            for key, paths in shown
            if paths and polyline.points_inside(outline, np.concatenate(paths)).mean() >= 0.5
        )
        return found or frozenset(("contour", index) for index in self._contour_selection.contours_inside(outline))

    # Selecting

    def select_items(self, keys: Iterable[ItemKey]) -> None:
        """Select only these objects, proposals and contours."""
        keys = list(keys)
        contours = [index for kind, index in keys if kind == "contour"]
        self._contour_selection.select(contours, (number for kind, number in keys if kind != "contour"))

    def select_objects(self, numbers: Iterable[int]) -> None:
        """Select only the objects of these numbers, and the proposals of these keys."""
        self._contour_selection.select(objects=numbers)

    def set_hovered_item(self, key: ItemKey | None) -> None:
        """Highlight an object, a proposal or a contour, or nothing."""
        kind, number = key or ("", 0)
        self._contour_selection.set_hovered(number if kind == "contour" else None)
        scene = self._session.scene
        hovered = 0 if kind == "contour" else number
        if hovered != scene.objects.hovered:
            self._session.store.set_scene(replace(scene, objects=replace(scene.objects, hovered=hovered)))

    # Accepting

    @property
    def pending_rows(self) -> list[ObjectRow]:
        """Rows that can be accepted: the object being selected, else the selected proposals, else all if nothing is."""
        if self.objects.clicks:
            return [row for row in self.rows if row.key == DRAFT_KEY]
        if self.selected_keys:
            return [row for row in self.selected_rows if row.kind != "object"]
        return [row for row in self.rows if row.kind == "proposal"]

    @property
    def rows_to_accept(self) -> list[ObjectRow]:
        """The `pending_rows` that Enter accepts: those that are selected, else the likely ones and the user's own.

        The object being selected is the user's own, and so are objects followed from another page, and one that is
        alone after a run from a drawn start.
        """
        rows = self.pending_rows
        if self.selected_keys or self.objects.clicks:
            return rows
        alone = len(rows) == 1 and not any(isinstance(start, Everywhere) for start in self._session.document.starts)
        offered = {each.key: each for each in self._session.scene.objects.proposals}
        own = {key for key, each in offered.items() if alone or each.followed_object is not None}
        return [row for row in rows if row.key[1] in own or is_likely(offered[row.key[1]].selection)]

    # Measuring

    def pause_measuring(self) -> None:
        """Pause measuring while an object is being painted."""
        self._measuring_paused = True

    def resume_measuring(self) -> None:
        """Measure again, also what has changed meanwhile."""
        self._measuring_paused = False
        self._measure_missing()

    # Internal

    def _on_scene_changed(self) -> None:
        """Deselect objects and proposals that have disappeared, and measure new ones."""
        scene, known = self._session.scene, self.objects
        seen = known, self._session.image, scene.objects.proposals
        if is_same_input(seen, self._listed_inputs):
            return
        self._listed_inputs = seen
        numbers = {item.number for item in known.items}
        numbers |= {each.key for each in scene.objects.proposals}
        self._contour_selection.select(scene.selected_contours, scene.objects.selected & numbers)
        self._measure_missing()
        self.changed.emit()

    def _measure_missing(self) -> None:
        if not self._measuring_paused:
            known = self.objects
            self.measurer.measure_objects((*known.items, *self._offered_objects))


def _items_near(items: Sequence[SegmentedObject], places: Array, distance: float) -> list[SegmentedObject]:
    """Find the shown ones of objects in an image whose bounding boxes are within `distance` of places."""
    shown = [item for item in items if not item.hidden and item.paths]
    low, high = np.array([item.box for item in shown]).reshape(-1, 2, 2).swapaxes(0, 1)
    meets = ((low <= places.max(axis=0) + distance) & (high >= places.min(axis=0) - distance)).all(axis=1)
    return [item for item, near in zip(shown, meets.tolist(), strict=True) if near]
