"""Recovery: journals of processes that did not end normally."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QLockFile

from app.model.text.language import tr
from app.session.exchange.messages import Saved
from app.session.storage.autosave import KEY, lock_of
from app.session.tasks.opening import Wanted
from cpm_core.formats.atomic import remove_abandoned
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile, load_session

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False, slots=True)
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
    def wanted(self) -> Wanted:
        """The request to open it as unsaved work."""
        saved = Saved(self.path, self.file, recovered=True)
        note = tr("{name} was restored and is not saved yet.").format(name=self.name)
        return Wanted(self.path or Path(self.name), self.file.parameters, saved=saved, notes=(note,))

    def keep(self) -> None:
        """Leave it for another time."""
        self.lock.unlock()

    def discard(self) -> None:
        """Remove it."""
        with suppress(OSError):
            self.journal.unlink(missing_ok=True)
        self.lock.unlock()


def left_behind(folder: Path) -> Sequence[Leftover]:
    """Journals in a folder whose processes have ended, the newest first; damaged ones are removed."""
    _clear(folder)
    found = []
    for journal in sorted(folder.glob(f"*{SUFFIX}")):
        lock = lock_of(journal)
        if lock.tryLock(0):
            leftover = _read(journal, lock)
            if leftover is not None:
                found.append(leftover)
    return sorted(found, key=lambda leftover: leftover.when, reverse=True)


def _clear(folder: Path) -> None:
    """Remove what killed processes have left that holds no work: drafts, and locks of journals that are not there."""
    remove_abandoned(folder)
    for path in folder.glob("*.lock"):
        journal = path.with_suffix(SUFFIX)
        lock = lock_of(journal)
        if not journal.exists() and lock.tryLock(0):  # one that nobody holds
            lock.unlock()


def _read(journal: Path, lock: QLockFile) -> Leftover | None:
    try:
        file, when = load_session(journal), datetime.fromtimestamp(journal.stat().st_mtime)
        named = file.extra.get(KEY)
        if file.image is None or not isinstance(named, dict):
            raise ValueError(f"{journal.name} is not a journal.")
    except (ValueError, OSError) as error:
        _log.warning("a journal cannot be used: %s", error)
        with suppress(OSError):
            journal.unlink(missing_ok=True)
        lock.unlock()
        return None
    path, name = str(named.get("session") or ""), str(named.get("name") or journal.name)
    bare = replace(file, extra={key: value for key, value in file.extra.items() if key != KEY})
    return Leftover(journal, name, Path(path) if path else None, when, bare, lock)
