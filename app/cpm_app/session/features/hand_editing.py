"""Manual editing of contours: hits of the pointer, lines that follow edges, and the edits."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.document.contours import HAND_EDIT_NAMES, add_hand_edits, drop_hand_edits
from cpm_app.model.document.objects import accept_objects, object_from_contours, object_title
from cpm_app.model.text.language import tr
from cpm_app.session.features.contour_review import ContourReview
from cpm_app.session.scene import ContourItem, ReviewedContours
from cpm_app.session.session import Session
from cpm_app.session.worker.requests import EDGES_CATEGORY, find_edges
from cpm_core import Contour
from cpm_core.contours import HandEdit, build_path_tree
from cpm_core.field import ScaleField
from cpm_core.numerics import Array, PathTree, Position
from cpm_core.numerics.types import Callback, Integers
from cpm_core.objects.segmented import (
    SegmentedObject,
    SegmentedObjects,
    contours_from_object,
    mark_gaps,
    redraw_boundary,
)
from cpm_core.parameters import find_invalidating
from cpm_core.reconstruction import (
    Contact,
    LiveWire,
    chain_contours,
    cut_contour,
    delete_stretch,
    live_wire_from,
    snap_place_to_ridge,
)

PathFinder = Callable[[Position], Array]
"""Finds the path from a fixed place to another one, shape (K, 2) [px]."""

_SNAP_DISTANCE = 3.0
"""Distance from an edge within which a clicked place is moved onto it [px]."""

_CONTOUR_PREFERENCE = 1.0
"""Distance by which a contour has to be nearer than the boundary of an object to be hit instead of it [px]."""

_UNMATCHED_TEXT = tr(
    "{count} of {all} manual edits no longer match a contour. Their lines stay; the menu Objects removes them."
)


class HandEditing(QObject):
    """Edits the contours of the scene by hand, and holds the places marked on one of them.

    The edges are requested when they are first needed; until they arrive, lines are straight.
    """

    changed = Signal()
    """The marked places have changed."""

    def __init__(self, session: Session, review: ContourReview) -> None:
        super().__init__(session)
        self.marked_places: tuple[Contact, ...] = ()
        self._session = session
        self._review = review
        self._contours: ReviewedContours | None = None
        self._lines: tuple[SegmentedObjects, list[tuple[SegmentedObject, Contour]], PathTree] | None = None
        """Objects, and the boundary curves of the shown ones."""
        self._ends: tuple[list[Contour], Array] | None = None
        """The open contours, and both ends of each in turn, shape (2 N, 2) [px]."""
        self.edges: ScaleField | None = None
        """Fields of the image whose edges the lines follow; None until they arrive."""
        self._asked: tuple[object, ...] = ()
        self._then: Callback | None = None
        """Called as soon as the edges arrive."""
        self._reported: Integers = ()
        session.image_changed.connect(self._on_image_changed)
        session.store.scene_changed.connect(self._on_scene_changed)

    # Hits of the pointer

    def request_edges(self) -> None:
        """Request the edges of the image, unless they are there or have been requested."""
        document, generation = self._session.document, self._session.store.image_generation
        wanted = (
            generation,
            document.regions,
            *(getattr(document.parameters, name) for name in find_invalidating("field")),
        )
        if document.image is not None and wanted != self._asked:
            self._asked = wanted
            self._session.messages.clear(EDGES_CATEGORY)

            def on_edges_found(edges: ScaleField) -> None:
                if generation == self._session.store.image_generation:
                    self.edges = edges
                    then, self._then = self._then, None
                    if then is not None:
                        then()

            self._session.post_command(find_edges(generation, document.parameters, on_edges_found))

    def find_contact(self, at: Position, reach: float) -> Contact | None:
        """Find the end of a contour within reach of a place [px], or else the nearest place on a contour, or None.

        Of several ends at a junction, the one of the contour nearest to the place is returned.
        """
        if self._ends is None:  # only when the pointer asks: contours change many times a second during a run
            contours = [item.contour for item in self._review.items if not item.contour.closed]
            self._ends = contours, np.array([contour.points[[0, -1]] for contour in contours]).reshape(-1, 2)
        contours, places = self._ends
        away = np.linalg.norm(places - at, axis=1)
        near = [
            Contact.from_contour_ends(contours[index // 2])[index % 2]
            for index in np.flatnonzero(away <= reach).tolist()
        ]
        near = [end for end in near if self._find_item(end) is not None]
        if near:
            return min(near, key=lambda end: end.line.project_point(at)[1])
        lines = self._review.contours_near(at, reach)
        return Contact.from_nearest_place(lines[0].contour, at) if lines else None

    def find_boundary(self, at: Position, reach: float) -> tuple[SegmentedObject, Contact] | None:
        """Find the nearest place on the boundary of an object within `reach` [px], unless a contour is nearer."""
        objects = self._session.document.objects
        if self._lines is None or self._lines[0] is not objects:
            shown = [item for item in objects.items if not item.hidden]
            curves = [(item, contour) for item in shown for contour in contours_from_object(item)]
            self._lines = objects, curves, build_path_tree([contour for _, contour in curves])
        _, curves, around = self._lines
        found = around.paths_near(at, reach)
        if not found:
            return None
        item, contour = curves[found[0]]
        held, other = Contact.from_nearest_place(contour, at), self.find_contact(at, reach)
        if other is not None and (
            other.at_end or _CONTOUR_PREFERENCE + other.line.project_point(at)[1] < held.line.project_point(at)[1]
        ):
            return None
        return item, held

    def key_of(self, contact: Contact) -> int | None:
        """Return the key of the contour that a place lies on, None if it is gone."""
        item = self._find_item(contact)
        return None if item is None else item.key

    def mark_places(self, places: Sequence[Contact]) -> None:
        """Mark up to two places on a contour; none removes the marks."""
        self.marked_places = tuple(places)
        self.changed.emit()
        self._session.store.announce_status()

    # Lines that follow the edges

    def path_from(self, start: Position, avoided: Sequence[Array] = ()) -> PathFinder:
        """Return a finder of paths along the edges from a place; they avoid some lines, each of shape (K, 2) [px]."""
        if self.edges is None:
            return lambda place: np.array([start, place], float)
        return LiveWire(self.edges, start, avoided, [tuple(line[0].tolist()) for line in avoided]).path_to

    def path_from_end(self, end: Contact) -> PathFinder:
        """Return a finder of paths along the edges from the end of a contour, not back along it."""
        if self.edges is None:
            return self.path_from(end.place)
        return live_wire_from(self.edges, end).path_to

    def snap_to_edge(self, place: Position) -> Position:
        """Move a place onto the edge next to it, if there is one."""
        return place if self.edges is None else snap_place_to_ridge(place, self.edges, _SNAP_DISTANCE)

    # Edits

    def redraw_boundary(self, item: SegmentedObject, held: Contact, edit: HandEdit, snapping: bool) -> None:
        """Carry out an edit on the boundary of an object that was held at a place."""
        assert held.line.source is not None
        new = redraw_boundary(item, held.line.source, edit, self.edges if snapping else None)
        objects = self._session.document.objects
        self._session.edit(
            tr("redraw boundary of {what}", what=object_title(objects, item)),
            lambda document: accept_objects(document, (new,), ends=objects.edited == item.number),
        )

    def add_outline(self, path: Array) -> int:
        """Make an object of a drawn closed line, shape (K, 2) [px]; return its number."""
        objects = self._session.document.objects
        item = mark_gaps(object_from_contours(objects.next_number, objects.category, [Contour(path, True)]), self.edges)
        self._session.edit(HAND_EDIT_NAMES["outline"], lambda document: accept_objects(document, (item,)))
        return item.number

    def add_edits(self, edits: Sequence[HandEdit]) -> None:
        """Carry out edits as one undo step."""
        if edits:
            self.mark_places(())
            self._session.edit(HAND_EDIT_NAMES[edits[-1].kind], lambda document: add_hand_edits(document, edits))

    def cut_contour(self, at: Contact) -> None:
        """Cut a contour at a place that is not one of its ends."""
        if at.at_end:
            self._session.messages.show(tr("A contour cannot be cut at its end: click farther along it."))
        else:
            self.add_edits((cut_contour(at),))

    def delete_stretch(self) -> None:
        """Delete the stretch between the two marked places, which lie on one contour."""
        if len(self.marked_places) == 2:
            self.add_edits((delete_stretch(*self.marked_places),))

    def join_selected(self, closing: bool) -> None:
        """Join the selected contours by their nearest ends, to a closed one if `closing`."""
        contours = [item.contour for item in self._review.selected_items if not item.contour.closed]
        if self.edges is None:
            self._asked, self._then = (), partial(self.join_selected, closing)  # they may have failed
            self.request_edges()
            return
        edits = chain_contours(self.edges, contours, closing)
        if not edits:
            self._session.messages.show(tr("Select an open contour to close it, or several to join them."))
            return
        self._session.edit(
            tr("close contours") if closing else HAND_EDIT_NAMES["join"],
            lambda document: add_hand_edits(document, edits),
        )

    @property
    def unmatched_edits(self) -> Integers:
        """Indices of the edits without a matching contour among the present ones."""
        found = self._session.scene.reconstruction
        return found.unmatched_edits if found is not None else ()

    def remove_edits(self, indices: Collection[int] | None = None) -> None:
        """Remove edits by their indices, by default all."""
        gone = range(len(self._session.document.hand_edits)) if indices is None else tuple(indices)
        self._session.edit(tr("remove manual edits"), lambda document: drop_hand_edits(document, gone))

    # Internal

    def _find_item(self, contact: Contact) -> ContourItem | None:
        """Return the contour of a place, if it is shown and has not been replaced."""
        found = (item for item in self._review.items if item.contour is contact.line.source)
        return next(filter(self._review.is_shown, found), None)

    def _on_image_changed(self) -> None:
        self.edges, self._lines, self._asked, self._reported, self._then = None, None, (), (), None
        self.mark_places(())

    def _on_scene_changed(self) -> None:
        contours = self._session.scene.contours
        if contours is self._contours:
            return
        self._contours = contours
        self._ends = None
        if self.marked_places:
            still = {id(item.contour) for item in contours.items}
            self.mark_places([mark for mark in self.marked_places if id(mark.line.source) in still])
        # reported once, after a run
        missed, found = self.unmatched_edits, self._session.scene.reconstruction
        if missed == self._reported or found is None or (missed and not getattr(found.result, "steps", 0)):
            return
        new = [index for index in missed if index not in self._reported]
        self._reported = missed
        if new:
            self._session.messages.show(
                _UNMATCHED_TEXT.format(count=len(missed), all=len(self._session.document.hand_edits))
            )
