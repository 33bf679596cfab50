"""Panels keep their places, show their names once and in full, and can be restored."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication, Qt
from PySide6.QtWidgets import QToolButton, QWidget

from app.session.storage.preferences import Preferences
from app.views.main_window import make_window


def test_panels_are_restored_to_their_initial_places(window, hand) -> None:
    before = {dock.objectName(): window.dockWidgetArea(dock) for dock in window.docks}
    window.docks["run"].close()
    window.docks["layers"].setFloating(True)
    window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, window.docks["parameters"])
    restore = next(action for action in window.menus["View"].actions() if "Restore" in action.text())
    restore.trigger()
    hand.wait(lambda: not window.docks["run"].isHidden())
    assert {dock.objectName(): window.dockWidgetArea(dock) for dock in window.docks} == before
    assert not any(dock.isFloating() for dock in window.docks)
    assert window.docks["layers"] in window.tabifiedDockWidgets(window.docks["parameters"])


def test_panels_keep_their_places_for_the_next_start(qtbot, workspace, window, hand) -> None:
    window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, window.docks["run"])
    window.close()
    again = make_window(workspace, Preferences())
    qtbot.addWidget(again)
    assert again.dockWidgetArea(again.docks["run"]) == Qt.DockWidgetArea.LeftDockWidgetArea
    again.close()


def test_every_button_of_the_tool_bar_has_room_at_1280(window, hand) -> None:
    window.resize(1280, 720)
    hand.wait(lambda: window.width() == 1280)
    for name in ("open", "save", "undo", "redo", "primary", "step", "reset", "fit", "export", "mode_skeleton"):
        hand.wait(window.findChild(QToolButton, name).isVisible)


def test_hiding_and_showing_panels_leaves_nothing_behind(window, hand) -> None:
    def splitters() -> int:
        QCoreApplication.processEvents()
        return len(window.findChildren(QWidget, "qt_qmainwindow_extended_splitter"))

    before = splitters()
    for _ in range(5):
        window.docks["run"].hide()
        window.docks["parameters"].hide()
        assert splitters() == before
        window.docks.restore()
        assert splitters() == before


def test_tabbed_panels_are_named_by_their_tabs_and_others_by_their_heading(window, hand) -> None:
    docks = window.docks
    hand.wait(lambda: docks["parameters"].titleBarWidget() is not None)
    assert docks["run"].titleBarWidget() is None
    docks["layers"].setFloating(True)
    hand.wait(lambda: docks["parameters"].titleBarWidget() is None)
