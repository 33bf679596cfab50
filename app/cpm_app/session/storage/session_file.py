"""The session file of a document: its path, whether it is up to date, and saving."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from cpm_app.model.document.document import Document
from cpm_app.model.document.saving import View, describe_changes, to_session_file
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import CommandFailed, ImageOpened, Report
from cpm_app.session.session import Session
from cpm_app.session.session_messages import SAVING_CATEGORY
from cpm_app.session.storage.run_collector import RunCollector
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core.formats import SESSION_SUFFIX, SessionFile, TruthFile, save_session
from cpm_core.numerics.types import JsonObject, Texts, record

_MAX_RUNS_WAIT = 10.0
"""Longest time that saving waits for the worker to finish its step; then the last collected runs are used [s]."""


@record
class SessionWritten(Report):
    """A session file has been written: its content, the number of the opened image, and the edition of its runs.

    If it was `automatic`, the user has not asked for it, and is not told.
    """

    path: Path
    file: SessionFile
    document: Document
    opening: int
    edition: int
    automatic: bool = False


class DocumentFile(QObject):
    """The session file of the open image.

    Parameters
    ----------
    session : Session
        The session.
    view : callable
        Returns the view settings, as plain JSON.
    truth : callable
        Returns the ground truth to be saved.
    pages : callable
        Returns the other pages of a stack, as plain JSON.
    has_unsaved_pages : callable
        Returns whether closing would lose changes on other pages.
    """

    changed = Signal()
    """The file or its state, saved or unsaved, has changed."""
    edited = Signal()
    """The content to be saved may have changed."""
    restored = Signal(object)
    """A session has been opened: its view settings, as plain JSON."""

    def __init__(
        self,
        session: Session,
        view: Callable[[], View],
        truth: Callable[[], TruthFile | None] = lambda: None,
        pages: Callable[[], JsonObject] = dict,
        has_unsaved_pages: Callable[[], bool] = lambda: False,
    ) -> None:
        super().__init__(session)
        self._session = session
        self._view, self._truth, self._pages, self._has_unsaved_pages = view, truth, pages, has_unsaved_pages
        self._file: SessionFile | None = None
        self.saved_document: Document | None = session.document
        """The document if the file contains it; None if the file has a different one."""
        self.runs = RunCollector(session)
        self._saving = ENDED_TASK
        self._opening = 0
        self._written: dict[BackgroundTask, SessionWritten] = {}
        """Files that have been written but not announced yet."""
        self._announced: tuple[Path | None, bool] = (None, False)
        self.path: Path | None = None
        session.image_changed.connect(self._on_image_changed)
        session.document_changed.connect(lambda _: self._announce_state())
        self.runs.changed.connect(self._announce_state)
        session.store.add_listener(ImageOpened, self._on_image_opened)
        session.store.add_listener(SessionWritten, self._on_session_written)

    @property
    def unsaved(self) -> bool:
        """Whether closing would lose changes."""
        return bool(self.unsaved_parts)

    @property
    def unsaved_parts(self) -> Texts:
        """Names of everything that closing would lose."""
        document = self._session.document
        if document.image is None:
            return ()
        others = ((self.runs.unsaved, tr("the runs")), (self._has_unsaved_pages(), tr("the other pages")))
        return (*describe_changes(document, self.saved_document), *(words for lost, words in others if lost))

    @property
    def name(self) -> str:
        """Name of the file, or of the one that would be written."""
        image = self._session.document.image
        return self.path.name if self.path else f"{Path(image.name).stem}{SESSION_SUFFIX}" if image else ""

    @property
    def content(self) -> SessionFile:
        """The content to be saved."""
        written = to_session_file(self._session.document, self._view(), self._file)
        return replace(written, runs=self.runs.runs_json, truth=self._truth(), pages=self._pages())

    def save(self, path: Path, automatic: bool = False) -> BackgroundTask:
        """Write the session file on a separate thread, and use this path from now on; see `SessionWritten`."""
        file, document, opening = self.content, self._session.document, self._opening
        runs, before = self.runs.collect_runs(), self._saving
        self._session.messages.clear(SAVING_CATEGORY)

        def write_file(task: BackgroundTask) -> BackgroundTask:
            before.wait()  # one file is written at a time
            whole, edition = file, -1
            with suppress(TimeoutError):
                found = runs.result(_MAX_RUNS_WAIT)
                whole, edition = replace(file, runs=found.plain), found.edition
            save_session(whole, path)
            self._written[task] = SessionWritten(path, whole, document, opening, edition, automatic)
            return task

        self._saving = self._session.tasks.start_task(
            tr("Saving {name}…", name=path.name),
            write_file,
            tr("saving {name}", name=path.name),
            partial(CommandFailed, category=SAVING_CATEGORY),
            cancellable=False,
            on_result=self._announce_written,
        )
        return self._saving

    def finish_saving(self) -> None:
        """Wait for all files being saved, which closing must not overtake."""
        self._saving.wait()
        for task in tuple(self._written):
            self._announce_written(task)

    def save_and_wait(self, path: Path, automatic: bool = False) -> bool:
        """Write the session file and wait for it; return False, with an error message shown, if that fails."""
        task = self.save(path, automatic)
        task.wait()
        done = task in self._written
        self.finish_saving()
        return done

    def _announce_written(self, task: BackgroundTask) -> None:
        if task in self._written:
            self._session.store.dispatch_report(self._written.pop(task))

    def _on_image_changed(self) -> None:
        """Treat the document that an image begins with as saved, until `_on_image_opened` knows its file."""
        self.saved_document = self._session.document

    def _on_image_opened(self, opened: ImageOpened) -> None:
        self._opening += 1
        saved = opened.saved
        self.path, self._file = (saved.path, saved.file) if saved else (None, None)
        if saved is not None and (saved.recovered or saved.is_other_page):
            self.saved_document = saved.saved_document and replace(
                saved.saved_document, image=self._session.document.image
            )
        if saved is not None:
            self.restored.emit(saved.file.view)
        self._announce_state()

    def is_current(self, written: SessionWritten) -> bool:
        """Return whether a written file belongs to the open image."""
        return written.opening == self._opening

    def _on_session_written(self, written: SessionWritten) -> None:
        if self.is_current(written):
            self.path, self._file, self.saved_document = written.path, written.file, written.document
            self.runs.mark_saved(written.edition)
        if not written.automatic:
            self._session.messages.show(tr("Saved: {path}", path=written.path), category=SAVING_CATEGORY)
        self._announce_state()

    def _announce_state(self) -> None:
        self.edited.emit()
        now = (self.path, self.unsaved)
        if now != self._announced:
            self._announced = now
            self.changed.emit()
