"""Autosave: unsaved work in a small journal file, which is removed when the program ends normally."""

from __future__ import annotations

import logging
import uuid
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QLockFile, QObject, QSettings, QTimer

from app.model.preferences.table import AUTOSAVE, AUTOSAVE_EVERY
from app.session.storage.preferences import Preferences
from app.session.storage.session_file import DocumentFile
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile, save_session

KEY = "journal"
"""Key under which a journal, otherwise a session file, names the file and the work that it belongs to."""

_log = logging.getLogger(__name__)


def folder_of_journals() -> Path:
    """The user's folder of journals, beside the preferences."""
    settings = QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, "cpm", "cpm")
    return Path(settings.fileName()).parent / "journals"


class Journal(QObject):
    """Follows a document and writes its journal, on a separate thread.

    Each window has its own journal, with a lock beside it that ends with the process, even after a crash.
    """

    def __init__(self, document_file: DocumentFile, folder: Path, preferences: Preferences) -> None:
        super().__init__(document_file)
        self._document_file = document_file
        self.path = folder / f"{uuid.uuid4().hex}{SUFFIX}"
        self._lock = lock_of(self.path)
        self._writer: ThreadPoolExecutor | None = None
        self._last: Future[None] | None = None
        self._closed = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self.write)
        self._preferences = preferences
        preferences.follow(AUTOSAVE_EVERY, self._use_interval)
        preferences.follow(AUTOSAVE, self._plan)
        document_file.edited.connect(self._plan)
        document_file.changed.connect(self._plan)

    def write(self) -> None:
        """Start to write the unsaved work, or remove the journal when all is saved."""
        self._timer.stop()
        if not self._document_file.unsaved or not self._preferences.value(AUTOSAVE):
            self._submit(None)
            return
        kept, path = self._document_file.file, self._document_file.path
        named = {"session": str(path.absolute()) if path else "", "name": self._document_file.name}
        self._submit(replace(kept, extra={**kept.extra, KEY: named}))

    def flush(self) -> None:
        """Wait until everything is on disk."""
        if self._last is not None:
            self._last.result()

    def close(self) -> None:
        """Remove the journal: the program ends normally."""
        self._closed = True
        self._timer.stop()
        if self._writer is not None:
            self._submit(None)
            self._writer.shutdown()
            self._writer = None
            self._lock.unlock()

    def _use_interval(self) -> None:
        """Take over the time from a change until it is written, with further changes in between."""
        self._timer.setInterval(round(1000 * self._preferences.value(AUTOSAVE_EVERY)))

    def _plan(self) -> None:
        if not (self._closed or self._timer.isActive()) and (self._document_file.unsaved or self._writer is not None):
            self._timer.start()

    def _submit(self, file: SessionFile | None) -> None:
        if self._writer is None:
            if file is None or not self._prepare():
                return
            self._writer = ThreadPoolExecutor(1, "cpm-journal")
        self._last = self._writer.submit(_put, self.path, file)

    def _prepare(self) -> bool:
        """Create the folder and take the lock."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            _log.warning("no journal can be kept in %s: %s", self.path.parent, error)
            return False
        return self._lock.tryLock(0)


def lock_of(journal: Path) -> QLockFile:
    """The lock of a journal, which lasts as long as the process that has taken it."""
    lock = QLockFile(str(journal.with_suffix(".lock")))
    lock.setStaleLockTime(0)  # a lock is never stale by age, because a window may stay open for long
    return lock


def _put(path: Path, file: SessionFile | None) -> None:
    if file is None:
        with suppress(OSError):
            path.unlink(missing_ok=True)
        return
    try:
        save_session(file, path)
    except ValueError as error:  # the user can still work without a journal
        _log.warning("the journal was not written: %s", error)
