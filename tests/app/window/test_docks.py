"""Panels keep their places, show their names once and in full, and can be restored."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QCoreApplication, QEvent, QObject, Qt
from PySide6.QtWidgets import QLabel, QMainWindow, QTabBar, QToolButton, QWidget

from app.session.storage.preferences import Preferences
from app.views.main_window import MainWindow
from app.views.window.docks import Docks
from app.views.window.feature import Panel
from app.views.window.keyboard import Areas

SIX = ("Parameters", "Layers", "Contours", "History", "Truth", "Mosaic")


def seen_bars(window: QMainWindow) -> list[QTabBar]:
    return [bar for bar in window.findChildren(QTabBar) if not bar.visibleRegion().isEmpty()]


def test_tabbed_panels_are_named_by_their_tabs_and_others_by_their_heading(window, hand) -> None:
    docks = window.docks
    hand.wait(lambda: docks["parameters"].titleBarWidget().objectName() == "")
    assert docks["run"].titleBarWidget().objectName() == "title"
    docks["layers"].setFloating(True)
    hand.wait(lambda: docks["parameters"].titleBarWidget().objectName() == "title")
    assert docks["layers"].titleBarWidget().objectName() == "title"


def test_the_heading_detaches_and_closes_its_panel(window, hand) -> None:
    dock = window.docks["run"]
    detach, close = dock.titleBarWidget().findChildren(QToolButton)
    hand.qtbot.mouseClick(detach, Qt.MouseButton.LeftButton)
    assert dock.isFloating()
    hand.qtbot.mouseClick(detach, Qt.MouseButton.LeftButton)
    assert not dock.isFloating()
    hand.qtbot.mouseClick(close, Qt.MouseButton.LeftButton)
    assert dock.isHidden()
    next(action for action in window.docks.actions if action.text() == "Run").trigger()
    assert not dock.isHidden()


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
    again = MainWindow(workspace, Preferences())
    qtbot.addWidget(again)
    assert again.dockWidgetArea(again.docks["run"]) == Qt.DockWidgetArea.LeftDockWidgetArea
    again.close()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_six_tabbed_panels_show_their_names_in_full(window, qtbot, theme) -> None:
    window.actions_by_name[f"theme_{theme}"].trigger()
    other = QMainWindow()
    qtbot.addWidget(other)
    other.setCentralWidget(QLabel())
    docks = Docks(other, [Panel(name=name, title=name, widget=QLabel(name), tab="settings") for name in SIX],
                  Areas(other, {}, lambda name: None))  # fmt: skip
    other.resize(1280, 720)
    other.show()
    qtbot.waitUntil(lambda: bool(seen_bars(other)))
    (bar,) = seen_bars(other)
    qtbot.waitUntil(lambda: bar.elideMode() == Qt.TextElideMode.ElideNone)
    assert [bar.tabText(index) for index in range(bar.count())] == list(SIX)
    for index, name in enumerate(SIX):
        assert bar.tabRect(index).width() >= bar.fontMetrics().horizontalAdvance(name)
    assert bar.tabRect(5).right() <= bar.width()
    assert docks["Parameters"].width() <= 400
    other.close()


def test_no_tab_names_a_panel_that_is_elsewhere(window, hand) -> None:
    panels = {dock.windowTitle(): dock for dock in window.docks}

    def tidy() -> bool:
        named = [bar.tabText(index) for bar in seen_bars(window) for index in range(bar.count())]
        return len(set(named)) == len(named) and not any(panels[name].isHidden() for name in named)

    hand.wait(tidy)
    for dock in window.docks:
        dock.show()
    hand.wait(lambda: tidy() and len(seen_bars(window)) == 2)
    window.docks.restore()
    hand.wait(tidy)


def test_every_button_of_the_tool_bar_has_room_at_1280(window, hand) -> None:
    window.resize(1280, 720)
    hand.wait(lambda: window.width() == 1280)
    for name in ("open", "save", "undo", "redo", "primary", "step", "reset", "fit", "export", "mode_skeleton"):
        hand.wait(window.findChild(QToolButton, name).isVisible)


class Requests(QObject):
    """Counts the layout requests of a window."""

    count = 0

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        self.count += event.type() == QEvent.Type.LayoutRequest
        return False


def test_an_idle_window_makes_no_layout_requests(window, hand) -> None:
    requests = Requests()
    window.installEventFilter(requests)
    window.docks.reveal("contours")
    window.docks.restore()

    def at_rest() -> bool:
        before = requests.count
        for _ in range(20):
            QCoreApplication.processEvents()
        return requests.count == before

    assert not at_rest()
    hand.wait(at_rest)


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
