"""The pages of the open stack: the shown page, runs of all pages in the background, and the results of all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.display.page_rows import PageRow
from cpm_app.model.document.document import Document
from cpm_app.model.document.objects import with_taken_numbers
from cpm_app.model.document.saving import to_session_file
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import FilesExported, ImageOpened, OpeningFailed, Report, SavedSession
from cpm_app.session.features.background import IdentityCache, LatestOnlyWorker
from cpm_app.session.features.contour_selection import ContourSelection
from cpm_app.session.features.kept_pages import (
    EMPTY_TABLE,
    KeptPage,
    LazyJsonPages,
    LinkedPages,
    StackSource,
    StackTable,
    StoredPages,
    give_starts,
    link_pages,
    pages_to_json,
    run_pages,
    without_results,
)
from cpm_app.session.features.selector import is_covered
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EXPORTING_CATEGORY, OPENING_CATEGORY, RUNNING_CATEGORY
from cpm_app.session.storage.session_file import DocumentFile, SessionWritten
from cpm_app.session.tasks.opening import OpenRequest
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_app.session.undo_history import Change
from cpm_core import Page, Result
from cpm_core.formats import ImageFile, describe_shapes, export_stack
from cpm_core.formats.stack_files import paint_tracks
from cpm_core.image.region import Region
from cpm_core.numerics.types import JsonObject
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.pages import PageFollower, StackResult
from cpm_core.shapes import Start, starts_from_contours

_LINK_DELAY = 200
"""Time from a change until the pages are linked again [ms]."""

_LINK_DELAY_WHILE_RUNNING = 1500
"""Time from a change until the pages are linked again while pages are run in the background [ms]."""


class StackPages(QObject):
    """Navigates the pages of a stack, runs all of them, and holds the results of each."""

    changed = Signal()
    """Another page is open, runs of pages have begun, whose end `TaskManager.changed` tells, or `following` differs."""
    results_changed = Signal()
    """The results of all pages have changed: `result`."""

    def __init__(self, session: Session, contour_selection: ContourSelection) -> None:
        super().__init__(session)
        self.following = True
        """Whether each page starts from the contours of the previous one, and is offered its objects.

        At first it is, except for channels, which show the same place in other ways.
        """
        self._session = session
        self._file: DocumentFile
        self.source = StackSource()
        self.number = 1
        """Number of the open page, from 1."""
        self.wanted_page = 0
        """Number of the requested page, which is open or being opened."""
        self._turning, self._opening, self._opening_number = False, ENDED_TASK, 0
        self._kept: dict[int, KeptPage] = {}
        self._found_pages: dict[int, Page] = {}
        self._proposed: dict[int, Page] = {}
        self._given_starts: tuple[Start, ...] = ()
        self.table: StackTable = EMPTY_TABLE
        """What was found on all pages, with tracks, and the rows: the objects of a page, or else its contours."""
        self._linked: Mapping[int, Page] = {}
        """The contours of all finished pages, as files hold them."""
        self._measured = IdentityCache()
        self._last_objects: SegmentedObjects | None = None
        self.task = ENDED_TASK
        self._last_result: Result | None = None
        self._drawn: tuple[JsonObject, ...] = ()
        self._linking = LatestOnlyWorker(session, "cpm-pages", tr("following objects through the pages"))
        self._later = QTimer(self, singleShot=True)
        self._later.timeout.connect(self._link_pages)
        self._wanted_row: PageRow | None = None
        self._contour_selection = contour_selection
        contour_selection.changed.connect(self._select_wanted)
        self.changed.connect(self._select_wanted)
        session.store.add_listener(ImageOpened, self._on_image_opened)
        session.store.add_listener(OpeningFailed, self._on_opening_failed)

        def on_session_written(written: SessionWritten) -> None:
            if self._file.is_current(written):
                for number, page in self._kept.items():
                    self._kept[number] = replace(page, saved_document=page.document, runs_unsaved=False)

        session.store.add_listener(SessionWritten, on_session_written)
        session.store.scene_changed.connect(self._on_scene_changed)

    def set_session_file(self, document_file: DocumentFile) -> None:
        """Set the session file, which keeps the runs of the open page; it is made after the pages that it stores."""
        self._file = document_file

    @property
    def running(self) -> bool:
        """Whether pages are being run in the background."""
        return not self.task.is_over

    @property
    def result(self) -> StackResult | None:
        """What was found on all pages, which is exported; None while there is nothing."""
        return self.table[0]

    # Documents

    @property
    def documents(self) -> dict[int, Document]:
        """The documents of the pages that have been opened, or changed in the background."""
        kept = {number: page.document for number, page in self._kept.items()}
        return {**kept, self.number: self._session.document} if self.count else {}

    @property
    def largest_number(self) -> int:
        """Largest number of an object on any page."""
        proposed = (one.number for page in self._proposed.values() for one in page.contours)
        known = (document.objects.next_number - 1 for document in self.documents.values())
        return max((*known, *proposed), default=0)

    def edit_page(self, number: int, undo_text: str, edit: Callable[[Document], Document]) -> None:
        """Edit the document of a page, with undo on that page."""
        if number == self.number:
            self._session.edit(undo_text, edit)
            return
        page = self._kept.get(number) or self._make_fresh_page(number, self._describe_open_page())
        document = edit(page.document)
        page.history.push(Change(undo_text, page.document, document))
        self._kept[number] = replace(page, document=document)
        self._link_soon()

    # Paging

    @property
    def count(self) -> int:
        """Number of pages of the stack; 0 if no stack is open as pages."""
        return self.source.count

    @property
    def is_turning(self) -> bool:
        """Whether a page is being opened, or the open one again; false if that has failed or was canceled."""
        return self._turning or self._is_opening

    @property
    def _is_opening(self) -> bool:
        """Whether page `_opening_number` is being opened, or is ready to be shown."""
        return self._opening is not ENDED_TASK and not self._opening.is_cancelled

    @property
    def has_images(self) -> bool:
        """Whether the pages are images, which are run and linked together."""
        return self.count > 1 and not self.source.has_volumes

    def is_drawn(self, document: Document) -> bool:
        """Return whether the starts of the open page are drawn by the user, not from the previous page."""
        return not self._given_starts or document.starts != self._given_starts

    @property
    def proposed(self) -> Page | None:
        """The objects that the run of the open page proposes, numbered by their tracks; None unless all were run."""
        return self._proposed.get(self.number)

    @property
    def offers_objects(self) -> bool:
        """Whether a page offers objects that are not all rejected or deleted, and none of which is accepted."""
        documents = self.documents

        def offers(number: int, page: Page) -> bool:
            known = documents[number].objects if number in documents else SegmentedObjects()
            if known.items or page.result is None:
                return False
            if not known.dismissed:
                return bool(page.contours)
            tracks = paint_tracks(page.result, page.result.shape)
            found = (Region.from_mask(tracks == one) for one in np.unique(tracks[tracks > 0]))
            return any(not is_covered(one, tracks.shape, (), known.dismissed) for one in found)

        return any(offers(*each) for each in self._proposed.items())

    @property
    def found_objects(self) -> str:
        """Sentence on the objects that runs of all pages propose; empty before there are any."""
        pages = [page for page in self._proposed.values() if page.result is not None]
        count = len({one.number for page in pages for one in page.contours})
        found = tr("{pages} of {all} pages were run. Proposals on them, each counted once: {count}.",
                   pages=len(pages), all=self.count, count=count)  # fmt: skip
        return found if self._proposed else ""

    def go_by(self, by: int) -> None:
        """Go some pages forward or backward, also past a page that could not be opened."""
        self.open_page(min(max(self.wanted_page + by, 1), self.count))

    def toggle_following(self) -> None:
        """Follow from page to page from now on, or no longer."""
        self.following = not self.following
        self.changed.emit()

    def open_page(self, number: int) -> None:
        """Go to a page, once the runs of the open page have been collected."""
        if not 1 <= number <= self.count or number == self.wanted_page:
            return
        self.wanted_page = number
        self._turn()

    def _turn(self) -> None:
        """Open the wanted page, once the runs of the open page have been collected."""
        if not self._turning:
            self._turning = True
            self._session.pause()
            self._file.runs.collect_runs(self._open_wanted_page)

    def show_row(self, row: PageRow) -> None:
        """Go to the page of a row and, if the row has an object or contour, select it as soon as it is there."""
        self._wanted_row = row if row.measures is not None else None
        self.open_page(row.page)
        self._select_wanted()

    def _select_wanted(self) -> None:
        """Select the wanted row; drop it if another page has been requested meanwhile."""
        row = self._wanted_row
        if row is None:
            return
        if self.wanted_page != row.page:
            self._wanted_row = None
        elif self.number == row.page and row.is_object:
            self._wanted_row = None
            self._contour_selection.select(objects=(row.track,))
        elif self.number == row.page and row.index < len(self._session.scene.contours):
            self._wanted_row = None
            self._contour_selection.select((row.index,))

    def _open_wanted_page(self) -> None:
        """Keep the state of the open page, and open the requested one."""
        self._turning = False
        if not self.count:
            return
        opens_again = self._is_opening and self._opening_number == self.number  # with what a run of it has found
        if self.wanted_page == self.number:
            if not opens_again:
                self._opening.cancel()  # of a page that has been left before it was open
            return
        here = self._kept[self.number] if opens_again else self._describe_open_page()
        self._kept[self.number] = here
        self._begin_page(
            self.wanted_page, self._kept.get(self.wanted_page) or self._make_fresh_page(self.wanted_page, here)
        )

    def _begin_page(self, number: int, page: KeptPage) -> None:
        """Open a page with its kept state; the image stays where it is on the canvas."""
        image = self._session.document.image
        if image is None:
            return
        known = page.saved_document and with_taken_numbers(page.saved_document, self.largest_number)
        page = replace(page, document=with_taken_numbers(page.document, self.largest_number), saved_document=known)
        place = ImageFile(image.path, "", image.shape, reading=self.source.reading_for(number))
        now = self._file.content  # its view keeps the image in place
        content = replace(
            to_session_file(page.document, dict(now.view), now), image=place, runs=page.runs, truth=None, pages={}
        )
        self._kept[number], self._opening_number = page, number
        saved = SavedSession(self._file.path, content, is_other_page=True, saved_document=page.saved_document)
        self._opening = self._session.begin_opening(
            OpenRequest(Path(image.path), page.document.parameters, saved=saved)
        )

    def _describe_open_page(self) -> KeptPage:
        """Return the state of the open page."""
        session, runs = self._session, self._file.runs
        return KeptPage(
            session.document,
            runs.runs_json,
            session.history,
            self._file.saved_document,
            self._given_starts,
            runs.unsaved,
        )

    def _make_fresh_page(self, number: int, here: KeptPage) -> KeptPage:
        """Make the state of an untouched page: with the shapes of the open page, or starts from the previous page."""
        if self.source.has_volumes:
            document = replace(without_results(here.document), second=here.document.second)
            return KeptPage(document, saved_document=document)
        before = self._found_pages.get(number - 1) if self.following else None
        starts = () if before is None else starts_from_contours(before.contours)
        document, given = give_starts(without_results(here.document), starts)
        return KeptPage(document, saved_document=document, given_starts=given)

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Take over an opened page of the stack, or another file."""
        if opened.saved is not None and opened.saved.is_other_page:
            # another page may be requested by now: the state of this one is kept until `_open_wanted_page` leaves it
            self.number, self._opening = self.source.page_number(opened.reading), ENDED_TASK
            page = self._kept.get(self.number)
            if page is not None:
                self._given_starts = page.given_starts
                self._session.history = page.history.move_to_image(self._session.document.image)
                self._session.store.announce_status()
            if self.number != self.wanted_page:  # this one was ready when it was left
                self._turn()
        else:
            self._begin_stack(opened)
        self.changed.emit()

    def _on_opening_failed(self, _: OpeningFailed) -> None:
        self._opening = ENDED_TASK

    # Running all

    def run_all(self, first: int = 1) -> None:
        """Run all pages from one on, in the background."""
        document = self._session.document
        self._session.messages.clear(RUNNING_CATEGORY)
        if not self.has_images or self.running:
            return
        if not document.starts:
            self._session.messages.show(document.nothing_to_start_from, True, RUNNING_CATEGORY)
            return
        kept, following = {**self._kept, self.number: self._describe_open_page()}, self.following
        self._drawn = describe_shapes(document.shapes)
        before = tuple(page for number, page in sorted(self._linked.items()) if number < first)
        self._proposed = {number: page for number, page in sorted(self._proposed.items()) if number < first}
        used = (item.number for one in self.documents.values() for item in one.objects.items)
        proposed = PageFollower(tuple(self._proposed.values()), max(used, default=0))
        source, numbers = self.source, range(first, self.count + 1)

        def document_of(number: int, starts: tuple[Start, ...]) -> tuple[Document, tuple[Start, ...]]:
            """Return a page's own document if the user has drawn its start, else that of the open page."""
            page = kept.get(number)
            own = without_results(document) if page is None else replace(page.document, parameters=document.parameters)
            if page is not None and page.has_own_start:
                return own, ()
            return give_starts(own, (starts if following else ()) or document.starts)

        def run_and_report(task: BackgroundTask) -> None:
            for page, offered, done in run_pages(source, numbers, document_of, before, proposed, task):
                self._session.tasks.call_in_window(
                    partial(self._on_page_done, source.path, kept.get(page.number), page, offered, done)
                )

        title = tr("Running {count} pages…", count=len(numbers))
        activity = tr("running the pages")
        self.task = self._session.tasks.start_task(title, run_and_report, activity, on_result=self._on_all_done)
        self.changed.emit()

    def cancel(self) -> None:
        """Stop running pages; finished ones stay."""
        self.task.cancel()

    def _on_all_done(self, _: None) -> None:
        """Say what was found on all pages, and let new objects of the open page get numbers of their own."""
        self._session.take_numbers(self.largest_number)
        self._session.messages.show(self.found_objects, category=RUNNING_CATEGORY)

    def _on_page_done(self, path: str, known: KeptPage | None, page: Page, offered: Page, done: KeptPage) -> None:
        """Keep a page that has been run, unless the user has changed it since; the open one is opened again."""
        number, here = page.number, page.number == self.number
        if path != self.source.path:
            return
        before = self._describe_open_page() if here else self._kept.get(number)
        if before is not None and _is_changed(before, known):
            return
        self._found_pages[number], self._proposed[number] = page, offered
        self._link_soon()
        if not done.runs:
            return
        if before is not None:
            if before.document != done.document:  # so that undo restores the previous document
                before.history.push(Change(tr("run all pages"), before.document, done.document))
            document = before.history.forget_deleted(done.document)
            done = replace(done, document=document, history=before.history, saved_document=before.saved_document)
        self._kept[number] = done
        if here and not self._turning and self._session.status.phase != "running":
            self._begin_page(number, done)

    # Results

    def _on_scene_changed(self) -> None:
        """Keep the contours of the open page, once its run is at rest; an earlier step changes nothing."""
        scene = self._session.scene
        shown, timeline = scene.result, scene.timeline
        if not self.has_images:
            return
        if self._last_objects is not scene.document.objects:
            self._last_objects = scene.document.objects
            self._link_soon()
        if shown is None or self._session.status.phase == "running":
            return
        if any(shown.steps < one.last for one in timeline.branches if one.identity == timeline.branch):
            return
        if shown is not self._last_result:
            self._last_result = shown
            self._found_pages[self.number] = Page(self.number, shown)
            self._link_soon()

    def _link_soon(self) -> None:
        if self.has_images and not self._later.isActive():
            self._later.start(_LINK_DELAY_WHILE_RUNNING if self.running else _LINK_DELAY)

    def _link_pages(self) -> None:
        found = dict(self._found_pages)
        self._linking.submit(
            partial(link_pages, self.source, found, self._drawn, self.documents, self._measured),
            partial(self._on_pages_linked, found),
        )

    def _on_pages_linked(self, found: Mapping[int, Page], made: LinkedPages) -> None:
        """Show linked pages, and keep them in place of those `found`, unless these have been run again since."""
        if made.source.path != self.source.path or not self.count:
            return
        self._linked, self.table = made.found, made.table
        for number, page in made.found.items():
            if number != self.number and self._found_pages.get(number) is found[number]:
                self._found_pages[number] = page
        self.results_changed.emit()

    # Files

    def export_pages(self, *paths: Path) -> None:
        """Write the results of all pages."""
        result, path = self.result, paths[0]
        if result is None:
            return
        self._session.messages.clear(EXPORTING_CATEGORY)

        def write_stack(_: BackgroundTask) -> Report:
            export_stack(result, *paths)
            return FilesExported(path, files=len(paths))

        self._session.tasks.start_task(
            tr("Writing {name}…", name=path.name), write_stack, tr("writing {name}", name=path.name)
        )

    @property
    def has_unsaved_others(self) -> bool:
        """Whether closing would lose changes on pages that are not open."""
        return any(page.unsaved for number, page in self._kept.items() if number != self.number)

    def to_json(self) -> JsonObject:
        """Return the other pages as stored in a session."""
        if not self.count:
            return {}
        others = {number: page for number, page in self._kept.items() if number != self.number}
        given = not self.is_drawn(self._session.document)
        return LazyJsonPages(partial(pages_to_json, others, self.following, self._drawn, given, self._linked))

    def _begin_stack(self, opened: ImageOpened) -> None:
        """Begin the pages of another file, perhaps from a session that contains them."""
        self.cancel()
        in_volume = opened.image.ndim == 3
        source = self.source = StackSource.from_file(str(opened.path), opened.parts, opened.reading, in_volume)
        self.number, self.following = source.page_number(opened.reading), source.kind != "channel"
        self.wanted_page = self.number
        self._kept, self._found_pages, self._proposed, self._given_starts = {}, {}, {}, ()
        self.table, self._linked, self._last_result, self._drawn = EMPTY_TABLE, {}, None, ()
        self._measured = IdentityCache()
        if opened.saved is not None and opened.saved.file.pages and self.count:
            stored = StoredPages.from_json(opened.saved.file.pages, self._session.document, source)
            self._kept, self.following, self._drawn = stored.kept, stored.following, stored.drawn
            self._found_pages, self._given_starts = stored.found, stored.given_starts
            if stored.error:
                self._session.messages.show(stored.error, True, OPENING_CATEGORY)
            self._link_soon()
        self.results_changed.emit()


def _is_changed(page: KeptPage, known: KeptPage | None) -> bool:
    """Tell whether the user has drawn starts, or selected or rejected objects, on a page since it was `known`."""
    now, before = page.document.objects, SegmentedObjects() if known is None else known.document.objects
    selected = (now.items, now.clicks, now.dismissed) != (before.items, before.clicks, before.dismissed)
    return selected or (page.has_own_start and (known is None or page.document != known.document))
