"""Windows of the tests: made, kept from one test to the next, and closed with all that belongs to them."""

from __future__ import annotations

import gc
import itertools
import threading
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QCoreApplication, QEvent, Qt
from pytestqt.qtbot import QtBot

from app.model.document.modes import use_mode
from app.session.session import Session
from app.session.workspace import Workspace
from app.views.application import make_application
from app.views.canvas.canvas_area import FIRST_TOOL
from app.views.main_window import MainWindow
from app.views.panels.item_table.view import ItemTable

SIZE = 1000, 700
"""Width and height of windows [px]."""

_sessions = itertools.count(1)
_COLLECTED_EVERY = 10
"""Number of sessions after which garbage is collected, which takes as long as to make one session."""


def new_window(qtbot: QtBot, workspace: Workspace) -> MainWindow:
    """A window without an image."""
    make_application()
    made = MainWindow(workspace)
    made.resize(*SIZE)
    made.show()
    qtbot.waitExposed(made)
    return made


def is_open(session: Session, path: Path) -> bool:
    """Whether this file is the image of the session."""
    image = session.document.image
    return image is not None and image.path == str(path) and not session.opening


def begin_anew(window: MainWindow) -> None:
    """Let a window be as at the beginning, but for what goes with the image when another one is opened."""
    for table in window.findChildren(ItemTable):
        table.sortByColumn(0, Qt.SortOrder.AscendingOrder)
    window.panels["contours"].shown.setCurrentIndex(0)
    window.docks.restore()
    for tool in window.canvas_area._tools.values():
        tool.used = False
    window.session.begin_document(use_mode(window.session.document, "shape"))
    window.actions_by_name[FIRST_TOOL].trigger()
    window.canvas_area.messages.clear()
    window.resize(*SIZE)
    window.activateWindow()
    window.canvas_area.canvas.leave()
    window.canvas_area.canvas.setFocus()


def close_window(window: MainWindow) -> None:
    """Close a window and let its widgets go now: every widget that exists slows down all others."""
    window.close()
    window.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    # The next window is built without a style sheet, as the first one of a process is, which takes a quarter less.
    make_application().setStyleSheet("")


def close_workspace(workspace: Workspace) -> None:
    """Stop a session, and let it go: its signals keep the window and the layers alive."""
    workspace.close()
    workspace.session.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    if next(_sessions) % _COLLECTED_EVERY == 0:
        gc.collect()


@dataclass
class Kept:
    """A window that is kept from one test to the next. To make one takes longer than most tests do."""

    workspace: Workspace | None = None
    window: MainWindow | None = None

    def close(self) -> None:
        """Close what is kept."""
        if self.window is not None:
            close_window(self.window)
        if self.workspace is not None:
            close_workspace(self.workspace)
        self.window = self.workspace = None


def fail_for_threads_since(threads: set[threading.Thread]) -> None:
    """Fail when a thread runs that was not among these."""
    left = [thread.name for thread in set(threading.enumerate()) - threads if thread.is_alive()]
    left = [name for name in left if not name.startswith(("cpm-share", "pytest_timeout"))]  # they last longer
    assert not left, f"threads left running: {left}"
