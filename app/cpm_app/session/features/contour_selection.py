"""The selection of contours, objects and proposals, and contours at places."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.session.session import Session
from cpm_core import Contour
from cpm_core.contours import build_path_tree
from cpm_core.contours.contour import Contours
from cpm_core.numerics import PathTree, Position, polyline
from cpm_core.numerics.types import Integers

_SAMPLES_PER_CONTOUR = 24
"""Number of points of a contour that are compared with an outline."""


CONTOUR_PREFERENCE = 1.0
"""Distance by which a contour has to be nearer than the outline of an object to be hit instead of it [px]."""


class ContourSelection(QObject):
    """Finds and selects the contours of the scene, which are known by their indices until others replace them.

    There is one selection: objects, proposals and contours are selected together by `select`.
    """

    changed = Signal()
    """The contours have changed."""
    selection_changed = Signal()
    """The selection has changed."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._contours: Contours = ()
        self._around: PathTree | None = None
        session.store.scene_changed.connect(self._on_scene_changed)
        session.image_changed.connect(self.select)

    @property
    def selected_indices(self) -> frozenset[int]:
        """Indices of the selected contours."""
        return self._session.scene.selected_contours

    @property
    def selected_contours(self) -> tuple[Contour, ...]:
        """The selected contours."""
        return tuple(self._session.scene.contours[index] for index in sorted(self.selected_indices))

    def contours_near(self, place: Position, distance: float) -> Integers:
        """Find the indices of the contours within `distance` [px] of a place (row, col), nearest first."""
        if self._around is None:
            self._around = build_path_tree(self._session.scene.contours)
        return tuple(self._around.paths_near(place, distance))

    def contours_inside(self, outline: Sequence[Position]) -> frozenset[int]:
        """Find the indices of the contours at least half inside a closed outline of places (row, col)."""
        paths = [contour.path for contour in self._session.scene.contours]
        if not paths:
            return frozenset()
        places = polyline.midpoints_of_paths(paths, _SAMPLES_PER_CONTOUR).reshape(-1, 2)
        inside = polyline.points_inside(outline, places).reshape(-1, _SAMPLES_PER_CONTOUR).mean(axis=1)
        return frozenset(np.flatnonzero(inside >= 0.5).tolist())

    def select(self, contours: Iterable[int] = (), objects: Iterable[int] = ()) -> None:
        """Select only the contours of these indices, and the objects of these numbers, or proposals of keys below 0."""
        scene, numbers = self._session.scene, frozenset(objects)
        indices = frozenset(index for index in contours if index < len(scene.contours))
        if (indices, numbers) != (scene.selected_contours, scene.objects.selected):
            shown = replace(scene.objects, selected=numbers)
            with self._session.store.draw_once():
                self._session.store.set_scene(replace(scene, selected_contours=indices, objects=shown))
                self.selection_changed.emit()

    def set_hovered(self, index: int | None) -> None:
        """Set the contour under the pointer, None for none."""
        scene = self._session.scene
        if index != scene.hovered_contour:
            self._session.store.set_scene(replace(scene, hovered_contour=index))

    def _on_scene_changed(self) -> None:
        scene = self._session.scene
        if scene.contours is self._contours:
            return
        self._contours, self._around = scene.contours, None
        self.select((), scene.objects.selected)
        self.set_hovered(None)
        self.changed.emit()
