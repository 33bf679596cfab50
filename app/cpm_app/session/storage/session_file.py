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
from cpm_app.session.exchange.messages import CommandFailed, Opened, Report
from cpm_app.session.session import Session
from cpm_app.session.signals import SAVING
from cpm_app.session.storage.run_keeping import RunKeeping
from cpm_app.session.tasks.tasks import OVER, Task
from cpm_core.formats import SESSION_SUFFIX, SessionFile, TruthFile, save_session
from cpm_core.numerics.types import JsonObject, Texts, record

_MAX_RUNS_WAIT = 10.0
"""Longest time that saving waits for the worker to finish its step; then the last collected runs are used [s]."""


@record
class Written(Report):
    """A session file has been written: its content, the number of the opened image, and the edition of its runs."""

    path: Path
    file: SessionFile
    document: Document
    opening: int
    edition: int


class DocumentFile(QObject):
    """The session file of the open image; `view` returns the view settings as plain JSON."""

    changed = Signal()
    """The file or its state, saved or unsaved, has changed."""
    edited = Signal()
    """The content to be saved may have changed."""
    restored = Signal(object)
    """A session has been opened: its view settings, as plain JSON."""

    def __init__(self, session: Session, view: Callable[[], View]) -> None:
        super().__init__(session)
        self._session = session
        self._view = view
        self._file: SessionFile | None = None
        self.known: Document | None = session.document
        """The document if the file contains it; None if the file has a different one."""
        self.runs = RunKeeping(session)
        self.truth: Callable[[], TruthFile | None] = lambda: None
        """Returns the ground truth to be saved; set by the window."""
        self.pages: Callable[[], JsonObject] = dict
        """Returns the other pages of a stack, as plain JSON; set by `StackPages`."""
        self.pages_unsaved: Callable[[], bool] = lambda: False
        """Returns whether closing would lose changes on other pages; set by `StackPages`."""
        self._saving = OVER
        self._opening = 0
        self._written: dict[Task, Written] = {}
        """Files that have been written but not announced yet."""
        self._announced: tuple[Path | None, bool] = (None, False)
        self.path: Path | None = None
        session.document_changed.connect(lambda _: self._announce())
        self.runs.changed.connect(self._announce)
        session.listen(Opened, self._use_opened)
        session.listen(Written, self._use_written)

    @property
    def unsaved(self) -> bool:
        """Whether closing would lose changes."""
        return bool(self.lost)

    @property
    def lost(self) -> Texts:
        """Names of everything that closing would lose."""
        document = self._session.document
        if document.image is None:
            return ()
        others = ((self.runs.unsaved, tr("the runs")), (self.pages_unsaved(), tr("the other pages")))
        return (*describe_changes(document, self.known), *(words for lost, words in others if lost))

    @property
    def name(self) -> str:
        """Name of the file, or of the one that would be written."""
        image = self._session.document.image
        return self.path.name if self.path else f"{Path(image.name).stem}{SESSION_SUFFIX}" if image else ""

    @property
    def file(self) -> SessionFile:
        """The content to be saved."""
        written = to_session_file(self._session.document, self._view(), self._file)
        return replace(written, runs=self.runs.plain, truth=self.truth(), pages=self.pages())

    def save(self, path: Path) -> Task:
        """Write the session file on a separate thread, and use this path from now on."""
        file, document, opening = self.file, self._session.document, self._opening
        runs, before = self.runs.collect(), self._saving
        self._session.attempt(SAVING)

        def write_file(task: Task) -> Task:
            before.wait()  # one file is written at a time
            whole, edition = file, -1
            with suppress(TimeoutError):
                found = runs.result(_MAX_RUNS_WAIT)
                whole, edition = replace(file, runs=found.plain), found.edition
            save_session(whole, path)
            self._written[task] = Written(path, whole, document, opening, edition)
            return task

        self._saving = self._session.tasks.start(
            tr("Saving {name}…", name=path.name),
            write_file,
            tr("saving {name}", name=path.name),
            partial(CommandFailed, topic=SAVING),
            cancellable=False,
            then=self._announce_written,
        )
        return self._saving

    def finish(self) -> None:
        """Wait for all files being saved, which closing must not overtake."""
        self._saving.wait()
        for task in tuple(self._written):
            self._announce_written(task)

    def save_at_once(self, path: Path) -> bool:
        """Write the session file and wait for it; return False, with an error message shown, if that fails."""
        task = self.save(path)
        task.wait()
        done = task in self._written
        self.finish()
        return done

    def _announce_written(self, task: Task) -> None:
        if task in self._written:
            self._session.pass_on(self._written.pop(task))

    def forget(self) -> None:
        """Treat the document as saved."""
        self.known = self._session.document
        self.runs.forget()
        self._announce()

    def _use_opened(self, opened: Opened) -> None:
        self._opening += 1
        saved = opened.saved
        self.path, self._file = (saved.path, saved.file) if saved else (None, None)
        self.known = self._session.document
        if saved is not None and (saved.recovered or saved.turned):
            self.known = saved.known and replace(saved.known, image=self._session.document.image)
        if saved is not None:
            self.restored.emit(saved.file.view)
        self._announce()

    def is_current(self, written: Written) -> bool:
        """Return whether a written file belongs to the open image."""
        return written.opening == self._opening

    def _use_written(self, written: Written) -> None:
        if self.is_current(written):
            self.path, self._file, self.known = written.path, written.file, written.document
            self.runs.saved(written.edition)
        self._session.say(tr("Saved: {path}", path=written.path), topic=SAVING)
        self._announce()

    def _announce(self) -> None:
        self.edited.emit()
        now = (self.path, self.unsaved)
        if now != self._announced:
            self._announced = now
            self.changed.emit()
