"""The export dialog in tests: opened by its key, walked by keys and the mouse."""

from __future__ import annotations

from pathlib import Path

from cpm_app.views.export.dialog import ExportDialog
from cpm_app.views.features.exchange import ExportFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

PATIENCE = 20_000


def asked(qtbot: QtBot, window: MainWindow) -> ExportDialog:
    """The dialog, opened by its key."""
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow, timeout=PATIENCE)
    window.canvas_area.canvas.setFocus()
    qtbot.keyClick(window.canvas_area.canvas, Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    dialog = window.get_feature(ExportFeature).dialog
    assert dialog is not None
    qtbot.waitExposed(dialog)
    return dialog


def offered(dialog: ExportDialog) -> list[str]:
    """What can be checked, as ``what:suffix``."""
    return list(map(":".join, dialog.list.rows))


def check(qtbot: QtBot, dialog: ExportDialog, *wanted: str) -> None:
    """Check these and nothing else, by the space bar."""
    assert set(wanted) <= set(offered(dialog))
    for item, key in zip(dialog.list.rows.values(), offered(dialog), strict=True):
        if (item.checkState(0) == Qt.CheckState.Checked) != (key in wanted):
            item.parent().setExpanded(True)
            dialog.list.setCurrentItem(item)
            qtbot.keyClick(dialog.list, Qt.Key.Key_Space)
    assert {f"{file.kind}:{file.suffix}" for file in dialog.checked_files} == set(wanted)


def export(qtbot: QtBot, window: MainWindow, folder: Path, *wanted: str) -> list[Path]:
    """The files that the dialog leads to, by a click on its button."""
    dialog = asked(qtbot, window)
    check(qtbot, dialog, *wanted)
    return order(qtbot, window, dialog, folder)


def order(qtbot: QtBot, window: MainWindow, dialog: ExportDialog, folder: Path) -> list[Path]:
    """The files that a dialog leads to as it is."""
    dialog.folder = folder
    dialog._on_settings_changed()
    paths = [file.path for file in dialog.checked_files]
    qtbot.mouseClick(dialog.export_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: all(path.exists() for path in paths) and window.session.idle, timeout=PATIENCE)
    return paths
