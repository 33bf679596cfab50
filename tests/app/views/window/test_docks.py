"""The column has one tab in front, which follows the tool; the tool bar has room."""

from __future__ import annotations

from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.main_window import make_window
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QToolButton

KEY = Qt.Key


def test_the_tab_in_front_follows_the_tool_when_it_changes_and_only_then(ready, hand) -> None:
    tabs = ready.docks.tabs
    hand.key(KEY.Key_W)
    assert tabs.currentWidget() is ready.panels["objects"]
    assert [panel.isVisible() for panel in (ready.panels["objects"], ready.panels["run"])] == [True, False]
    hand.key(KEY.Key_C)
    assert tabs.currentWidget() is ready.panels["run"]
    bar = tabs.tabBar()
    layers = bar.tabRect(tabs.indexOf(ready.panels["layers"])).center()
    hand.qtbot.mouseClick(bar, Qt.MouseButton.LeftButton, pos=layers)
    assert tabs.currentWidget() is ready.panels["layers"]
    hand.key(KEY.Key_C)
    hand.drag((20, 20), (20, 24), (20, 30))
    assert tabs.currentWidget() is ready.panels["layers"]


def test_the_timeline_is_there_while_a_run_is(ready, hand) -> None:
    timeline = ready.panels["timeline"]
    assert not timeline.isVisible()
    hand.key(KEY.Key_Space)
    hand.wait(timeline.isVisible)
    hand.wait_for_phase("finished")
    hand.key(KEY.Key_R)
    hand.wait(lambda: not timeline.isVisible())


def test_the_column_can_be_hidden_and_stays_hidden_at_the_next_start(qtbot, workspace, window, hand) -> None:
    for visible in (False, True, False):
        hand.key(KEY.Key_B, Qt.KeyboardModifier.ControlModifier)
        assert window.docks.tabs.isVisible() is visible
    window.close()
    again = make_window(workspace, Preferences())
    qtbot.addWidget(again)
    assert again.docks.column.isHidden()
    again.close()


def test_every_button_of_the_tool_bar_has_room_at_1280(window, hand) -> None:
    window.resize(1280, 720)
    hand.wait(lambda: window.width() == 1280)
    for name in ("open", "save", "undo", "redo", "primary", "step", "reset", "fit", "export", "mode_skeleton"):
        hand.wait(window.findChild(QToolButton, name).isVisible)
    export = window.findChild(QToolButton, "export")
    assert export.mapTo(window, QPoint(export.width(), 0)).x() <= window.width()
