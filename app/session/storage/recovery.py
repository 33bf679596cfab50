"""Recovery: journals of processes that did not end normally.

A journal is deleted only after it has been read whole, and restored or declined. One that cannot be read is set aside.
"""

from __future__ import annotations

import itertools
import logging
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QLockFile

from app.model.text.language import tr
from app.session.exchange.messages import Saved
from app.session.exchange.messages import sentence as _sentence
from app.session.storage.autosave import KEY, lock_of
from app.session.tasks.opening import Wanted
from cpm_core.formats.common.atomic import remove_abandoned
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile, load_session

ASIDE = "set aside"
"""Folder for journals that cannot be read, beside the others."""

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


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """What earlier processes have left: journals, the newest first, and sentences on those that cannot be read."""

    leftovers: Sequence[Leftover]
    troubles: Sequence[str]


def left_behind(folder: Path) -> Found:
    """Journals in a folder whose processes have ended; those that cannot be read are set aside."""
    _clear(folder)
    found, troubles = [], []
    for journal in sorted(folder.glob(f"*{SUFFIX}")):
        lock = lock_of(journal)
        if not lock.tryLock(0):
            continue
        try:
            found.append(_read(journal, lock))
        except (ValueError, OSError) as error:
            troubles.append(_kept_apart(journal, error))
            lock.unlock()
    return Found(sorted(found, key=lambda leftover: leftover.when, reverse=True), troubles)


def _clear(folder: Path) -> None:
    """Remove what killed processes have left that holds no work: drafts, and locks of journals that are not there."""
    remove_abandoned(folder)
    for path in folder.glob("*.lock"):
        journal = path.with_suffix(SUFFIX)
        lock = lock_of(journal)
        if not journal.exists() and lock.tryLock(0):  # one that nobody holds
            lock.unlock()


def _kept_apart(journal: Path, error: Exception) -> str:
    """Set a journal aside that cannot be read, and say where it is; where only reading has failed, it stays."""
    reason = _sentence(error, tr("reading unsaved work"))
    kept = tr("Unsaved work of an earlier session cannot be restored. {reason} It is kept as {path}.")
    passing = isinstance(error, OSError) or isinstance(error.__cause__, OSError)
    if passing:
        kept = tr("Unsaved work of an earlier session cannot be read. {reason} It stays at {path} for the next start.")
    return kept.format(reason=reason, path=journal if passing else _set_aside(journal))


def _set_aside(journal: Path) -> Path:
    """Move a journal where it is not looked for, under a name that no other file has; its place then."""
    apart = journal.parent / ASIDE
    try:
        apart.mkdir(exist_ok=True)
        for number in itertools.count(1):
            place = apart / (journal.name if number == 1 else f"{journal.stem}-{number}{SUFFIX}")
            if not place.exists():
                return journal.rename(place)
    except OSError as error:
        _log.warning("%s stays where it is: %s", journal, error)
    return journal


def _read(journal: Path, lock: QLockFile) -> Leftover:
    file, when = load_session(journal), datetime.fromtimestamp(journal.stat().st_mtime)
    named = file.extra.get(KEY)
    if file.image is None or not isinstance(named, dict):
        raise ValueError(tr("{name} is not a journal.").format(name=journal.name))
    path, name = str(named.get("session") or ""), str(named.get("name") or journal.name)
    bare = replace(file, extra={key: value for key, value in file.extra.items() if key != KEY})
    return Leftover(journal, name, Path(path) if path else None, when, bare, lock)
