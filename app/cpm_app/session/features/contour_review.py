"""The contours of the scene: finding them by position, and the selection of contours, objects and proposals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.document.contours import MarkTarget
from cpm_app.session.features.background import is_same_input
from cpm_app.session.scene import NO_CONTOURS, ContourItem, ReviewedContours
from cpm_app.session.session import Session
from cpm_core import Result
from cpm_core.contours import build_path_tree, find_anchors
from cpm_core.numerics import Array, Index, PathTree, Position, polyline
from cpm_core.numerics.types import Line

_SAMPLES_PER_CONTOUR = 24
"""Number of points of a contour that are compared with an outline."""

_ON_BOUNDARY_DISTANCE = 1.0
"""Distance up to which a point of a contour lies on a boundary [px]."""

_MAX_SHARE_ON_BOUNDARY = 0.9
"""Share of a contour on a boundary from which the contour counts as that boundary."""

_CORNERS_PER_PIECE = 32
"""Number of segments of a boundary that are searched together."""

_MAX_CACHED_LINES = 4096
"""Number of closed lines for which the contours along them are cached."""


class ContourReview(QObject):
    """Finds and selects the contours of the scene; if `shows_rejected`, rejected ones are shown and can be picked.

    There is one selection: objects, proposals and contours are selected together by `select`.
    """

    changed = Signal()
    """The contours or their marks have changed."""
    selection_changed = Signal()
    """The selection has changed."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.shows_rejected = True
        self._session = session
        self._contours: ReviewedContours = NO_CONTOURS
        self._around: PathTree | None = None
        self._places: Array | None = None
        self._along: dict[int, tuple[Line, Index]] = {}
        """Closed lines by identity, with the indices of the sampled points of contours along them."""
        session.store.scene_changed.connect(self._on_scene_changed)
        session.image_changed.connect(self.select)

    # State

    @property
    def items(self) -> tuple[ContourItem, ...]:
        """The contours, longest first."""
        return self._session.scene.contours.items

    @property
    def result(self) -> Result | None:
        """The reconstruction, including rejected contours."""
        return self._session.scene.contours.result

    @property
    def selected_keys(self) -> frozenset[int]:
        """Keys of the selected contours."""
        return self._session.scene.selected_contours

    @property
    def selected_items(self) -> tuple[ContourItem, ...]:
        """The selected contours."""
        selected = self.selected_keys
        return tuple(item for item in self.items if item.key in selected) if selected else ()

    def contours_near(self, place: Position, distance: float) -> list[ContourItem]:
        """Find the shown contours within `distance` [px] of a place (row, col), nearest first."""
        if self._around is None:
            self._around = build_path_tree([item.contour for item in self.items])
        return list(filter(self.is_shown, map(self.items.__getitem__, self._around.paths_near(place, distance))))

    def is_shown(self, item: ContourItem) -> bool:
        """Return whether a contour is shown."""
        return self.shows_rejected or not item.reviewed.rejected

    def contours_inside(self, outline: Sequence[Position]) -> frozenset[int]:
        """Find the keys of the shown contours at least half inside a closed outline of places (row, col)."""
        inside = polyline.points_inside(outline, self._sampled_places).reshape(-1, _SAMPLES_PER_CONTOUR).mean(axis=1)
        lie = zip(self.items, inside.tolist(), strict=True)
        return frozenset(item.key for item, part in lie if part >= 0.5 and self.is_shown(item))

    def not_on_boundary(self, boundaries: Sequence[Line]) -> tuple[ContourItem, ...]:
        """Find the contours that do not run along any of some closed lines of places (row, col) [px]."""
        if not boundaries or not self.items:
            return self.items
        self._find_along([line for line in boundaries if id(line) not in self._along])
        along = np.zeros(len(self._sampled_places), bool)
        along[np.concatenate([self._along[id(line)][1] for line in boundaries])] = True
        for line in [*self._along][: len(self._along) - _MAX_CACHED_LINES]:
            del self._along[line]
        share = along.reshape(-1, _SAMPLES_PER_CONTOUR).mean(axis=1).tolist()
        return tuple(item for item, part in zip(self.items, share, strict=True) if part < _MAX_SHARE_ON_BOUNDARY)

    def _find_along(self, lines: Sequence[Line]) -> None:
        """Find the sampled points of contours along closed lines."""
        if not lines:
            return
        paths = [np.array((*line, line[0])) for line in lines]
        pieces = [
            path[first : first + _CORNERS_PER_PIECE + 1]
            for path in paths
            for first in range(0, len(path) - 1, _CORNERS_PER_PIECE)
        ]
        of = np.repeat(np.arange(len(paths)), [-(-(len(path) - 1) // _CORNERS_PER_PIECE) for path in paths])
        place, piece, _ = PathTree(pieces).pairs_within(self._sampled_places, _ON_BOUNDARY_DISTANCE)
        order = np.argsort(of[piece], kind="stable")
        found = np.split(place[order], np.searchsorted(of[piece][order], np.arange(1, len(paths))))
        self._along.update((id(line), (line, places)) for line, places in zip(lines, found, strict=True))

    def edit_targets(self, items: Iterable[ContourItem]) -> list[MarkTarget]:
        """Return the targets by which edits of the document refer to contours."""
        given, known = [*items], () if self.result is None else self.result.contours
        fresh = [item.reviewed.index for item in given if item.reviewed.mark is None]
        made = iter(find_anchors(known, fresh))
        return [
            MarkTarget(mark, mark.anchor if mark else next(made), item.contour)
            for item, mark in ((item, item.reviewed.mark) for item in given)
        ]

    # Selecting

    def select(self, contours: Iterable[int] = (), objects: Iterable[int] = ()) -> None:
        """Select only the contours of these keys, and the objects of these numbers, or proposals of keys below 0."""
        scene, keys, numbers = self._session.scene, frozenset(contours), frozenset(objects)
        if (keys, numbers) != (scene.selected_contours, scene.objects.selected):
            shown = replace(scene.objects, selected=numbers)
            with self._session.store.defer_status():
                self._session.store.set_scene(replace(scene, selected_contours=keys, objects=shown))
                self.selection_changed.emit()

    @property
    def _sampled_places(self) -> Array:
        """Points along each contour, one contour after the other, shape (N, 2) [px]."""
        if self._places is None:
            paths = [item.contour.path for item in self.items]
            self._places = (
                polyline.midpoints_of_paths(paths, _SAMPLES_PER_CONTOUR).reshape(-1, 2) if paths else np.empty((0, 2))
            )
        return self._places

    def set_hovered(self, key: int | None) -> None:
        """Set the contour under the pointer, None for none."""
        scene = self._session.scene
        if key != scene.hovered_contour:
            self._session.store.set_scene(replace(scene, hovered_contour=key))

    def _on_scene_changed(self) -> None:
        scene = self._session.scene
        if scene.contours is self._contours:
            return
        before, self._contours = self._contours.items, scene.contours
        lines = (tuple(item.contour.points for item in items) for items in (before, scene.contours.items))
        if not is_same_input(*lines):  # not only other marks
            self._around = self._places = None
            self._along = {}
        keys = {item.key for item in scene.contours.items}
        self.changed.emit()
        scene = self._session.scene
        self.select(scene.selected_contours & keys, scene.objects.selected)
        if scene.hovered_contour not in keys:
            self.set_hovered(None)
