"""The pages of the open stack: the shown page, runs of all pages in the background, and the results of all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.display.page_rows import PageRow
from cpm_app.model.document.document import Document
from cpm_app.model.document.saving import to_session_file
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import Exported, Opened, Report, Saved
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.features.contour_review import ContourReview
from cpm_app.session.features.kept_pages import (
    NOTHING,
    KeptPage,
    Linked,
    Listed,
    Measured,
    PageDone,
    PlainPages,
    StackSource,
    StoredPages,
    Table,
    bare,
    linked,
    numbered,
    pages_to_plain,
    run_pages,
    started_by,
)
from cpm_app.session.session import Session
from cpm_app.session.signals import EXPORTING, OPENING, RUNNING
from cpm_app.session.storage.session_file import DocumentFile, Written
from cpm_app.session.tasks.opening import Wanted
from cpm_app.session.tasks.tasks import Task
from cpm_app.session.undo_history import Change
from cpm_core import Page, Result
from cpm_core.contours import apply_marks, compute_centroid
from cpm_core.formats import ImageFile, export_stack, describe_shapes
from cpm_core.numerics.types import JsonObject
from cpm_core.pages import StackResult
from cpm_core.shapes import Start, starts_from_contours

_QUIET = 200
"""Time from a change until the pages are linked again [ms]."""

_WHILE_RUNNING = 1500
"""Time from a change until the pages are linked again while pages are run in the background [ms]."""

_SAME_CENTER_DISTANCE = 1.0
"""Distance up to which the center of a contour counts as unchanged [px]."""

_SAME_LENGTH_TOLERANCE = 0.02
"""Relative difference up to which the length of a contour counts as unchanged."""


class StackPages(QObject):
    """Navigates the pages of a stack, runs all of them, and holds the results of each."""

    changed = Signal()
    """Another page is open, or runs of pages have begun or ended."""
    found = Signal()
    """The results of all pages have changed: `result`."""

    def __init__(self, session: Session, review: ContourReview) -> None:
        super().__init__(session)
        self.following = True
        """Whether each page starts from the contours of the previous one."""
        self._session = session
        self._file: DocumentFile
        self.source = StackSource()
        self.number = 1
        """Number of the open page, from 1."""
        self.ahead = 0
        """Number of the requested page, which is open or being opened."""
        self._turning = False
        self._kept: dict[int, KeptPage] = {}
        self._found: dict[int, Page] = {}
        self._given: tuple[Start, ...] = ()
        self.listed: Listed = "objects"
        """Kind of results that is shown and exported, if there are both."""
        self.tables: Mapping[Listed, Table] = {}
        """The results of all finished pages, with tracks, and their rows; nothing is filtered."""
        self._measured: Measured = {}
        self.task: Task | None = None
        self._seen: Result | None = None
        self._drawn: tuple[JsonObject, ...] = ()
        self._linking = LatestOnlyWorker(session, "cpm-pages", tr("following objects through the pages"))
        self._later = QTimer(self, singleShot=True)
        self._later.timeout.connect(
            lambda: self._linking.ask(
                partial(linked, self.source, dict(self._found), self._drawn, self.documents, self._measured),
                self._take_linked,
            )
        )
        self._wanted: PageRow | None = None
        self._review = review
        review.changed.connect(self._select_wanted)
        self.changed.connect(self._select_wanted)
        session.listen(Opened, self._take_opened)

        def on_session_written(written: Written) -> None:
            if self._file.is_current(written):
                for number, page in self._kept.items():
                    self._kept[number] = replace(page, known=page.document, runs_unsaved=False)

        session.listen(Written, on_session_written)
        session.scene_changed.connect(self._look)
        session.tasks.changed.connect(self._look_at_task)

    def set_session_file(self, document_file: DocumentFile) -> None:
        """Save the pages with this session file."""
        self._file = document_file
        document_file.pages = self._plain
        document_file.pages_unsaved = lambda: any(
            page.unsaved for number, page in self._kept.items() if number != self.number
        )

    def close(self) -> None:
        """End the threads."""
        self._linking.close()

    @property
    def running(self) -> bool:
        """Whether pages are being run in the background."""
        return self.task is not None

    @property
    def table(self) -> Table:
        """The shown results of all pages: the objects, or the contours with their tracks; None while there are none."""
        return self.tables.get(self.listed) or next(iter(self.tables.values()), NOTHING)

    def show_kind(self, listed: Listed) -> None:
        """Show the objects of all pages, or the contours."""
        self.listed = listed
        self.found.emit()

    @property
    def result(self) -> StackResult | None:
        """The shown results of all pages, which are exported; None while there are none."""
        return self.table[0]

    # Documents

    @property
    def documents(self) -> dict[int, Document]:
        """The documents of the pages that have been opened, or changed in the background."""
        kept = {number: page.document for number, page in self._kept.items()}
        return {**kept, self.number: self._session.document} if self.count else {}

    @property
    def taken(self) -> int:
        """Largest number of an object on any page."""
        return max((document.objects.next_number - 1 for document in self.documents.values()), default=0)

    def change(self, number: int, words: str, edit: Callable[[Document], Document]) -> None:
        """Edit the document of a page, with undo on that page."""
        if number == self.number:
            self._session.edit(words, edit)
            return
        page = self._kept.get(number) or self._fresh(number, self._here())
        document = edit(page.document)
        page.history.push(Change(words, page.document, document))
        self._kept[number] = replace(page, document=document)
        self._link_soon()

    # Paging

    @property
    def count(self) -> int:
        """Number of pages of the stack; 0 if no stack is open as pages."""
        return self.source.count

    def is_drawn(self, document: Document) -> bool:
        """Return whether the starts of the open page are drawn by the user, not from the previous page."""
        return not self._given or document.starts != self._given

    def go(self, by: int) -> None:
        """Go some pages forward or backward, also past a page that could not be opened."""
        self.open(min(max(self.ahead + by, 1), self.count))

    def open(self, number: int) -> None:
        """Go to a page, once the runs of the open page have been collected."""
        if not 1 <= number <= self.count or number == self.ahead:
            return
        self.ahead = number
        if not self._turning:
            self._turning = True
            self._session.pause()
            self._file.runs.collect(self._turn)

    def show(self, row: PageRow) -> None:
        """Go to the page of a row and, if the row has an object or contour, select it as soon as it is there."""
        self._wanted = row if row.measures is not None else None
        self.open(row.page)
        self._select_wanted()

    def _select_wanted(self) -> None:
        """Select the wanted row; drop it if another page has been requested meanwhile."""
        row = self._wanted
        if row is None or row.measures is None:
            return
        if self.ahead != row.page:
            self._wanted = None
        elif self.number == row.page and row.is_object:
            self._wanted = None
            self._review.choose(objects=(row.track,))
        elif self.number == row.page:
            length, place = row.measures.length, (row.row, row.col)
            away = {item: math.dist(compute_centroid(item.contour), place) for item in self._review.items}
            near = min(away, key=away.__getitem__, default=None)
            if (
                near is not None
                and away[near] <= _SAME_CENTER_DISTANCE
                and abs(near.measures.length - length) <= _SAME_LENGTH_TOLERANCE * length
            ):
                self._wanted = None
                self._review.choose((near.key,))

    def _turn(self) -> None:
        """Keep the state of the open page, and open the requested one."""
        self._turning = False
        if not self.count or self.ahead == self.number:
            return
        here = self._kept[self.number] = self._here()
        self._begin(self.ahead, self._kept.get(self.ahead) or self._fresh(self.ahead, here))

    def _begin(self, number: int, page: KeptPage) -> None:
        """Open a page with its kept state; the image stays where it is on the canvas."""
        image = self._session.document.image
        if image is None:
            return
        known = page.known and numbered(page.known, self.taken)
        page = replace(page, document=numbered(page.document, self.taken), known=known)
        place = ImageFile(image.path, "", image.shape, reading=self.source.reading_of(number))
        now = self._file.file  # its view keeps the image in place
        content = replace(
            to_session_file(page.document, dict(now.view), now), image=place, runs=page.runs, truth=None, pages={}
        )
        self._kept[number] = page
        saved = Saved(self._file.path, content, turned=True, known=page.known)
        self._session.begin(Wanted(Path(image.path), page.document.parameters, saved=saved))

    def _here(self) -> KeptPage:
        """Return the state of the open page."""
        session, runs = self._session, self._file.runs
        return KeptPage(session.document, runs.plain, session.history, self._file.known, self._given, runs.unsaved)

    def _fresh(self, number: int, here: KeptPage) -> KeptPage:
        """Make the state of an untouched page: with the shapes of the open page, or starts from the previous page."""
        document, given = bare(here.document), here.given or here.document.starts
        before = self._found.get(number - 1)
        if self.following and before is not None and before.contours:
            given = starts_from_contours(before.contours)
            document = started_by(document, given)
        return KeptPage(document, known=document, given=given)

    def _take_opened(self, opened: Opened) -> None:
        """Take over an opened page of the stack, or another file."""
        if opened.saved is not None and opened.saved.turned:
            # another page may be requested by now: the state of this one is kept until `_turn` leaves it
            self.number = self.source.number_of(opened.reading)
            page = self._kept.get(self.number)
            if page is not None:
                self._given = page.given
                self._session.history = page.history.on(self._session.document.image)
                self._session.show_status()
        else:
            self._begin_stack(opened)
        self.changed.emit()

    # Running all

    def run(self, first: int = 1) -> None:
        """Run all pages from one on, in the background."""
        document = self._session.document
        self._session.attempt(RUNNING)
        if not self.count or self.running:
            return
        if not document.starts:
            self._session.say(document.nothing_to_start_from, True, RUNNING)
            return
        kept, following = {**self._kept, self.number: self._here()}, self.following
        self._drawn = describe_shapes(document.shapes)
        followed, _ = self.tables.get("contours", NOTHING)
        before = () if followed is None else tuple(page for page in followed.pages if page.number < first)
        source, numbers = self.source, range(first, self.count + 1)

        def document_of(number: int, starts: tuple[Start, ...]) -> tuple[Document, tuple[Start, ...]]:
            """Return a page's own document if the user has drawn its start, else that of the open page."""
            page = kept.get(number)
            own = bare(document) if page is None else replace(page.document, parameters=document.parameters)
            if page is not None and page.own_start:
                return own, ()
            given = (starts if following else ()) or document.starts
            return started_by(own, given), given

        def run_and_report(task: Task) -> None:
            for done in run_pages(source, numbers, document_of, before, task):
                self._session.tasks.call(partial(self._take_page, source.path, kept.get(done.page.number), done))

        title = tr("Running {count} pages…", count=len(numbers))
        self.task = self._session.tasks.start(title, run_and_report, tr("running the pages"))
        self.changed.emit()

    def cancel(self) -> None:
        """Stop running pages; finished ones stay."""
        if self.task is not None:
            self.task.cancel()
            self._look_at_task()

    def _take_page(self, path: str, known: KeptPage | None, done: PageDone) -> None:
        """Keep a page that has been run, unless the user has changed it since; the open one is opened again."""
        number, here = done.page.number, done.page.number == self.number
        if path != self.source.path:
            return
        before = self._here() if here else self._kept.get(number)
        if before is not None and (known is None or before.document != known.document) and before.own_start:
            return
        self._found[number] = done.page
        self._link_soon()
        if not done.runs:
            return
        before, document = before or KeptPage(done.document), done.document
        if before.document != document:  # so that undo restores the previous document
            before.history.push(Change(tr("run all pages"), before.document, document))
        self._kept[number] = page = replace(
            before, document=document, runs=done.runs, given=done.given, runs_unsaved=True
        )
        if here and not self._turning and self._session.status.phase != "running":
            self._begin(number, page)

    def _look_at_task(self) -> None:
        if self.task is not None and self.task.over:
            self.task = None
            self.changed.emit()

    # Results

    def _look(self) -> None:
        """Keep the contours of the open page, once its run is at rest."""
        scene = self._session.scene
        tracked, shown = scene.contours.tracked, scene.contours.result
        if self.count and self._measured.get(self.number, (None,))[0] is not scene.document.objects:
            self._link_soon()
        if not self.count or tracked is None or shown is None or self._session.status.phase == "running":
            return
        if shown is not self._seen:
            self._seen = shown
            self._found[self.number] = Page(self.number, apply_marks(shown, scene.document.marks))
            self._link_soon()

    def _link_soon(self) -> None:
        if not self._later.isActive():
            self._later.start(_WHILE_RUNNING if self.running else _QUIET)

    def _take_linked(self, made: Linked) -> None:
        if made.source.path != self.source.path or not self.count:
            return
        self._measured, self.tables = made.measured, made.tables
        followed, _ = made.tables.get("contours", NOTHING)
        if followed is not None:
            self._found |= {page.number: page for page in followed.pages if page.number != self.number}
        self.found.emit()

    # Files

    def export(self, *paths: Path) -> None:
        """Write the results of all pages."""
        result, path = self.result, paths[0]
        if result is None:
            return
        self._session.attempt(EXPORTING)

        def write_stack(_: Task) -> Report:
            export_stack(result, *paths)
            return Exported(path, tr("{count} files", count=len(paths)) if len(paths) > 1 else "")

        self._session.tasks.start(
            tr("Writing {name}…", name=path.name), write_stack, tr("writing {name}", name=path.name)
        )

    def _plain(self) -> JsonObject:
        """Return the other pages as stored in a session."""
        if not self.count:
            return {}
        others = {number: page for number, page in self._kept.items() if number != self.number}
        given = not self.is_drawn(self._session.document)
        followed, _ = self.tables.get("contours", NOTHING)
        return PlainPages(partial(pages_to_plain, others, self.following, self._drawn, given, followed))

    def _begin_stack(self, opened: Opened) -> None:
        """Begin the pages of another file, perhaps from a session that contains them."""
        self.cancel()
        parts = opened.parts if opened.image.ndim == 2 else None
        source = self.source = StackSource.of(str(opened.path), parts, opened.reading)
        self.number = self.ahead = source.number_of(opened.reading)
        self._kept, self._found, self._given = {}, {}, ()
        self.tables, self._measured, self._seen, self._drawn = {}, {}, None, ()
        if opened.saved is not None and opened.saved.file.pages and self.count:
            stored = StoredPages.of(opened.saved.file.pages, self._session.document, source)
            self._kept, self.following, self._drawn = stored.kept, stored.following, stored.drawn
            self._found, self._given = stored.found, stored.given
            if stored.error:
                self._session.say(stored.error, True, OPENING)
            self._link_soon()
        self.found.emit()
