"""Curation in the window: the contours there are, what has been said about them, and which are selected."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from app.model.document import marking
from app.model.document.document import Document
from app.model.document.marking import Target
from app.model.text.language import tr
from app.session.exchange.contour_tracking import TrackedContours
from app.session.features.truth_comparison import GroundTruth
from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import Measures
from cpm_core.contours.result import Result
from cpm_core.contours.review import Mark, Neighborhood, ReviewedContour, Verdict, anchor, reviewed
from cpm_core.numerics.types import Position

if TYPE_CHECKING:
    from app.session.session import Session

_Edit = Callable[[Document, list[Target]], Document]


@dataclass(frozen=True, eq=False, slots=True)
class Item:
    """A contour as table and canvas show it.

    Attributes
    ----------
    key : int
        Its own number through all reconstructions.
    reviewed : ReviewedContour
        The contour and what has been said about it.
    measures : Measures
        What is known about it.
    """

    key: int
    reviewed: ReviewedContour
    measures: Measures

    @property
    def contour(self) -> Contour:
        """The contour, with name and colour."""
        return self.reviewed.contour

    @property
    def title(self) -> str:
        """Its name, or its number."""
        return self.contour.name or tr("contour {number}").format(number=self.measures.number)


class ContourReview(QObject):
    """Holds together contours, marks and selection; all that is said about contours goes through it.

    Parameters
    ----------
    session : Session
        Where contours come from and marks are kept.

    Attributes
    ----------
    items : tuple of Item
        The contours, longest first.
    selected : frozenset of int
        Keys of those selected.
    hovered : int or None
        Key of the one that the pointer is over.
    rejected_seen : bool
        Whether those rejected are shown, and can be picked.
    truth : GroundTruth
        What they are compared with.
    """

    changed = Signal()
    """There are other contours, or something has been said about them."""
    selection_changed = Signal()
    """Others are selected."""
    hover_changed = Signal()
    """The pointer is over another one."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.items: tuple[Item, ...] = ()
        self.selected: frozenset[int] = frozenset()
        self.hovered: int | None = None
        self.rejected_seen = True
        self._session = session
        self._tracked: TrackedContours | None = None
        self._marks: tuple[Mark, ...] = ()
        self._by_key: dict[int, Item] = {}
        self._around: Neighborhood | None = None
        self.truth = GroundTruth(session, self)
        session.surveyed.connect(self._use_tracked)
        session.document_changed.connect(self._use_document)
        session.image_changed.connect(lambda *_: self.select(()))

    # Looking

    def __getitem__(self, key: int) -> Item:
        return self._by_key[key]

    def __contains__(self, key: object) -> bool:
        return key in self._by_key

    @property
    def result(self) -> Result | None:
        """The reconstruction, with all that has been found."""
        return self._tracked.result if self._tracked else None

    @property
    def chosen(self) -> tuple[Item, ...]:
        """What is selected."""
        return tuple(item for item in self.items if item.key in self.selected)

    def under(self, place: Position, reach: float) -> int | None:
        """Key of the contour nearest to a place (row, col) within `reach` [px], as far as it is seen."""
        if self._around is None:
            self._around = Neighborhood([item.contour for item in self.items])
        near = (self.items[index] for index, _ in self._around.passing(place, reach))
        return next((item.key for item in near if self.rejected_seen or not item.reviewed.rejected), None)

    # Selecting

    def select(self, keys: Iterable[int]) -> None:
        """Select these and no others."""
        selected = frozenset(keys)
        if selected != self.selected:
            self.selected = selected
            self.selection_changed.emit()

    def hover(self, key: int | None) -> None:
        """Tell that the pointer is over a contour, or over none."""
        if key != self.hovered:
            self.hovered = key
            self.hover_changed.emit()

    # Saying

    def judge(self, verdict: Verdict) -> None:
        """Keep or reject what is selected; to do it again takes it back."""
        chosen = self.chosen
        if not chosen:
            return
        if all(item.reviewed.verdict == verdict for item in chosen):
            verdict = ""
        words = {"kept": tr("keep {what}"), "rejected": tr("reject {what}"), "": tr("leave open {what}")}
        self._edit(words[verdict], chosen, lambda document, targets: marking.judge(document, targets, verdict))

    def rename(self, key: int, name: str) -> None:
        """Call a contour by a name."""
        if key in self and name.strip() != self[key].contour.name:
            rename: _Edit = lambda document, targets: marking.rename(document, targets, name)  # noqa: E731
            self._edit(tr("name {what}"), [self[key]], rename)

    def paint(self, colour: str) -> None:
        """Give what is selected a colour, or none of its own."""
        self._edit(tr("colour {what}"), self.chosen, lambda document, targets: marking.paint(document, targets, colour))

    # Inside

    def _edit(self, words: str, items: Iterable[Item], edit: _Edit) -> None:
        items = list(items)
        if not items:
            return
        what = items[0].title if len(items) == 1 else tr("{count} contours").format(count=len(items))
        targets = [self._target(item) for item in items]
        self._session.edit(words.format(what=what), lambda document: edit(document, targets))

    def _target(self, item: Item) -> Target:
        assert self._tracked is not None
        mark = item.reviewed.mark
        contours = self._tracked.result.contours
        return Target(mark, mark.anchor if mark else anchor(contours, item.reviewed.index))

    def _use_tracked(self, tracked: TrackedContours | None) -> None:
        self._tracked = tracked
        self._attach()

    def _use_document(self, document: Document) -> None:
        if document.marks != self._marks:
            self._marks = document.marks
            self._attach()

    def _attach(self) -> None:
        tracked = self._tracked
        if tracked is None:
            self.items = ()
        else:
            each = zip(tracked.keys, reviewed(tracked.result.contours, self._marks), tracked.measures, strict=True)
            self.items = tuple(Item(*one) for one in each)
        self._around = None
        self._by_key = {item.key: item for item in self.items}
        self.changed.emit()
        self.select(self.selected & self._by_key.keys())
        if self.hovered is not None and self.hovered not in self:
            self.hover(None)
