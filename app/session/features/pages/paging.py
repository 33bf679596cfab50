"""Paging: which page of a stack is open, and what is kept of the others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from app.model.document.document import Document
from app.model.document.saving import to_file
from app.session.exchange.messages import Opened, Saved
from app.session.features.pages.kept_page import KeptPage, bare, started_by, starts_along
from app.session.features.pages.linking import Found
from app.session.features.pages.stack_source import StackSource
from app.session.session import Session
from app.session.storage.session_file import DocumentFile, Written
from app.session.tasks.opening import Wanted
from cpm_core.contours.result import Result
from cpm_core.formats.sessions.session_file import ImageFile
from cpm_core.pages.page import starts_after
from cpm_core.shapes import Start


class Paging(QObject):
    """Goes through the pages of a stack, each with its own document, history and runs."""

    changed = Signal()
    """Another page is open, or pages are being run, or no longer."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.following = True
        """Whether each page starts from the contours of the one before."""
        self._session = session
        self._file: DocumentFile | None = None
        self._source = StackSource()
        self._ahead = 0
        self._turning = False
        self._kept: dict[int, KeptPage] = {}
        self._coming: dict[int, KeptPage] = {}
        self._found: dict[int, Found] = {}
        self._given: tuple[Start, ...] = ()
        session.listen(Opened, self._take_opened)
        session.listen(Written, self._take_written)

    def keep(self, document_file: DocumentFile) -> None:
        """Be saved with the session file."""
        self._file = document_file

    @property
    def count(self) -> int:
        """Number of pages of the stack; 0 where none is open as pages."""
        return self._source.count

    @property
    def number(self) -> int:
        """The page that is open, from 1."""
        return self._source.number

    @property
    def ahead(self) -> int:
        """The page that is wanted, which is open or being opened."""
        return self._ahead

    def is_drawn(self, document: Document) -> bool:
        """Whether a person has drawn where the run of the open page starts, not the page before."""
        return not self._given or document.starts != self._given

    def go(self, by: int) -> None:
        """Go to a page after this one, or before it; beyond a page that could not be opened."""
        self.open(min(max(self._ahead + by, 1), self.count))

    def open(self, number: int) -> None:
        """Go to a page, once the runs of this one have been collected."""
        if self._file is None or not 1 <= number <= self.count or number == self._ahead:
            return
        self._ahead = number
        if not self._turning:
            self._turning = True
            self._session.pause()
            self._file.runs.collect(lambda _: self._turn())

    def _turn(self) -> None:
        """Keep the page that is open, and open the one that is wanted."""
        self._turning = False
        if self._file is None or not self.count or self._ahead == self.number:
            return
        here = self._kept[self.number] = self._here(self._file)
        self._begin(self._ahead, self._kept.get(self._ahead) or self._fresh(here))

    def _begin(self, number: int, page: KeptPage) -> None:
        """Open a page with what is kept of it; the image stays where it is on the canvas."""
        image = self._session.document.image
        if image is None or self._file is None:
            return
        place = ImageFile(image.path, "", image.shape, reading=self._source.reading_of(number))
        content = replace(page.seen(self._file.file.view), image=place)
        self._coming[number] = page
        saved = Saved(self._file.path, content, turned=True, known=page.known)
        self._session.begin(Wanted(Path(image.path), page.document.parameters, saved=saved))

    def _here(self, file: DocumentFile) -> KeptPage:
        """The page that is open, as it is kept."""
        session, content = self._session, replace(file.file, pages={}, truth=None)
        return KeptPage(content, session.document, session.history, file.known, self._given, file.runs.unsaved)

    def _fresh(self, here: KeptPage) -> KeptPage:
        """A page on which nothing has been done yet: it takes over the drawing, or follows the page before."""
        document, given = bare(here.document), here.given or here.document.starts
        before = self._found.get(self._ahead - 1)
        if self.following and isinstance(before, Result) and before.contours:
            given = starts_along(starts_after(before.contours))
            document = started_by(document, given)
        return KeptPage(to_file(document, {}), document, known=document, given=given)

    def _take_opened(self, opened: Opened) -> None:
        """Another page has been opened, or another file."""
        parts = opened.parts if opened.image.ndim == 2 else None
        source = StackSource.of(str(opened.path), opened.path.name, parts, opened.reading)
        if opened.saved is not None and opened.saved.turned:
            # another page may be wanted by now: what is kept of this one stays until it is left by way of `_turn`
            page = self._coming.pop(source.number, None)
            self._source = source.of_the_same(self._source)
            if page is not None:
                self._given = page.given
                self._session.use_history(page.history.on(self._session.document.image))
        else:
            self._begin_stack(source, opened)
        self.changed.emit()

    def _begin_stack(self, source: StackSource, _opened: Opened) -> None:
        """Another file has been opened: nothing is known of its pages."""
        self._source, self._ahead = source, source.number
        self._kept, self._coming, self._found, self._given = {}, {}, {}, ()

    def _take_written(self, written: Written) -> None:
        if self._file is not None and self._file.is_current(written):
            self._kept = {number: page.saved() for number, page in self._kept.items()}
