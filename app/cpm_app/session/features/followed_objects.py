"""Objects followed through the pages of a stack: offered on the opened page, or accepted on all later ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.document import objects
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.features.kept_pages import StackSource, without_results
from cpm_app.session.features.selector import EverywhereRun, parameters_everywhere, partition_from_everywhere
from cpm_app.session.features.stack_pages import StackPages
from cpm_app.session.scene import Proposal
from cpm_app.session.session import Session
from cpm_app.session.session_messages import RUNNING_CATEGORY
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import Image, Partition, TrackEvent
from cpm_core.objects.segmented import Click, SegmentedObject, selection_from_object
from cpm_core.pages import FollowedObject, ObjectFollower, limit_scales

_RETRY_DELAY = 100
"""Time after which accepting objects on a page that is being opened is tried again [ms]."""

ObjectSearch = Callable[[Partition, BackgroundTask], tuple[Proposal, ...]]
"""Finds objects to offer on a page."""

_MAX_LISTED_EVENTS = 3
"""Number of events that a message lists; the table has all."""


class FollowedObjects(QObject):
    """Offers the objects of the previous page on the opened page, and follows them through all pages."""

    search_changed = Signal()
    """Another page is open: `search`."""

    def __init__(self, session: Session, pages: StackPages) -> None:
        super().__init__(session)
        self._session, self._pages = session, pages
        self._seen: tuple[Image | None, bool] = None, False
        """The open image, and whether pages are followed."""
        self._search: ObjectSearch | None = None
        self._task = ENDED_TASK
        pages.changed.connect(self._on_page_changed)

    @property
    def search(self) -> ObjectSearch | None:
        """The search for objects to offer, such as those of the previous page; None if there are none."""
        return self._search if self._seen[0] is self._session.image else None

    @property
    def running(self) -> bool:
        """Whether objects are being followed in the background."""
        return not self._task.is_over

    def follow_all_pages(self) -> None:
        """Accept the objects of the open page on all later pages without objects of their own."""
        session, pages, here = self._session, self._pages, self._session.document
        session.messages.clear(RUNNING_CATEGORY)
        if not here.objects.items:
            session.messages.show(
                tr("There is nothing to follow: accept an object on this page first."), True, RUNNING_CATEGORY
            )
            return
        documents, previous, base = pages.documents, self._find_previous_pages(pages.number + 1), without_results(here)
        source, numbers, largest = pages.source, range(pages.number + 1, pages.count + 1), pages.largest_number

        def follow_objects(task: BackgroundTask) -> tuple[list[TrackEvent], int]:
            happened: list[TrackEvent] = []
            follower, before = _make_follower(source, previous, largest), here
            for number in numbers:
                task.advance((number - numbers[0]) / len(numbers))
                image, document = source.pages[number - 1], documents.get(number, base)
                if not document.objects.items:
                    parameters = limit_scales(parameters_everywhere(document), image.shape)
                    partition = partition_from_everywhere(EverywhereRun(image, parameters, document.regions), task)
                    found, events = follower.find_on_page(number, partition, task.check_cancelled)
                    happened += events
                    items = _make_objects(found, before.objects.items)
                    if not items:
                        return happened, number
                    reference = ImageReference.from_image(Path(source.path), image, source.reading_for(number))
                    session.tasks.call_in_window(partial(self._accept_on_page, number, reference, items))
                    document = replace(document, objects=replace(document.objects, items=items))
                _feed_follower(follower, image, document)
                before = document
            return happened, 0

        title = tr("Following objects on {count} pages…", count=len(numbers))
        self._task = session.tasks.start_task(
            title, follow_objects, tr("following objects"), on_result=self._on_followed
        )

    # Internal

    def _find_previous_pages(self, number: int) -> Sequence[tuple[int, Document]]:
        """Find the last two pages with objects before a page."""
        known = sorted(self._pages.documents.items())
        return [(page, each) for page, each in known if page < number and each.objects.items][-2:]

    def _on_page_changed(self) -> None:
        """Offer the followed objects on an opened page that has no objects yet."""
        session, number, seen = self._session, self._pages.number, (self._session.image, self._pages.following)
        if seen != self._seen:
            self._seen = seen
            previous = self._find_previous_pages(number) if self._pages.has_images and self._pages.following else ()
            source, largest = self._pages.source, self._pages.largest_number

            def find_proposals(partition: Partition, task: BackgroundTask) -> tuple[Proposal, ...]:
                follower = _make_follower(source, previous, largest)
                found, events = follower.find_on_page(number, partition, task.check_cancelled)
                if events and source.kind != "channel":  # between channels nothing ends or begins
                    session.tasks.call_in_window(partial(session.messages.show, _describe_events(events)))
                items = _make_objects(found, previous[-1][1].objects.items)
                return tuple(  # parts that have split off get their numbers when accepted
                    Proposal(
                        one.selection, item.clicks, one.number if one.number == one.origin else 0, followed_object=item
                    )
                    for one, item in zip(found, items, strict=True)
                )

            self._search = find_proposals if previous and not session.document.objects.items else None
            self.search_changed.emit()

    def _accept_on_page(self, number: int, image: ImageReference, items: tuple[SegmentedObject, ...]) -> None:
        """Accept objects on a page, unless another stack is open or the page has objects of its own by now."""
        if number == self._pages.wanted_page != self._pages.number:  # it is being opened
            QTimer.singleShot(_RETRY_DELAY, self, partial(self._accept_on_page, number, image, items))
            return
        known = self._pages.documents.get(number)
        if self._pages.source.path != image.path or (known is not None and known.objects.items):
            return

        def accept_items(document: Document) -> Document:
            document = objects.with_taken_numbers(document, max(item.number for item in items))
            same = document.image if known is not None else image
            return objects.accept_objects(replace(document, image=same), items)

        self._pages.edit_page(number, tr("follow objects"), accept_items)

    def _on_followed(self, done: tuple[list[TrackEvent], int]) -> None:
        """Report what has happened to the objects, and the page on which none was found any more."""
        events, lost = done
        self._session.take_numbers(self._pages.largest_number)  # parts that have split off have numbers of their own
        messages = [_describe_events(events)] if events else []
        if lost:
            messages.append(tr("Page {number}: no object was found again. Accept one there to follow it.", number=lost))
        self._session.messages.show(" ".join(messages) or tr("The objects were followed through all pages."))


def _make_follower(source: StackSource, pages: Sequence[tuple[int, Document]], largest_number: int) -> ObjectFollower:
    """Make a follower of the objects of pages, which are read here; no object has a number above the largest."""
    made = ObjectFollower(largest_number)
    for number, document in pages:
        _feed_follower(made, source.pages[number - 1], document)
    return made


def _feed_follower(follower: ObjectFollower, image: Image, document: Document) -> None:
    """Pass the objects of a page to a follower, except for open ones."""
    closed = (item for item in document.objects.items if item.region.boundary)
    found = {item.number: selection_from_object(item, image.shape) for item in closed}
    follower.remember_page(image.gray_levels(document.parameters.channel), found)


def _make_objects(found: Sequence[FollowedObject], before: Iterable[SegmentedObject]) -> tuple[SegmentedObject, ...]:
    """Make objects of what was found, with class and color of their origin, and its name if it is the same object."""
    like, items = {item.number: item for item in before}, []
    for one in found:
        known, shape = like[one.origin], one.selection.shape
        item = objects.object_from_selection(one.selection, (), one.number, known.category)
        name = known.name if one.number == one.origin else ""
        items.append(
            replace(item, clicks=(Click((item.region.find_innermost_pixel(shape),)),), name=name, color=known.color)
        )
    return tuple(items)


def _describe_events(events: Sequence[TrackEvent]) -> str:
    """Describe the first events in words; the table has all of them."""
    sentences = [translate_core_text(event.sentence) for event in events[:_MAX_LISTED_EVENTS]]
    return " ".join([*sentences, "…"] if len(events) > _MAX_LISTED_EVENTS else sentences)
