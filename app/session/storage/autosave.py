"""Autosave: unsaved work in a small journal file, which is removed when the program ends normally."""

from __future__ import annotations

import logging
import uuid
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QLockFile, QObject, QSettings, QTimer, Signal

from app.model.preferences.table import AUTOSAVE, AUTOSAVE_EVERY
from app.model.text.language import cause, tr
from app.session.exchange.messages import sentence
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

    put = Signal(str)
    """The journal has been written or removed: nothing, or else a sentence on why it has not."""
    _worked = Signal(str)
    """The same, sent by the thread that writes."""

    def __init__(self, document_file: DocumentFile, folder: Path, preferences: Preferences) -> None:
        super().__init__(document_file)
        self._document_file = document_file
        self.path = folder / f"{uuid.uuid4().hex}{SUFFIX}"
        self._lock = lock_of(self.path)
        self._writer: ThreadPoolExecutor | None = None
        self._last: Future[str] | None = None
        self._closed = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self.write)
        self._preferences = preferences
        self._worked.connect(self._announce)
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

    def flush(self) -> bool:
        """Wait until everything is on disk; False when it cannot be."""
        return self._last is not None and not self._last.result()

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
        self._last = self._writer.submit(self._put, file)

    def _prepare(self) -> bool:
        """Create the folder and take the lock."""
        folder = self.path.parent
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self.put.emit(_in_vain(f"{folder}: {cause(error)}."))
            return False
        if not self._lock.tryLock(0):
            self.put.emit(_in_vain(tr("Nothing can be written into {folder}.").format(folder=folder)))
            return False
        return True

    def _put(self, file: SessionFile | None) -> str:
        """Write or remove the journal; what that failed with."""
        trouble = ""
        try:
            if file is None:
                self.path.unlink(missing_ok=True)
            else:
                save_session(file, self.path)
        except OSError as error:
            _log.warning("the journal was not removed: %s", error)
        except Exception as error:  # the user can still work without a journal
            trouble = _in_vain(sentence(error, tr("keeping unsaved work")))
        self._worked.emit(trouble)
        return trouble

    def _announce(self, trouble: str) -> None:
        self.put.emit(trouble)


def lock_of(journal: Path) -> QLockFile:
    """The lock of a journal, which lasts as long as the process that has taken it."""
    lock = QLockFile(str(journal.with_suffix(".lock")))
    lock.setStaleLockTime(0)  # a lock is never stale by age, because a window may stay open for long
    return lock


def _in_vain(reason: str) -> str:
    return tr("Unsaved work is not kept for the case of a crash: save the session yourself. {reason}").format(
        reason=reason
    )
