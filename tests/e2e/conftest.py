"""These tests use neither the preferences nor the unsaved work of the user of this computer."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from cpm_app.views.application import make_application
from cpm_app.views.main_window import open_window
from cpm_app.views.window import dialogs
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QPoint, QSettings
from PySide6.QtGui import QCursor

PATIENCE = 60_000
"""Longest wait for anything [ms]."""


@pytest.fixture(autouse=True)
def own_preferences(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "preferences"))
    monkeypatch.setattr(dialogs, "ask_about_unsaved", lambda parent, name, lost: "discard")


@pytest.fixture
def window(qtbot) -> Iterator[MainWindow]:
    """The window as it starts, with its sample, at full speed; the pointer is off the image."""
    make_application()
    made = open_window()
    made.session.set_pace(None)
    qtbot.waitExposed(made)
    QCursor.setPos(made.mapToGlobal(QPoint(2, 2)))
    qtbot.waitUntil(lambda: made.session.document.image is not None, timeout=PATIENCE)
    qtbot.waitUntil(lambda: made.session.idle and made.isActiveWindow(), timeout=PATIENCE)
    yield made
    made.close()
    made.deleteLater()
