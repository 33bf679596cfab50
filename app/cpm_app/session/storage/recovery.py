"""Recovery: unsaved work in a small journal file, which is removed when the program ends normally.

Each window has a journal of its own, with a lock next to it that ends with the process, even after a crash. At the next
start the program offers the journals whose processes have ended; each is deleted only once it is restored or declined.
"""

from __future__ import annotations

import json
import uuid
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QLockFile, QObject, QTimer, Signal

from cpm_app.model.preferences.table import AUTOSAVE_PREFERENCE
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import SavedSession
from cpm_app.session.exchange.messages import explain_failure as _sentence
from cpm_app.session.storage.preferences import Preferences, open_settings
from cpm_app.session.storage.session_file import DocumentFile
from cpm_app.session.tasks.opening import OpenRequest
from cpm_core.formats import SESSION_SUFFIX, SessionFile, load_session, remove_abandoned_drafts, save_session
from cpm_core.formats.sessions.session_file import decode_session
from cpm_core.numerics.types import record
from cpm_core.shapes import Start

JOURNAL_KEY = "journal"
"""Key under which a journal, which is a session file, names the file and the work that it belongs to."""

UNREADABLE_SUFFIX = ".unreadable"
"""Suffix of journals that cannot be read."""

_WRITE_DELAY = 2000
"""Time from a change until it is written, together with all changes in between [ms]."""


def journals_folder() -> Path:
    """Return the user's folder of journals, next to the preferences."""
    return Path(open_settings().fileName()).parent / "journals"


def journal_lock(journal: Path) -> QLockFile:
    """Return the lock of a journal, which lasts as long as the process that has taken it."""
    lock = QLockFile(str(journal.with_suffix(".lock")))
    lock.setStaleLockTime(0)  # a lock is never stale by age, because a window may stay open for long
    return lock


class Journal(QObject):
    """Writes the journal of a document on a separate thread whenever the document changes."""

    write_ended = Signal(str)
    """The journal has been written or removed; an error message if that has failed, else ""."""
    _write_ended_on_thread = Signal(str)
    """Like `write_ended`, but sent by the thread that writes."""

    def __init__(self, document_file: DocumentFile, folder: Path, preferences: Preferences) -> None:
        super().__init__(document_file)
        self._document_file = document_file
        self.path = folder / f"{uuid.uuid4().hex}{SESSION_SUFFIX}"
        self._lock = journal_lock(self.path)
        self._writer: ThreadPoolExecutor | None = None
        self._last: Future[str] | None = None
        self._closed = False
        self._timer = QTimer(self, singleShot=True, interval=_WRITE_DELAY)
        self._timer.timeout.connect(self.write)
        self._preferences = preferences
        self._write_ended_on_thread.connect(self.write_ended)
        preferences.call_on_change(AUTOSAVE_PREFERENCE, self._write_soon)
        document_file.edited.connect(self._write_soon)
        document_file.changed.connect(self._write_soon)

    def write(self) -> None:
        """Start to write the unsaved work, or remove the journal when all is saved."""
        self._timer.stop()
        file = None
        if self._document_file.unsaved and self._preferences.read_preference(AUTOSAVE_PREFERENCE):
            kept, path = self._document_file.content, self._document_file.path
            named = {"session": str(path.absolute()) if path else "", "name": self._document_file.name}
            file = replace(kept, extra={**kept.extra, JOURNAL_KEY: named})
        if self._writer is None and file is not None:
            self._writer = ThreadPoolExecutor(1, "cpm-journal")
        if self._writer is not None:
            self._last = self._writer.submit(self._write_journal, file)

    def flush(self) -> bool:
        """Wait until everything is on disk; return False if that is not possible."""
        return self._last is not None and not self._last.result()

    def close(self) -> None:
        """Remove the journal, because the program ends normally."""
        self._closed = True
        self._timer.stop()
        if self._writer is not None:
            self._writer.submit(self._write_journal, None)
            self._writer.shutdown()
            self._writer = None
            self._lock.unlock()

    def _write_soon(self) -> None:
        if not (self._closed or self._timer.isActive()) and (self._document_file.unsaved or self._writer is not None):
            self._timer.start()

    def _write_journal(self, file: SessionFile | None) -> str:
        """Write or remove the journal; return the error message, or ""."""
        trouble = ""
        try:
            if file is None:
                self.path.unlink(missing_ok=True)
            else:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                if not (self._lock.isLocked() or self._lock.tryLock(0)):
                    raise ValueError(tr("{folder} is not writable.", folder=self.path.parent))
                save_session(file, self.path)
        except Exception as error:  # the user can still work without a journal
            if file is not None:
                reason = _sentence(error, tr("keeping unsaved work"))
                trouble = tr(
                    "Unsaved work cannot be protected against a crash: save the session yourself. {reason}",
                    reason=reason,
                )
        self._write_ended_on_thread.emit(trouble)
        return trouble


@record
class Leftover:
    """A journal whose process has ended; while its lock is held, no other window offers it.

    `path` is the session file that it belongs to, None if it had never been saved.
    """

    journal: Path
    name: str
    path: Path | None
    when: datetime
    file: SessionFile
    lock: QLockFile

    @property
    def open_request(self) -> OpenRequest:
        """The request to open it as unsaved work."""
        saved = SavedSession(self.path, self.file, recovered=True)
        note = tr("{name} was restored and is not saved yet.", name=self.name)
        return OpenRequest(self.path or Path(self.name), self.file.parameters, saved=saved, notes=(note,))

    def count_objects_and_shapes(self) -> tuple[int, int]:
        """Count the objects and the shapes on all pages of a stack; pages that are damaged count for nothing.

        Starts that a page was given by the previous one are not counted, as nobody has drawn them.
        """
        pages = [(self.file, self.file.pages.get("given"))]
        for page in self.file.pages.get("sessions", ()):
            with suppress(ValueError, TypeError, KeyError):
                pages.append((decode_session(json.dumps(page["session"]).encode(), self.name), page.get("given")))
        drawn = (shape for page, given in pages for shape in page.shapes if not (given and isinstance(shape, Start)))
        return sum(len(page.objects.items) for page, _ in pages), sum(1 for _ in drawn)

    def keep_for_later(self) -> None:
        """Leave the journal for another time."""
        self.lock.unlock()

    def discard(self) -> None:
        """Remove the journal."""
        with suppress(OSError):
            self.journal.unlink(missing_ok=True)
        self.lock.unlock()


def find_leftovers(folder: Path) -> tuple[list[Leftover], list[str]]:
    """Find the journals in a folder whose processes have ended, the newest first, and messages on unreadable ones.

    A damaged journal is set aside; one that only could not be read is left for the next start.
    """
    remove_abandoned_drafts(folder)
    found, troubles = [], []
    for journal in sorted(folder.glob(f"*{SESSION_SUFFIX}")):
        lock = journal_lock(journal)
        if not lock.tryLock(0):
            continue
        try:
            found.append(_read_journal(journal, lock))
        except (ValueError, OSError) as error:
            kept = journal
            if not isinstance(error, OSError) and not isinstance(error.__cause__, OSError):
                with suppress(OSError):
                    kept = journal.rename(journal.with_suffix(UNREADABLE_SUFFIX))
            troubles.append(
                tr(
                    "Unsaved work of an earlier session cannot be restored. {reason} It is kept as {path}.",
                    reason=_sentence(error, tr("reading unsaved work")),
                    path=kept,
                )
            )
            lock.unlock()
    return sorted(found, key=lambda leftover: leftover.when, reverse=True), troubles


def _read_journal(journal: Path, lock: QLockFile) -> Leftover:
    file, when = load_session(journal), datetime.fromtimestamp(journal.stat().st_mtime)
    named = file.extra.get(JOURNAL_KEY)
    if file.image is None or not isinstance(named, dict):
        raise ValueError(tr("{name} is not a recovery file.", name=journal.name))
    path, name = str(named.get("session") or ""), str(named.get("name") or journal.name)
    bare = replace(file, extra={key: value for key, value in file.extra.items() if key != JOURNAL_KEY})
    return Leftover(journal, name, Path(path) if path else None, when, bare, lock)
