"""Selecting objects: by clicks, the pointer and the run, anew by their own clicks, and all that are like one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from app.model.document import objects
from app.model.document.document import Document
from app.model.document.objects import AnySelection
from app.model.text.language import tr
from app.session.features.background import LatestOnlyWorker
from app.session.features.selector import MOST_OFFERED, Partitions, Selector
from app.session.scene import Proposal
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core import Partition, Result, Selection, similar
from cpm_core.numerics import Array, Place
from cpm_core.objects.segmented import Click, SegmentedObject, selection_of
from cpm_core.shapes import Everywhere, ImageStart

_COVERED = 0.5
"""Share of an object that others cover from which it counts as one of them."""


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked for: the object of some clicks, what one more click would make of it, or the objects of starts.

    Of the starts only their number is compared: those of another run come with another selector.
    """

    selector: Selector
    clicks: tuple[Click, ...]
    pointed: Click | None
    count: int
    starts: tuple[Array, ...] = field(compare=False)
    rejected: tuple[SegmentedObject, ...]

    def answer(self) -> tuple[tuple[Proposal, ...], AnySelection | None]:
        """The objects that are offered, and what a click under the pointer would take.

        It takes some milliseconds for each click that is new.
        """
        selector, clicks = self.selector, self.clicks
        selection = selector.selection(clicks)
        proposals = selector.proposals(self.starts, self.rejected) if selection is None else ()
        if selection is not None:
            proposals = (Proposal(selection, clicks, selector.edited),)
        return proposals, None if self.pointed is None else selector.selection((*clicks, self.pointed))


class ObjectSelection(QObject):
    """Keeps the proposal and the preview of the scene up to date, and selects objects anew."""

    changed = Signal()
    """The proposals have changed, or whether one can be made."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._in_use = False
        self._pointed: Click | None = None
        self._dismissed: Result | None = None
        self._selector: Selector | None = None
        self._asked: Question | None = None
        self._remark, self._was_ready = "", False
        self._latest = LatestOnlyWorker(session, "cpm-objects", tr("selecting objects"))
        self.partitions = Partitions(session, lambda: self._wanted)
        self.partitions.changed.connect(self._follow)
        self.partitions.changed.connect(self.changed)
        session.document_changed.connect(lambda _: self.partitions.look())
        session.document_changed.connect(lambda _: self._follow())
        # offer nothing of a run that has been reset or continues
        session.scene_changed.connect(
            lambda: None if not self.proposals or self.selecting or self._starts else self._follow()
        )
        session.image_changed.connect(self._forget)
        self.offers_for: Callable[[Document], bool] = lambda document: True  # while the tool is not in use

    # State

    @property
    def selecting(self) -> bool:
        """Whether an object is being selected: there are clicks."""
        return bool(self._session.document.objects.clicks)

    @property
    def proposals(self) -> tuple[Proposal, ...]:
        """The objects that are offered."""
        return self._session.scene.objects.proposals

    @property
    def ready(self) -> bool:
        """Whether objects can be selected at once."""
        return self.partitions.partition is not None

    @property
    def idle(self) -> bool:
        """Whether the proposals are up to date."""
        return self._latest.idle and not self.partitions.preparing

    def set_in_use(self, in_use: bool) -> None:
        """Whether the tool is in use, so that the partition is kept up to date."""
        self._in_use = in_use
        self.partitions.look(again=in_use)
        self._follow()

    # Clicks

    def point(self, at: Place | None, inside: bool = True) -> None:
        """Show what a click at a place would take; None for no place."""
        self._pointed = Click((at,), inside) if at is not None else None
        if at is None:
            self._show(preview=None)
        self._follow()

    def click(self, places: tuple[Place, ...], inside: bool = True) -> None:
        """Say that places are inside of the object, or outside of it."""
        said = Click(places, inside)
        first = None if self.selecting else corrected(self.proposals, said)
        words = tr("select") if inside else tr("select without")

        def edit(document: Document) -> Document:
            for one in (*(first.clicks if first else ()), said):
                document = objects.click(document, one)
            return document

        self._session.edit(words, edit)

    def take_back(self) -> None:
        """Take back the last click."""
        if self.selecting:
            self._session.edit(tr("take back a click"), objects.take_back)

    def drop(self) -> None:
        """Give up the proposals."""
        if self.selecting:
            self._session.edit(tr("drop the selection"), objects.drop)
        else:
            self.dismiss()

    def dismiss(self) -> None:
        """Offer the objects of the starts no longer, until a run ends again."""
        if self.proposals and not self.selecting:
            self._dismissed = self._session.scene.contours.result
            self._follow()

    # Objects of the document

    def fit(self, numbers: frozenset[int]) -> None:
        """Select the objects of these numbers anew by their own clicks; frozen ones stay as they are."""
        partition, items = self.partitions.partition, self._session.document.objects.items
        fitted = [item for item in items if item.number in numbers and item.clicks and not item.frozen]
        if partition is None or not fitted:
            self._session.say(tr("There is nothing to fit: choose objects that are not frozen."))
            return

        def work(task: Task) -> list[tuple[AnySelection, tuple[Click, ...], int]]:
            found = []
            selector = Selector(partition, items, 0)
            for done, item in enumerate(fitted):
                task.advance(done / len(fitted))
                selection = selector.selection(item.clicks)
                if selection is not None:
                    found.append((selection, item.clicks, item.number))
            return found

        def use(found: list[tuple[AnySelection, tuple[Click, ...], int]]) -> None:
            if partition.image is self._session.image:
                self._session.edit(tr("fit objects"), lambda document: objects.replace_boundaries(document, found))

        self._session.tasks.start(tr("Fitting objects to the contours…"), work, tr("fitting objects"), then=use)

    def find_like(self, number: int) -> None:
        """Add all objects that are like one and not among the objects yet."""
        partition, known = self.partitions.partition, self._session.document.objects
        if not isinstance(partition, Partition):  # a volume has no objects that are alike
            self.partitions.look(again=True)
            self._session.say(tr("The image is not prepared yet: try again in a moment."))
            return
        chosen = known[number]

        def work(task: Task) -> list[Selection]:
            taken = np.any([item.mask(partition.shape) for item in known.items], axis=0)
            alike = similar(partition, selection_of(chosen, partition.shape))[1:]
            return [each for each in alike if (each.mask & taken).sum() < _COVERED * each.mask.sum()]

        def use(found: list[Selection]) -> None:
            if partition.image is not self._session.image:
                return
            if not found:
                self._session.say(tr("No other object like this one was found."))
                return
            self._session.edit(tr("all like this"), lambda document: objects.add(document, found, chosen.category))
            self._session.say(tr("{count} objects like this one were found.").format(count=len(found)))

        self._session.tasks.start(tr("Finding objects like this one…"), work, tr("finding objects"), then=use)

    def close(self) -> None:
        """End the threads."""
        self.partitions.close()
        self._latest.close()

    # Internal

    @property
    def _starts(self) -> tuple[Array, ...]:
        """Seeds of the starts drawn on the image, once the run from them has ended with a result, unless dismissed.

        On a large image there are none, nor where `offers_for` is False for the document, unless the tool for objects
        is in use.
        """
        document, result = self._session.document, self._session.scene.contours.result
        if result is None or result is self._dismissed or not result.stop_reason or document.mode != "shape":
            return ()
        if not self._in_use and (math.prod(result.shape) > MOST_OFFERED or not self.offers_for(document)):
            return ()
        return tuple(start.seeds() for start in document.starts if not isinstance(start, Everywhere | ImageStart))

    @property
    def _wanted(self) -> bool:
        """Whether a partition is needed."""
        return self._in_use or self.selecting or bool(self._starts)

    def _follow(self) -> None:
        """Ask for what has changed."""
        partition, document = self.partitions.partition, self._session.document
        if partition is None:
            self._offer(())
            return
        items, edited = document.objects.items, document.objects.edited
        known = self._selector
        if known is None or (known.partition, known.items, known.edited) != (partition, items, edited):
            known = self._selector = Selector(partition, items, edited)
        starts = self._starts if not document.objects.clicks else ()
        question = Question(
            known, document.objects.clicks, self._pointed, len(starts), starts, document.objects.rejected
        )
        last = self._asked
        if last is not None and not question.clicks and (last.clicks or last.selector.items is not items):
            self._offer(())  # what was offered has been taken or dropped
        if question != last:
            self._asked = question
            self._latest.ask(question.answer, partial(self._use, question))

    def _use(self, question: Question, answer: tuple[tuple[Proposal, ...], AnySelection | None]) -> None:
        proposals, preview = answer
        if question.selector is not self._selector or question.clicks != self._session.document.objects.clicks:
            return  # the next answer is on its way
        proposals = proposals if question.clicks or self._starts else ()
        self._show(preview=preview if self._pointed is not None else None)
        before = self.proposals
        self._offer(proposals)
        remark = proposals[0].selection.remark if question.clicks and proposals else ""
        remark = remark or without_effect(before, proposals)
        if remark and remark != self._remark:  # once
            self._session.say(remark)
        self._remark = remark

    def _offer(self, proposals: tuple[Proposal, ...]) -> None:
        """Show other proposals, or nothing while there is no partition."""
        before, ready = self.proposals, self.ready
        if [each.selection for each in before] == [each.selection for each in proposals] and ready == self._was_ready:
            return
        self._was_ready = ready
        self._show(proposals=proposals)
        self.changed.emit()

    def _show(self, **parts: Any) -> None:
        scene = self._session.scene
        if any(getattr(scene.objects, name) != part for name, part in parts.items()):
            self._session.show(replace(scene, objects=replace(scene.objects, **parts)))

    def _forget(self) -> None:
        self._latest.forget()
        self._selector = self._asked = self._pointed = self._dismissed = None


def without_effect(before: tuple[Proposal, ...], after: tuple[Proposal, ...]) -> str:
    """A sentence on the newest click if it has changed nothing of the object; else empty."""
    if len(before) != 1 or len(after) != 1 or len(after[0].clicks) != len(before[0].clicks) + 1:
        return ""
    one, other = before[0].selection, after[0].selection
    if not before[0].clicks or type(one) is not type(other) or not one.same(other):  # type: ignore[arg-type]
        return ""
    if after[0].clicks[-1].inside:
        return tr("This click changes nothing: the place belongs to the object already.")
    return tr("This click changes nothing: the place does not belong to the object.")


def corrected(offered: tuple[Proposal, ...], said: Click) -> Proposal | None:
    """The offered object of a start that a first click corrects: the one it lies in, or the only one."""
    for each in offered:
        if each.selection.holds(np.array(said.places[:1]))[0]:
            return each
    return offered[0] if len(offered) == 1 else None
