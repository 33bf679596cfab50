"""Outlines edited by hand: curves under the pointer, lines that follow edges, and the edits."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from PySide6.QtCore import QObject

from cpm_app.model.document.objects import (
    accept_objects,
    copy_contours_to_objects,
    object_from_contours,
    object_title,
)
from cpm_app.model.text.language import tr
from cpm_app.session.features.contour_selection import CONTOUR_PREFERENCE, ContourSelection
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_app.session.worker.requests import EDGES_CATEGORY, find_edges
from cpm_core import Contour, Result
from cpm_core.contours import build_path_tree
from cpm_core.field import ScaleField
from cpm_core.numerics import Array, PathTree, Position
from cpm_core.numerics.types import record
from cpm_core.objects.segmented import (
    SegmentedObject,
    SegmentedObjects,
    contours_from_object,
    mark_gaps,
    redraw_boundary,
)
from cpm_core.parameters import find_invalidating
from cpm_core.reconstruction import CurvePlace, LiveWire, RedrawnCurve, snap_place_to_ridge

PathFinder = Callable[[Position], Array]
"""Finds the path from a fixed place to another one, shape (K, 2) [px]."""

_SNAP_DISTANCE = 3.0
"""Distance from an edge within which a clicked place is moved onto it [px]."""


@record
class HeldCurve:
    """A place on a curve under the pointer.

    Attributes
    ----------
    source : SegmentedObject or Result
        The object of the curve, or the result of the run that has the contour, which is not an object yet.
    index : int
        Index of the curve among those of the object, or of the contour among those of the run.
    place : CurvePlace
        The place on it.
    """

    source: SegmentedObject | Result
    index: int
    place: CurvePlace

    @property
    def item(self) -> SegmentedObject | None:
        """The object; None for a contour of the run."""
        return self.source if isinstance(self.source, SegmentedObject) else None

    def is_on_same_curve(self, other: HeldCurve) -> bool:
        """Return whether another place is on the same curve."""
        return self.place.curve is other.place.curve


class OutlineEditing(QObject):
    """Edits the outlines of objects by hand; a contour of the run becomes an object with its first edit.

    The edges are requested when they are first needed; until they arrive, lines are straight.
    """

    def __init__(self, session: Session, contour_selection: ContourSelection) -> None:
        super().__init__(session)
        self._session, self._contour_selection = session, contour_selection
        self._curves: tuple[SegmentedObjects, list[tuple[SegmentedObject, int, Contour]], PathTree] | None = None
        """Objects, and the curves of the shown ones with their indices."""
        self.edges: ScaleField | None = None
        """Fields of the image whose edges the lines follow; None until they arrive."""
        self._asked: tuple[object, ...] = ()
        session.image_changed.connect(self._on_image_changed)

    # Under the pointer

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

            self._session.post_command(find_edges(generation, document.parameters, on_edges_found))

    def find_curve(self, at: Position, reach: float) -> HeldCurve | None:
        """Find the nearest place on a curve of an object within `reach` [px], unless a contour of the run is nearer."""
        objects = self._session.document.objects
        if self._curves is None or self._curves[0] is not objects:
            shown = [item for item in objects.items if not item.hidden]
            curves = [(item, *one) for item in shown for one in enumerate(contours_from_object(item))]
            self._curves = objects, curves, build_path_tree([contour for *_, contour in curves])
        _, curves, around = self._curves
        found: list[tuple[float, HeldCurve]] = []
        for near in around.paths_near(at, reach)[:1]:
            item, index, curve = curves[near]
            place = CurvePlace.from_nearest_place(curve, at)
            found.append((place.distance_to(at) - CONTOUR_PREFERENCE, HeldCurve(item, index, place)))
        result = self._session.scene.result
        if result is not None:
            for index in self._contour_selection.contours_near(at, reach)[:1]:
                place = CurvePlace.from_nearest_place(result.contours[index], at)
                found.append((place.distance_to(at), HeldCurve(result, index, place)))
        return min(found, key=lambda one: one[0])[1] if found else None

    # Lines that follow the edges

    def path_from(self, start: Position, avoided: Sequence[Array]) -> PathFinder:
        """Return a finder of paths along the edges from a place; they avoid some lines, each of shape (K, 2) [px]."""
        if self.edges is None:
            return lambda place: np.array([start, place], float)
        return LiveWire(self.edges, start, avoided, [tuple(line[0].tolist()) for line in avoided]).path_to

    def snap_to_edge(self, place: Position) -> Position:
        """Move a place onto the edge next to it, if there is one."""
        return place if self.edges is None else snap_place_to_ridge(place, self.edges, _SNAP_DISTANCE)

    # Edits

    def redraw_curve(self, held: HeldCurve, redrawn: RedrawnCurve, snapping: bool = True) -> None:
        """Redraw a stretch of a curve; a contour of the run is accepted as an object in the same step of undo.

        Where it is not `snapping` to edges, the whole stretch is a gap.
        """
        objects, item, index = self._session.document.objects, held.source, held.index
        if isinstance(item, Result):
            item, index = copy_contours_to_objects(objects, item, (index,))[0], 0
        title = object_title(objects, item)
        if item.frozen:
            frozen = tr("{name} is frozen: unfreeze it to change it.", name=title)
            self._session.messages.show(frozen, category=EDITING_CATEGORY)
            return
        new = redraw_boundary(item, index, redrawn, self.edges if snapping else None)
        self._session.edit(
            tr("redraw boundary of {what}", what=title),
            lambda document: accept_objects(document, (new,), ends=objects.edited == item.number),
        )

    def add_outline(self, path: Array, closed: bool) -> int:
        """Make an object of a drawn line, shape (K, 2) [px], open or closed; return its number."""
        objects = self._session.document.objects
        item = object_from_contours(objects.next_number, objects.category, [Contour(path, closed)])
        item = mark_gaps(item, self.edges) if closed else item
        name = tr("draw outline") if closed else tr("draw line")
        self._session.edit(name, lambda document: accept_objects(document, (item,)))
        return item.number

    def _on_image_changed(self) -> None:
        self.edges, self._curves, self._asked = None, None, ()
