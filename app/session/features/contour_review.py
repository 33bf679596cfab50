"""Contour review: marks and selection of contours."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject, Signal

from app.model.document import contours
from app.model.document.contours import Target
from app.model.document.document import Document
from app.model.text.language import tr
from app.session.scene import NO_CONTOURS, Item, ReviewedContours
from app.session.session import Session
from cpm_core import Result
from cpm_core.contours import Verdict, anchor, neighborhood
from cpm_core.numerics import Array, PathTree, Position, polyline

_PLACES = 24
"""Number of places along a contour that are compared with an outline."""

_Edit = Callable[[Document, list[Target]], Document]


class ContourReview(QObject):
    """Marks and selects the contours of the scene; where `rejected_seen`, rejected ones are shown and can be picked."""

    changed = Signal()
    """The contours or their marks have changed."""
    selection_changed = Signal()
    """The selection has changed."""
    hover_changed = Signal()
    """The pointer is over another contour."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.rejected_seen = True
        self._session = session
        self._contours: ReviewedContours = NO_CONTOURS
        self._by_key: dict[int, Item] = {}
        self._around: PathTree | None = None
        self._places: dict[int, Array] | None = None
        session.scene_changed.connect(self._follow)
        session.image_changed.connect(lambda: self.select(()))

    # State

    def __getitem__(self, key: int) -> Item:
        return self._by_key[key]

    def __contains__(self, key: object) -> bool:
        return key in self._by_key

    @property
    def items(self) -> tuple[Item, ...]:
        """The contours, longest first."""
        return self._session.scene.contours.items

    @property
    def result(self) -> Result | None:
        """The reconstruction, with rejected contours too."""
        return self._session.scene.contours.result

    @property
    def selected(self) -> frozenset[int]:
        """Keys of the selected contours."""
        return self._session.scene.selected_contours

    @property
    def hovered(self) -> int | None:
        """Key of the contour under the pointer."""
        return self._session.scene.hovered_contour

    @property
    def chosen(self) -> tuple[Item, ...]:
        """The selected contours."""
        selected = self.selected
        return tuple(item for item in self.items if item.key in selected) if selected else ()

    def under(self, place: Position, reach: float) -> int | None:
        """Key of the shown contour nearest to a place (row, col) within `reach` [px]."""
        if self._around is None:
            self._around = neighborhood([item.contour for item in self.items])
        near = (self.items[index] for index in self._around.passing(place, reach))
        return next((item.key for item in near if self.rejected_seen or not item.reviewed.rejected), None)

    def within(self, outline: Sequence[Position]) -> frozenset[int]:
        """Keys of the shown contours that lie inside a closed outline of places (row, col) for half of their length."""
        shown = [item for item in self.items if self.rejected_seen or not item.reviewed.rejected]
        if not shown:
            return frozenset()
        if self._places is None:
            self._places = {item.key: polyline.middles(item.contour.path, _PLACES) for item in self.items}
        places = np.concatenate([self._places[item.key] for item in shown])
        share = polyline.inside(outline, places).reshape(len(shown), _PLACES).mean(axis=1)
        return frozenset(item.key for item, part in zip(shown, share.tolist(), strict=True) if part >= 0.5)

    # Selecting

    def select(self, keys: Iterable[int]) -> None:
        """Select only these contours."""
        selected = frozenset(keys)
        if selected != self.selected:
            self._session.show(replace(self._session.scene, selected_contours=selected))
            self.selection_changed.emit()

    def hover(self, key: int | None) -> None:
        """Set the contour under the pointer, or None."""
        if key != self.hovered:
            self._session.show(replace(self._session.scene, hovered_contour=key))
            self.hover_changed.emit()

    # Marking

    def judge(self, verdict: Verdict) -> None:
        """Keep or reject the selected contours; the same verdict again removes it."""
        chosen = self.chosen
        if not chosen:
            return
        if all(item.reviewed.verdict == verdict for item in chosen):
            verdict = ""
        words = {"kept": tr("keep {what}"), "rejected": tr("reject {what}"), "": tr("leave open {what}")}
        self._edit(words[verdict], chosen, lambda document, targets: contours.judge(document, targets, verdict))

    def rename(self, key: int, name: str) -> None:
        """Name a contour."""
        if key in self and name.strip() != self[key].contour.name:
            rename: _Edit = lambda document, targets: contours.rename(document, targets, name)  # noqa: E731
            self._edit(tr("name {what}"), [self[key]], rename)

    def paint(self, color: str) -> None:
        """Color the selected contours; an empty color removes their own."""
        self._edit(tr("color {what}"), self.chosen, lambda document, targets: contours.paint(document, targets, color))

    def _edit(self, words: str, items: Iterable[Item], edit: _Edit) -> None:
        items = list(items)
        if not items:
            return
        what = items[0].title if len(items) == 1 else tr("{count} contours").format(count=len(items))
        targets = [self._target(item) for item in items]
        self._session.edit(words.format(what=what), lambda document: edit(document, targets))

    def _target(self, item: Item) -> Target:
        assert self.result is not None
        mark = item.reviewed.mark
        place = mark.anchor if mark else anchor(self.result.contours, item.reviewed.index)
        return Target(mark, place, item.contour)

    def _follow(self) -> None:
        contours = self._session.scene.contours
        if contours is self._contours:
            return
        self._contours = contours
        self._around = self._places = None
        self._by_key = {item.key: item for item in contours.items}
        self.changed.emit()
        self.select(self.selected & self._by_key.keys())
        if self.hovered is not None and self.hovered not in self:
            self.hover(None)
