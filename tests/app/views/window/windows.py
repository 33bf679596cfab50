"""Windows of the tests: made, kept from one test to the next, and closed with all that belongs to them."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from cpm_app.model.document.modes import switch_mode
from cpm_app.model.preferences.table import ALL_PREFERENCES
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.session import Session
from cpm_app.views.application import make_application
from cpm_app.views.canvas.canvas_area import FIRST_TOOL
from cpm_app.views.features.files import StartFeature
from cpm_app.views.main_window import make_window
from cpm_app.views.tools.brush_tools import RingTool
from cpm_app.views.window import dialogs
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QCoreApplication, QEvent, Qt
from pytestqt.qtbot import QtBot

SIZE = 1000, 700
"""Width and height of windows [px]."""


def new_window(qtbot: QtBot, workspace: Workspace) -> MainWindow:
    """A window without an image."""
    make_application()
    made = make_window(workspace)
    made.resize(*SIZE)
    made.show()
    qtbot.waitExposed(made)
    return made


def is_open(session: Session, path: Path) -> bool:
    """Whether this file is the image of the session."""
    image = session.document.image
    return image is not None and image.path == str(path) and not session.opening_name


def begin_anew(window: MainWindow, views: dict[str, dict[str, object]]) -> None:
    """Let a window be as at the beginning, but for what goes with the image when another one is opened.

    The layers are shown as `views` says, by their names.
    """
    preferences = window.preferences
    for preference in ALL_PREFERENCES:
        preferences.store_preference(preference, preference.default)
    preferences._settings.clear()
    for layer in window.canvas_area.canvas.layers:
        if layer.view_state() != views[layer.name]:
            layer.use_view_state(views[layer.name])
    window.panels["objects"].table.sortByColumn(0, Qt.SortOrder.AscendingOrder)
    window.panels["objects"].shown.setCurrentIndex(0)
    window.docks.column.show()
    window.docks.bring_to_front("run")
    for tool in window.canvas_area._tools.values():
        tool.used = False
        if isinstance(tool, RingTool):
            tool._own_radius = None
    window.workspace.object_brush.set_radius(None)
    window.session.load_document(switch_mode(window.session.document, "shape"))
    window.actions_by_name[FIRST_TOOL].trigger()
    window.canvas_area.messages.clear()
    window.resize(*SIZE)
    window.activateWindow()
    window.canvas_area.canvas.remove_pointer()
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
    workspace.session.close()
    workspace.session.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


@dataclass
class Kept:
    """A window that is kept from one test to the next. To make one takes longer than most tests do."""

    workspace: Workspace | None = None
    window: MainWindow | None = None
    threads: set[threading.Thread] = field(default_factory=set)
    """Those that ran before the session was made."""
    views: dict[str, dict[str, object]] = field(default_factory=dict)
    """How the layers were shown at first, by their names."""

    spoiled: bool = False
    """Whether a test has failed in the window."""

    def keep(self, window: MainWindow) -> None:
        """Keep a window that has just been made."""
        self.window = window
        self.views = {layer.name: layer.view_state() for layer in window.canvas_area.canvas.layers}

    def close(self) -> None:
        """Close what is kept, without a question or a picture, and fail when a thread of it runs on."""
        window, workspace, self.window, self.workspace = self.window, self.workspace, None, None
        self.spoiled = False
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(dialogs, "ask_about_unsaved", lambda parent, name, lost: "discard")
            patch.setattr(StartFeature, "_store_picture", lambda feature: None)
            if window is not None:
                close_window(window)
            if workspace is not None:
                close_workspace(workspace)
                fail_for_threads_since(self.threads)


KEPT = Kept()
"""The window that the tests of a folder with the mark `shared_window` share."""


def fail_for_threads_since(threads: set[threading.Thread]) -> None:
    """Fail when a thread runs that was not among these."""
    left = [thread.name for thread in set(threading.enumerate()) - threads if thread.is_alive()]
    lasting = ("cpm-share", "cpm-compile", "pytest_timeout")
    left = [name for name in left if not name.startswith(lasting)]
    assert not left, f"threads left running: {left}"
