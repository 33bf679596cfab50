"""Objects followed through the pages of a stack: offered on the opened page, or accepted on all later ones."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from cpm_app.model.document import objects
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.text.language import translate_core_text, tr
from cpm_app.session.features.kept_pages import StackSource, bare, numbered
from cpm_app.session.features.object_selection import ObjectSelection, Search
from cpm_app.session.features.selector import Everywhere, from_everywhere, parameters_everywhere
from cpm_app.session.features.stack_pages import StackPages
from cpm_app.session.scene import Proposal
from cpm_app.session.session import Session
from cpm_app.session.signals import RUNNING
from cpm_app.session.tasks.tasks import OVER, Task
from cpm_core import Image, Partition, TrackEvent
from cpm_core.numerics.types import record
from cpm_core.objects.segmented import Click, SegmentedObject, selection_from_object
from cpm_core.pages import FollowedObject, ObjectFollower, limit_scales

_RETRY_DELAY = 100
"""Time after which accepting objects on a page that is being opened is tried again [ms]."""

_MAX_LISTED_EVENTS = 3
"""Number of events that a message lists; the table has all."""


@record
class Former:
    """The last two pages with objects before a page, by number, and the largest number of any object of the stack."""

    source: StackSource
    pages: tuple[tuple[int, Document], ...]
    taken: int

    def follower(self) -> ObjectFollower:
        """Make a follower of the objects, which reads these pages."""
        made = ObjectFollower(self.taken)
        for number, document in self.pages:
            _take(made, self.source.pages[number - 1], document)
        return made

    def offered(self, number: int, session: Session, partition: Partition, task: Task) -> tuple[Proposal, ...]:
        """Find the objects on a page as proposals; parts that have split off get their numbers when accepted."""
        found, events = self.follower().find_on_page(number, partition, task.check_cancelled)
        items = _items(found, self.pages[-1][1].objects.items)
        if events:
            session.tasks.call(partial(session.say, _sentences(events)))
        return tuple(
            Proposal(one.selection, item.clicks, one.number if one.number == one.origin else 0, ~at, item)
            for at, (one, item) in enumerate(zip(found, items, strict=True))
        )


class FollowedObjects(QObject):
    """Offers the objects of the previous page on the opened page, and follows them through all pages."""

    def __init__(self, session: Session, pages: StackPages, selection: ObjectSelection) -> None:
        super().__init__(session)
        self._session, self._pages, self._selection = session, pages, selection
        self._image: Image | None = None
        self._search: Search | None = None
        self._task = OVER
        selection.followed = lambda: self._search if self._image is session.image else None
        pages.changed.connect(self._look)

    @property
    def running(self) -> bool:
        """Whether objects are being followed in the background."""
        return not self._task.over

    def run(self) -> None:
        """Accept the objects of the open page on all later pages without objects of their own."""
        session, pages, here = self._session, self._pages, self._session.document
        session.attempt(RUNNING)
        if not here.objects.items:
            session.say(tr("There is nothing to follow: accept an object on this page first."), True, RUNNING)
            return
        documents, former, base = pages.documents, self._former(pages.number + 1), bare(here)
        source, numbers = pages.source, range(pages.number + 1, pages.count + 1)

        def follow_objects(task: Task) -> tuple[list[TrackEvent], int]:
            happened: list[TrackEvent] = []
            follower, before = former.follower(), here
            for number in numbers:
                task.advance((number - numbers[0]) / len(numbers))
                image, document = source.pages[number - 1], documents.get(number, base)
                if not document.objects.items:
                    parameters = limit_scales(parameters_everywhere(document), image.shape)
                    partition = from_everywhere(Everywhere(image, parameters, document.regions), task)
                    found, events = follower.find_on_page(number, partition, task.check_cancelled)
                    happened += events
                    items = _items(found, before.objects.items)
                    if not items:
                        return happened, number
                    reference = ImageReference.from_image(Path(source.path), image, source.reading_of(number))
                    session.tasks.call(partial(self._accept, number, reference, items))
                    document = replace(document, objects=replace(document.objects, items=items))
                _take(follower, image, document)
                before = document
            return happened, 0

        title = tr("Following objects on {count} pages…", count=len(numbers))
        self._task = session.tasks.start(title, follow_objects, tr("following objects"), then=self._report)

    # Internal

    def _former(self, number: int) -> Former:
        """Return the last pages with objects before a page."""
        found = ((page, each) for page, each in sorted(self._pages.documents.items()) if page < number)
        with_objects = [(page, each) for page, each in found if each.objects.items]
        return Former(self._pages.source, tuple(with_objects[-2:]), self._pages.taken)

    def _look(self) -> None:
        """Offer the followed objects on an opened page that has no objects yet."""
        session, number = self._session, self._pages.number
        if self._image is not session.image:
            self._image, former = session.image, self._former(number)
            offers = former.pages and not session.document.objects.items
            self._search = partial(former.offered, number, session) if offers else None
            self._selection.search()

    def _accept(self, number: int, image: ImageReference, items: tuple[SegmentedObject, ...]) -> None:
        """Accept objects on a page, unless another stack is open or the page has objects of its own by now."""
        if number == self._pages.ahead != self._pages.number:  # it is being opened
            QTimer.singleShot(_RETRY_DELAY, self, partial(self._accept, number, image, items))
            return
        known = self._pages.documents.get(number)
        if self._pages.source.path != image.path or (known is not None and known.objects.items):
            return

        def accept_items(document: Document) -> Document:
            taken = max(document.objects.taken, *(item.number for item in items))
            same = document.image if known is not None else image
            return objects.accept_objects(replace(numbered(document, taken), image=same), items)

        self._pages.change(number, tr("follow objects"), accept_items)

    def _report(self, done: tuple[list[TrackEvent], int]) -> None:
        """Report what has happened to the objects, and the page on which none was found any more."""
        events, lost = done
        taken = self._pages.taken
        if taken >= self._session.document.objects.next_number:  # parts that have split off have numbers of their own
            self._session.edit(tr("follow objects"), lambda document: numbered(document, taken))
        messages = [_sentences(events)] if events else []
        if lost:
            messages.append(tr("Page {number}: no object was found again. Accept one there to follow it.", number=lost))
        self._session.say(" ".join(messages) or tr("The objects were followed through all pages."))


def _take(follower: ObjectFollower, image: Image, document: Document) -> None:
    """Pass the objects of a page to a follower."""
    found = {item.number: selection_from_object(item, image.shape) for item in document.objects.items}
    follower.remember_page(image.gray_levels(document.parameters.channel), found)


def _items(found: Sequence[FollowedObject], before: Iterable[SegmentedObject]) -> tuple[SegmentedObject, ...]:
    """Make objects of what was found, with class and color of their origin, and its name if it is the same object."""
    like, items = {item.number: item for item in before}, []
    for one in found:
        known, shape = like[one.origin], one.selection.mask.shape
        item = objects.object_from_selection(one.selection, (), one.number, known.category)
        name = known.name if one.number == one.origin else ""
        items.append(replace(item, clicks=(Click((item.find_innermost_pixel(shape),)),), name=name, color=known.color))
    return tuple(items)


def _sentences(events: Sequence[TrackEvent]) -> str:
    """Describe the first events in words; the table has all of them."""
    sentences = [translate_core_text(event.sentence) for event in events[:_MAX_LISTED_EVENTS]]
    return " ".join([*sentences, "…"] if len(events) > _MAX_LISTED_EVENTS else sentences)
