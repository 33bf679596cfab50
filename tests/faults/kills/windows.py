"""A window that is killed while it saves: files are whole, and the next window has the work."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

from cpm_app.model.document import edits
from cpm_app.views.application import make_application
from cpm_app.views.features.files import OpenSaveFeature, RecoveryFeature
from cpm_app.views.main_window import open_window
from cpm_app.views.window import dialogs
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QCoreApplication, QSettings

from cpm_core.formats.sessions.session_file import load_session
from cpm_core.shapes import Circle

from ..clock import now
from .command_line import Kill, age, drafts, draw_images
from .nursery import outcome

_CIRCLES, _SAVED_EVERY = 6, 3
_PATIENCE = 60.0
_KEY = "kills/number"


def work(folder: Path) -> None:
    """Draw circles, each of which is in the journal before the next, and save now and then."""
    window = opened(folder)
    document_file, journal = (
        window.get_feature(OpenSaveFeature).document_file,
        window.get_feature(RecoveryFeature).journal,
    )
    assert journal is not None
    noted = os.open(folder / "noted", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for number in range(1, _CIRCLES + 1):
        circle = Circle((20.0, 20.0), 2.0 + number)
        window.session.edit("draw", lambda document, circle=circle: edits.add_shape(document, circle))  # type: ignore[misc]
        journal.write()
        journal.flush()
        window.preferences.store_key(_KEY, number)
        window.preferences.flush()
        os.write(noted, b"%d " % number)
        if number % _SAVED_EVERY == 0:
            document_file.save(folder / "work.cpm")
            until(lambda: not document_file.unsaved)
            journal.write()
            journal.flush()


def next_start(folder: Path) -> tuple[int, int]:
    """Open a window as after a crash and restore what it offers: the circles that it has then, and the preference."""
    window = opened(folder)
    box = window.get_feature(RecoveryFeature).box
    if box is not None:
        next(button for button in box.buttons() if "Restore" in button.text().replace("&", "")).click()
        until(lambda: bool(window.session.document.shapes) and window.session.idle)
    found, stored = len(window.session.document.shapes), window.preferences.read_key(_KEY, 0)
    window.close()
    return found, stored


def opened(folder: Path) -> MainWindow:
    """A window on an image of the folder, with all its own files there."""
    os.environ |= {name: str(folder / "home") for name in ("HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME")}
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(folder / "preferences"))
    dialogs.ask_about_unsaved = lambda parent, name, lost: "discard"
    make_application()
    window = open_window(str(folder / "0.npy"))
    window.session.set_pace(None)
    until(lambda: window.session.document.image is not None and window.session.idle)
    return window


def until(condition: Callable[[], bool]) -> None:
    began = now()
    while not condition():
        assert now() - began < _PATIENCE, "the window does not go on"
        QCoreApplication.processEvents()
        time.sleep(0.002)


class Windows:
    """Windows with unsaved work."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        draw_images(folder)
        self._clear()
        self.operations = outcome(folder, work, folder).operations

    def trial(self, kill: Kill) -> None:
        """Kill a window, and open the next."""
        self._clear()
        kill(self._folder, work, self._folder)
        noted = self._folder / "noted"
        last = int((noted.read_text().split() or ["0"])[-1]) if noted.exists() else 0
        saved = self._folder / "work.cpm"
        in_file = len(load_session(saved).shapes) if saved.exists() else 0
        assert in_file % _SAVED_EVERY == 0, "the session file holds what was never saved"
        journals = self._folder / "preferences" / "cpm" / "journals"
        age(drafts(journals))
        restored, stored = outcome(self._folder, next_start, self._folder).value
        assert last <= max(in_file, restored) <= last + 1, f"of {last} circles {restored} are restored"
        assert last <= stored <= last + 1, f"the preference is {stored} and was {last}"
        assert not journals.exists() or not list(journals.iterdir()), "something stays among the journals for ever"

    def _clear(self) -> None:
        for name in ("preferences", "home"):
            shutil.rmtree(self._folder / name, ignore_errors=True)
        for path in (self._folder / "noted", self._folder / "work.cpm", *drafts(self._folder)):
            path.unlink(missing_ok=True)
