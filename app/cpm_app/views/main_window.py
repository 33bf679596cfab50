"""Window with all its features, and its first image."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QTimer

from cpm_app.model.document.samples import load_samples
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.storage.preferences import Preferences
from cpm_app.session.tasks.opening import is_image_folder
from cpm_app.views.features import WINDOW_FEATURES
from cpm_app.views.features.files import RecoveryFeature, StartFeature
from cpm_app.views.window.window import MainWindow


def make_window(workspace: Workspace, preferences: Preferences | None = None) -> MainWindow:
    """Create the window of a session with all features.

    Parameters
    ----------
    workspace : Workspace
        Session and features; closed together with the window.
    preferences : Preferences, optional
        Settings that are stored between sessions.

    Returns
    -------
    MainWindow
        Window that is not shown yet.
    """
    return MainWindow(workspace, WINDOW_FEATURES, preferences)


def open_window(path: str | None = None) -> MainWindow:
    """Open a window with an image or a folder of images, by default with the first sample."""
    workspace = Workspace()
    window, session = make_window(workspace), workspace.session

    def open_first_image() -> None:
        if path is not None and is_image_folder(Path(path)):
            workspace.project.open_folder(Path(path))
        else:
            session.open_file(path or load_samples()[0].path)
        session.warm_up()

    window.show()
    QTimer.singleShot(0, window, open_first_image)  # other threads would keep the window from being drawn
    if path is None:
        window.get_feature(StartFeature).offer_recent_work()
    window.get_feature(RecoveryFeature).offer_recovery()
    return window
