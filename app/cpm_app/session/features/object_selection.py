"""Proposals from clicks, the pointer, the run and similar objects; refitting of objects by their clicks."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

import numpy as np
from PySide6.QtCore import QObject, Qt, Signal

from cpm_app.model.document import objects
from cpm_app.model.text.language import localize_number, tr, translate_core_text
from cpm_app.session.exchange.messages import CommandFailed, Report
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.features.followed_objects import FollowedObjects
from cpm_app.session.features.object_commands import ObjectCommands
from cpm_app.session.features.object_list import ObjectList
from cpm_app.session.features.selector import (
    MAX_OFFERED_PIXELS,
    AnyPartition,
    EverywhereRun,
    PartitionSource,
    PartitionUpdater,
    Selector,
    find_limits,
    find_proposals,
    is_covered,
    is_offered,
)
from cpm_app.session.features.stack_pages import StackPages
from cpm_app.session.scene import Preview, Proposal
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EDITING_CATEGORY, RUNNING_CATEGORY
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import Partition, Result, Selection
from cpm_core.numerics import Place
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Callback, frozen
from cpm_core.objects.confidence import whole_percent
from cpm_core.objects.segmented import Click, selection_from_object, unite_regions
from cpm_core.objects.segmented.segmented_object import Clicks
from cpm_core.objects.similar_objects import find_similar_objects

Made = TypeVar("Made")


def format_confidence(selection: Selection) -> str:
    """Format the confidence of an object as text; empty where it is unknown."""
    return "" if math.isnan(selection.confidence) else localize_number(f"{whole_percent(selection.confidence):.0f} %")


@frozen
class WaitingAction:
    """An action that waits for the answer to earlier ones, or for what is offered; perhaps it makes a click."""

    run: Callback
    click: Click | None
    needs_offer: Callable[[], bool]


class ObjectSelection(QObject):
    """Keeps the proposals and the preview of the scene up to date, and changes the clicks of the document.

    What the user does before an answer is known waits for it, so that it means what it would mean then; see
    `do_in_order`.
    """

    changed = Signal()
    """The proposals have changed, or whether one can be made."""

    def __init__(
        self,
        session: Session,
        object_list: ObjectList,
        commands: ObjectCommands,
        pages: StackPages,
        followed_objects: FollowedObjects,
    ) -> None:
        super().__init__(session)
        self._session, self._list, self._commands = session, object_list, commands
        self._pages, self._followed_objects = pages, followed_objects
        self._in_use, self._run_ended, self._was_running = False, False, False
        self._pointed: tuple[Click, bool] | None = None
        """The click to preview, and whether it is for another object than what is proposed."""
        self._steps = 0
        self._waiting: deque[WaitingAction] = deque()
        self._answered: tuple[Selector, Clicks] | None = None
        """The selector and the clicks of the answer that is shown."""
        self._is_catching_up = False
        self._searched: AnyPartition | None = None
        self._found, self._covered = tuple[Proposal, ...](), tuple[Proposal, ...]()
        """What was found last, and what objects covered of it then, which is proposed once these are gone."""
        self._is_searched = False
        """Whether the search in the partition has ended."""
        self._comparing = ENDED_TASK
        self._run, self._alike = 0, tuple[Proposal, ...]()
        """Objects that are similar to one, beside what a run proposes."""
        self._selectors: dict[int, Selector] = {}
        self._selectors_source: PartitionSource | None = None
        self._seen: dict[int, Mapping[Clicks, Selection | None]] = {}
        """What clicks selected before contours or objects changed, by the number of the object."""
        self.selector: Selector | None = None
        """The selector of the object of the clicks."""
        self._asked: tuple[object, ...] = ()
        """All that the newest answer depends on."""
        self._remark, self._was_ready = "", False
        self._latest = LatestOnlyWorker(session, "cpm-objects", tr("selecting objects"))
        self._finding = ENDED_TASK
        self.partition_updater = PartitionUpdater(
            session,
            lambda: self._in_use or self.selecting or bool(self._offers_run or followed_objects.search),
        )
        self.partition_updater.changed.connect(self._request_answer)
        self.partition_updater.changed.connect(self.changed)
        session.document_changed.connect(lambda _: self.partition_updater.update_partition())
        session.document_changed.connect(lambda _: self._request_answer())
        later = Qt.ConnectionType.QueuedConnection  # a search that begins is not known yet
        session.tasks.changed.connect(self._catch_up, later)  # a search may have been canceled
        session.store.status_changed.connect(self._catch_up, later)  # a result that was due may have failed
        session.store.scene_changed.connect(self._on_scene_changed)
        session.store.status_changed.connect(self._on_status_changed)
        session.image_changed.connect(self._on_image_changed)
        pages.changed.connect(self._catch_up)
        followed_objects.search_changed.connect(self.search_again)

    # State

    @property
    def selecting(self) -> bool:
        """Whether an object is being selected: there are clicks."""
        return bool(self._session.document.objects.clicks)

    @property
    def proposals(self) -> tuple[Proposal, ...]:
        """The offered objects, the one of the clicks first."""
        return self._session.scene.objects.proposals

    @property
    def ready(self) -> bool:
        """Whether objects can be selected at once."""
        return self.partition_updater.partition is not None

    @property
    def idle(self) -> bool:
        """Whether the proposals are up to date."""
        resting = self._latest.idle and self._finding.is_over and not self.partition_updater.preparing
        return resting and not self._waiting

    @property
    def answered(self) -> bool:
        """Whether the object of the clicks is known, or will not be; true without clicks."""
        if not self.selecting:
            return True
        if self.selector is None:
            return self.partition_updater.has_failed
        return self._answered == (self.selector, self._session.document.objects.clicks)

    @property
    def has_waiting_actions(self) -> bool:
        """Whether an action waits for an answer, so that what it leads to can be named, merged or removed after it."""
        return bool(self._waiting)

    @property
    def has_waiting_keys(self) -> bool:
        """Whether an action waits that, unlike a click, has no mark on the image."""
        return any(each.click is None for each in self._waiting)

    @property
    def offer_is_known(self) -> bool:
        """Whether all that the run offers is shown; true if it offers nothing."""
        return not self._offers_run or self._offer_is_shown

    @property
    def awaits_offer(self) -> bool:
        """Whether objects of the run or of the previous page are being found; false if that was canceled."""
        if self._session.store.result_is_due:
            return True
        given_up = self._finding.is_cancelled or self.partition_updater.has_failed
        offers = self._offers_run or self._followed_objects.search is not None
        return offers and not (self._offer_is_shown or given_up)

    @property
    def can_accept(self) -> bool:
        """Whether Enter accepts something, at once or as soon as it is known."""
        expected = self.selecting or self.has_waiting_actions or self._pages.is_turning
        return self._commands.can_accept or expected or (self._is_finding and self._accepts_offer())

    def object_number_at(self, at: Place) -> int:
        """Return the key of the smallest proposal at a place, or else the number of the object; 0 for none."""
        place = np.array([at], float)
        around = [each for each in self.proposals if each.key and each.selection.contains(place)[0]]
        return min(around, key=lambda each: each.selection.size).key if around else self._list.object_number_at(at)

    def set_in_use(self, in_use: bool) -> None:
        """Set whether the tool is in use, so that the partition is kept up to date."""
        self._in_use = in_use
        self.partition_updater.update_partition(again=in_use)
        self._request_answer()

    def search_again(self) -> None:
        """Search again for objects to offer."""
        self._searched = None
        self.partition_updater.update_partition()
        self._request_answer()

    # Clicks

    def preview_click(self, at: Place | None, inside: bool = True, another: bool = False) -> None:
        """Preview the effect of a click at a place, perhaps for another object there; None for no place."""
        self._pointed = (Click((at,), inside), another) if at is not None else None
        if at is None:
            self._update_shown_objects(preview=None)
        self._request_answer()

    def add_click(self, click: Click, another: bool = False) -> None:
        """Add a click: positive points of the object, or of `another` than what is proposed, or negative ones."""
        self._remark = ""
        clicks, number = self._clicks_to_extend(click, another)
        self._set_clicks(tr("select") if click.inside else tr("remove from selection"), (*clicks, click), number)

    def correct_object(self, number: int) -> None:
        """Continue to select an object, given by its number, or a proposal, given by its key."""
        self._set_clicks(tr("correct object"), *self._clicks_before(number))
        self._list.select_objects((number,) if number > 0 else ())

    def step_candidate(self, by: int) -> None:
        """Step to a larger candidate for the object of the clicks or the selected one, a smaller one if `by` < 0."""
        if self.ready:
            self._steps += by
            self._request_answer()
        else:
            self._session.messages.show(tr("The image is still being prepared: try again in a moment."))

    def do_in_order(
        self,
        action: Callback,
        click: Click | None = None,
        *,
        needs_page: bool = True,
        needs_answer: bool = True,
        needs_offer: Callable[[], bool] = lambda: False,
    ) -> None:
        """Do what the user wants after all that was wanted before: now, or as soon as the answers to it are known.

        Parameters
        ----------
        action : callable
            Does it; it must not call this method.
        click : Click, optional
            The click that it makes, which is marked until its answer is shown.
        needs_page : bool
            Whether it is for the page that is being opened, if there is one.
        needs_answer : bool
            Whether it depends on what the clicks of the document select.
        needs_offer : callable
            Tells, when its turn has come, whether it is for what is being found, to be offered.
        """
        unknown = (needs_page and self._pages.is_turning) or (needs_answer and not self.answered)
        if self._waiting or self._steps or unknown or (self._is_finding and needs_offer()):
            self._waiting.append(WaitingAction(action, click, needs_offer))
            # what is said of the last edit would hide that this one waits
            self._session.messages.clear(EDITING_CATEGORY, RUNNING_CATEGORY)
            self._show_awaited_clicks()
            self.changed.emit()
        else:
            action()

    def accept(self) -> None:
        """Accept what is proposed, selected or being found, after all that was wanted before."""
        self.do_in_order(self._commands.accept_pending, needs_offer=self._accepts_offer)

    def undo_click(self) -> None:
        """Undo the last click."""
        if self.selecting:
            known = self._session.document.objects
            self._set_clicks(tr("undo a click"), known.clicks[:-1], known.edited)

    def discard_clicks(self) -> None:
        """Discard the object being selected."""
        if self.selecting:
            self._set_clicks(tr("discard the selection"), ())

    # Objects of the document

    def refit_objects(self, numbers: frozenset[int]) -> None:
        """Select the objects of these numbers again by their own clicks; frozen ones stay as they are."""
        partition, known = self.partition_updater.partition, self._session.document.objects
        items, overlaps = known.items, known.may_overlap
        fitted = [item for item in items if item.number in numbers and item.clicks and not item.frozen]
        if partition is None or not fitted:
            self._session.messages.show(tr("There is nothing to fit: select objects that are not frozen."))
            return

        def select_again(task: BackgroundTask) -> list[tuple[Selection, Clicks, int]]:
            found = []
            for done, item in enumerate(fitted):
                task.advance(done / len(fitted))
                others = [each for each in items if each is not item]
                selection = Selector(partition, others, overlaps=overlaps).selection_for(item.clicks)
                if selection is not None:
                    found.append((selection, item.clicks, item.number))
            return found

        def replace_boundaries(found: list[tuple[Selection, Clicks, int]]) -> None:
            if partition.image is self._session.image:
                self._session.edit(tr("fit objects"), lambda document: objects.replace_boundaries(document, found))

        self._session.tasks.start_task(
            tr("Fitting objects to the contours…"), select_again, tr("fitting objects"), on_result=replace_boundaries
        )

    def find_similar(self, number: int) -> None:
        """Propose all objects that are similar to one, and neither among the objects nor proposed or rejected yet."""
        partition, known = self.partition_updater.partition, self._session.document.objects
        if partition is None:
            self.partition_updater.update_partition(again=True)
            self._session.messages.show(tr("The image is still being prepared: try again in a moment."))
            return
        example, offered = known[number], self.proposals

        def find_new(task: BackgroundTask) -> list[Selection]:
            apart = [item for item in known.items if item.frozen or not known.may_overlap]
            taken = unite_regions(find_limits(example, apart, partition.shape), partition.shape)
            found = find_similar_objects(partition, selection_from_object(example, partition.shape), taken)
            return [
                each
                for each in found
                if each.has_boundary
                and not is_covered(each.region, each.shape, known.items, known.dismissed)
                and not is_offered(each, offered)
            ]

        def offer(new: Sequence[Selection]) -> None:
            if partition.image is not self._session.image:
                return
            if not new:
                self._comparing = ENDED_TASK
                self._session.messages.show(tr("No other object like this one was found."))
                return
            made = (Proposal(each, (Click(as_line(each.inside)),), category=example.category) for each in new)
            self._offer(self._found, (*self._alike, *made), self._covered)
            if self._session.scene.objects.selected == {number}:  # which would keep Enter from what was found
                self._list.select_objects(())
            self._session.messages.show(tr("Objects like this one: {count}.", count=len(new)))
            self._request_answer()
            self._comparing = ENDED_TASK

        self._comparing = self._start_finding(tr("Finding objects like this one…"), find_new, offer)

    # Internal

    def _accepts_offer(self) -> bool:
        """Tell whether Enter is for what is being found: objects like one, or as nothing else can be accepted."""
        other = self._commands.can_accept or self._list.selected_keys
        return not self.selecting and (self._finds_alike or not other)

    @property
    def _finds_alike(self) -> bool:
        """Whether objects like one are being found or not shown yet; false if that was canceled."""
        going_on = self._comparing is not ENDED_TASK and not self._comparing.is_cancelled
        shown = self._answered is None or self._answered[0].offered == self._offered
        return going_on or bool(self._alike and not shown)

    @property
    def _is_finding(self) -> bool:
        """Whether anything is being found, to be offered."""
        return self.awaits_offer or self._finds_alike

    @property
    def _offer_is_shown(self) -> bool:
        """Whether what was found last, to be offered, is shown, and is all that can be found."""
        updater, answered = self.partition_updater, self._answered
        shown = answered is not None and answered[0].offered[: len(self._found)] == self._found
        return shown and self._is_searched and updater.is_current and not updater.preparing

    def _set_clicks(self, undo_text: str, clicks: Clicks, number: int = 0) -> None:
        self._session.edit(undo_text, lambda document: objects.set_selection_clicks(document, clicks, number))

    def _number_to_correct(self, click: Click) -> int:
        """Return the number or key of the object or proposal that a click corrects; 0 if it begins a new object.

        A negative click corrects the object under it, a positive one the only proposal. While an object is being
        selected, the click belongs to it. A followed object is complete: a click next to it begins a new one.
        """
        if self.selecting:
            return 0
        if not click.inside:
            return self.object_number_at(click.places[0])
        alone = len(self.proposals) == 1 and self.proposals[0].followed_object is None
        return self.proposals[0].key if alone else 0

    def _clicks_to_extend(self, click: Click, another: bool) -> tuple[Clicks, int]:
        """Return the clicks that one continues, and the number of their object; none that have found nothing.

        One for `another` object continues only those of the object being selected.
        """
        found_nothing = self.selecting and self.answered and not any(
            each.selection.has_boundary for each in self.proposals if not each.key
        )  # fmt: skip
        number = 0 if another and click.inside else self._number_to_correct(click)
        return ((), 0) if found_nothing else self._clicks_before(number)

    def _clicks_before(self, number: int) -> tuple[Clicks, int]:
        """Return the clicks being made, or else those of an object or proposal, and the number of an object."""
        document = self._session.document
        if self.selecting or not number:
            return document.objects.clicks, document.objects.edited
        if number > 0 and document.image is not None:
            return objects.initial_clicks(document.objects[number], document.image.shape), number
        return next((each.clicks for each in self.proposals if each.key == number), ()), 0

    @property
    def _offered(self) -> tuple[Proposal, ...]:
        """What was found last, the other objects like one, and what is covered."""
        return (*self._found, *self._alike, *self._covered)

    def _offer(self, found: Sequence[Proposal], alike: Sequence[Proposal], covered: Sequence[Proposal]) -> None:
        """Offer what was found, then the objects like one that are not among it, then what is covered, with keys."""
        apart = [each for each in alike if not is_offered(each.selection, (*found, *covered))]
        numbered = (
            each if each.key == ~at else replace(each, key=~at) for at, each in enumerate((*found, *apart, *covered))
        )
        parts = (tuple(itertools.islice(numbered, len(part))) for part in (found, apart, covered))
        self._found, self._alike, self._covered = parts

    @property
    def _offers_run(self) -> bool:
        """Whether the objects of the run are offered, because it has ended with a result.

        On a large image they are not unless the tool for objects is in use.
        """
        result = self._session.scene.result
        if result is None or not result.stop_reason:
            return False
        return self._in_use or math.prod(result.shape) <= MAX_OFFERED_PIXELS

    def _on_scene_changed(self) -> None:
        """Offer the objects of a run once it has ended, but none of one that has been reset or continues."""
        result = self._session.scene.result
        over = result is not None and bool(result.stop_reason)
        if over != self._run_ended:
            self._run_ended = over
            self._request_answer()

    def _on_status_changed(self) -> None:
        """Preview no click while particles move; of objects like one, offer those alone that a run begins with."""
        if self._session.store.generation != self._run:
            self._run, keys = self._session.store.generation, {each.key for each in self.proposals}
            self._alike = tuple(each for each in self._alike if each.key in keys)
        running = self._session.store.status.phase == "running"
        if running != self._was_running:
            self._was_running = running
            self._request_answer()

    def _find_offered(self, partition: AnyPartition) -> None:
        """Find the objects of the previous page, or what the run proposes, unless that has begun."""
        source, follow = self.partition_updater.source, self._followed_objects.search
        find: Callable[[BackgroundTask], tuple[Proposal, ...]]
        of_run, pages = self._offers_run and isinstance(source, Result) and bool(source.stop_reason), self._pages
        if follow is not None and isinstance(partition, Partition) and not (of_run and pages.proposed):
            find, name = partial(follow, partition), tr("Following objects…")
        elif of_run and isinstance(source, Result):
            continues = pages.following and not pages.is_drawn(self._session.document)
            find = partial(find_proposals, source, continues, pages.proposed)
            name = tr("Finding the objects of the run…")
        else:
            self._searched, self._found, self._covered, self._is_searched = None, (), (), True
            return
        if self._searched is not partition:
            self._searched, self._found, self._covered, self._is_searched = partition, (), (), False
            self._finding.cancel()
            found, known = partial(self._on_objects_found, partition), self._session.document.objects

            def find_and_compare(task: BackgroundTask) -> list[tuple[Proposal, bool]]:
                items, dismissed, shape = known.items, known.dismissed, partition.shape
                return [(each, is_covered(each.selection.region, shape, items, dismissed)) for each in find(task)]

            self._finding = self._start_finding(name, find_and_compare, found)

    def _start_finding(
        self,
        name: str,
        find: Callable[[BackgroundTask], Sequence[Made]],
        on_found: Callable[[Sequence[Made]], object],
    ) -> BackgroundTask:
        """Start to find objects; none are found where that fails."""

        def report_failure(message: str) -> Report:
            self._session.tasks.call_in_window(partial(on_found, ()))
            return CommandFailed(message)

        return self._session.tasks.start_task(name, find, tr("finding objects"), report_failure, on_result=on_found)

    def _on_objects_found(self, partition: AnyPartition, found: Sequence[tuple[Proposal, bool]]) -> None:
        if self._searched is partition:
            new, covered = ([each for each, known in found if known == is_known] for is_known in (False, True))
            self._offer(new, self._alike, covered)
            self._is_searched = True
            if found and not (self.selecting or self._waiting):
                self._list.select_objects(())  # an object accepted before would keep Enter from what was found
            self._request_answer()
            self.changed.emit()

    def _get_selector(self, partition: AnyPartition, number: int) -> Selector:
        """Return the selector for the object of a number, or for a new one."""
        known = self._session.document.objects
        self._find_offered(partition)
        found, rejected = self._offered, known.dismissed
        made_of = partition, known.items, found, rejected, known.may_overlap
        if any(each.made_of != made_of for each in self._selectors.values()):
            source = self.partition_updater.source
            waited = isinstance(source, EverywhereRun) and source == self._selectors_source
            self._seen = {key: each.known for key, each in self._selectors.items() if waited}
            self._selectors = {}
        if number not in self._selectors:
            self._selectors_source = self.partition_updater.source
            undone = self._session.history.undone_objects
            self._selectors[number] = Selector(
                partition, known.items, number, found, rejected, known.may_overlap, undone, self._seen.get(number)
            )
        return self._selectors[number]

    def _request_answer(self) -> None:
        """Request an answer if anything that it depends on has changed."""
        partition, known = self.partition_updater.partition, self._session.document.objects
        if partition is None:
            self._set_proposals(())
            self._catch_up()
            return
        changed = self.selector is not None and known.items != self.selector.items
        gone = {click for item in known.items for click in item.clicks} if changed else set()  # accepted meanwhile
        if changed:  # a click there may mean something else now: previewed again when the pointer moves
            self._pointed = None
            self._update_shown_objects(preview=None)
        self._set_proposals(
            tuple(each for each in self.proposals if not gone.issuperset(each.clicks) and (each.key or known.clicks))
        )
        pointed, stepped = None, None
        if self._pointed is not None and self.answered and not (self._waiting or self._was_running):
            before, number = self._clicks_to_extend(*self._pointed)
            pointed = self._get_selector(partition, number), before, self._pointed[0]
        if self._steps:
            before, number = self._stepped_clicks
            stepped = self._get_selector(partition, number), before, self._steps
        selector, clicks = self._get_selector(partition, known.edited), known.clicks
        asked = selector, clicks, pointed, stepped
        if asked != self._asked:
            self.selector, self._asked = selector, asked

            def compute_answer() -> tuple[tuple[Proposal, ...], Preview | None, tuple[Clicks, int, int] | None]:
                offered = selector.propose(clicks)
                preview = None if pointed is None else pointed[0].preview_click(*pointed[1:])
                return offered, preview, None if stepped is None else stepped[0].step_clicks(*stepped[1:])

            self._latest.submit(
                compute_answer,
                lambda answer: self._on_answer(selector, clicks, stepped, *answer),
                lambda: self._on_failure(selector, clicks, asked),
            )
        self._catch_up()

    @property
    def _stepped_clicks(self) -> tuple[Clicks, int]:
        """The clicks of the object being selected, or of the only selected one, and the number of the object."""
        selected = self._session.scene.objects.selected or {each.key for each in self.proposals}
        return self._clicks_before(next(iter(selected)) if len(selected) == 1 else 0)

    def _on_answer(
        self,
        selector: Selector,
        clicks: Clicks,
        step: tuple[Selector, Clicks, int] | None,
        proposals: tuple[Proposal, ...],
        preview: Preview | None,
        candidate: tuple[Clicks, int, int] | None,
    ) -> None:
        if selector is not self.selector or clicks != self._session.document.objects.clicks:
            return  # the next answer is on its way
        self._update_shown_objects(preview=preview if self._pointed is not None else None)
        before = self.proposals
        self._set_proposals(proposals)
        remark = translate_core_text(proposals[0].selection.remark) if clicks and proposals else ""
        remark = " ".join(filter(None, (remark, describe_no_effect(before, proposals))))
        if remark and remark != self._remark and not clicks[-1].step:  # once; of a candidate its number is said
            self._session.messages.show(remark, category=EDITING_CATEGORY)
        self._remark = remark
        if candidate is not None and step is not None:
            if self._asked[3:] == (step,):  # the same step can be asked for again
                self._asked = (*self._asked[:3], None)
            self._on_candidate(step, *candidate)
        last, self._answered = self._answered, (selector, clicks)
        if last is None or last[0] is not selector:
            self.changed.emit()
        self._catch_up()
        if self._pointed is not None:
            self._request_answer()  # what a click there would do now

    def _on_failure(self, selector: Selector, clicks: Clicks, asked: tuple[object, ...]) -> None:
        """Give up what waits for an answer that does not come."""
        if asked is not self._asked:
            return  # the next answer is on its way
        self._answered = selector, clicks
        self._waiting.clear()
        self._steps = 0
        self._show_awaited_clicks()
        self.changed.emit()

    def _catch_up(self) -> None:
        """Do what has waited for an answer, up to what needs the next one."""
        if self._is_catching_up:
            return
        self._is_catching_up, waited = True, len(self._waiting)
        try:
            while self._waiting and self.answered and not (self._steps or self._pages.is_turning):
                if self._is_finding and self._waiting[0].needs_offer():
                    break
                self._waiting.popleft().run()
        finally:
            self._is_catching_up = False
        self._show_awaited_clicks()
        if len(self._waiting) != waited:
            self.changed.emit()

    def _show_awaited_clicks(self) -> None:
        """Mark the clicks whose answer, or whose next candidate, is not shown yet."""
        known = self._answered[1] if self._answered is not None else ()
        clicks = () if self.answered else self._session.document.objects.clicks
        new = (each for each in clicks if each not in known)
        stepped = self._stepped_clicks[0][-1:] if self._steps else ()
        later = (each.click for each in self._waiting if each.click is not None)
        before, awaited = self._session.scene.objects.awaited, (*new, *stepped, *later)
        marks = {"preview": None} if awaited else {}  # it may be of another place: what waits is marked where it is
        self._update_shown_objects(awaited=awaited, **marks)
        if self._session.scene.objects.awaited != before:
            self.changed.emit()

    def _on_candidate(self, step: tuple[Selector, Clicks, int], clicks: Clicks, number: int, count: int) -> None:
        """Select a candidate, and show its number."""
        (_, asked, by), (before, edited) = step, self._stepped_clicks
        self._steps = 0
        if asked != before:
            return
        if not clicks:
            unclear = tr("Click an object, or select one, to make it smaller or larger.")
            self._session.messages.show(unclear, category=EDITING_CATEGORY)
        elif clicks == before:
            none = tr("There is no larger candidate.") if by > 0 else tr("There is no smaller candidate.")
            self._session.messages.show(none, category=EDITING_CATEGORY)
        else:
            self._set_clicks(tr("larger candidate") if by > 0 else tr("smaller candidate"), clicks, edited)
            ranked = tr("Candidate {number} of {count}.", number=number, count=count)
            self._session.messages.show(ranked, category=EDITING_CATEGORY)

    def _set_proposals(self, proposals: tuple[Proposal, ...]) -> None:
        """Replace the proposals; there are none while there is no partition."""
        before, ready = self.proposals, self.ready
        same = [(each.key, each.selection) for each in before] == [(each.key, each.selection) for each in proposals]
        if same and ready == self._was_ready:
            return
        self._was_ready = ready
        self._update_shown_objects(proposals=proposals)
        self.changed.emit()

    def _update_shown_objects(self, **parts: Any) -> None:
        scene = self._session.scene
        if any(getattr(scene.objects, name) != part for name, part in parts.items()):
            self._session.store.set_scene(replace(scene, objects=replace(scene.objects, **parts)))

    def _on_image_changed(self) -> None:
        self._latest.drop_waiting()
        self._finding.cancel()
        self._comparing.cancel()
        self._finding = self._comparing = ENDED_TASK
        self._selectors, self._seen, self._found, self._alike, self._covered = {}, {}, (), (), ()
        if not self._pages.is_turning:  # else what waits is for the page
            self._waiting.clear()
        self.selector = self._answered = self._pointed = self._searched = None
        self._steps, self._run_ended, self._asked = 0, False, ()


def describe_no_effect(before: tuple[Proposal, ...], after: tuple[Proposal, ...]) -> str:
    """Return a message if the newest click has not changed the object; else ""."""
    if not before or not after or after[0].key or len(after[0].clicks) != len(before[0].clicks) + 1:
        return ""
    one, other = before[0].selection, after[0].selection
    if not before[0].clicks or not one.has_same_region(other):
        return ""
    return tr("This click changes nothing: the object already looks like that.")
