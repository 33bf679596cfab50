"""A menu everywhere: a right click, or a key, opens the actions of what lies there or is chosen."""

from __future__ import annotations

import pytest
from cpm_app.model.document import edits, objects
from cpm_app.views.window.menus import CONTEXT_MENU_ACTIONS
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QContextMenuEvent
from PySide6.QtWidgets import QApplication, QMenu

from cpm_core.image.region import Region
from cpm_core.objects.segmented import SegmentedObject
from cpm_core.shapes import Charge, Circle

pytestmark = pytest.mark.shared_window

KEY, MODIFIER, RIGHT = Qt.Key, Qt.KeyboardModifier, Qt.MouseButton.RightButton


def texts(menu: QMenu) -> list[str]:
    return [action.text().replace("&", "") for action in menu.actions() if not action.isSeparator()]


def names(window, menu: QMenu) -> list[str]:
    by_action = {action: name for name, action in window.actions_by_name.items()}
    return [by_action[action] for action in menu.actions() if action in by_action]


@pytest.fixture
def menus(window):
    """The menus of the window, closed at the end."""
    made = window.context_menus
    yield made
    popup = QApplication.activePopupWidget()
    if popup is not None:
        popup.close()


def right_click(hand, row: float, col: float) -> None:
    point = hand.at(row, col)
    hand.qtbot.mousePress(hand.canvas.viewport(), RIGHT, pos=point)
    hand.qtbot.mouseRelease(hand.canvas.viewport(), RIGHT, pos=point)


def ask(widget, point: QPoint) -> None:
    """What the window system sends after a right click."""
    event = QContextMenuEvent(QContextMenuEvent.Reason.Mouse, point, widget.mapToGlobal(point))
    QApplication.sendEvent(widget, event)


def run(window, hand) -> None:
    hand.key(KEY.Key_Space)
    hand.wait(lambda: window.session.status.phase == "finished" and bool(window.workspace.object_list.rows))


def test_a_right_click_on_the_image_opens_its_menu_with_the_keys(window, hand, menus) -> None:
    right_click(hand, 10, 10)
    assert menus.menu.isVisible()
    assert names(window, menus.menu) == [name for name in CONTEXT_MENU_ACTIONS["image"] if name]
    fit = window.actions_by_name["fit"]
    assert fit in menus.menu.actions()
    assert fit.shortcut().toString() == "F"
    assert fit.isShortcutVisibleInContextMenu()


def test_a_right_drag_moves_the_image_and_opens_no_menu(window, hand, menus) -> None:
    start, end = hand.at(32, 32), hand.at(20, 40)
    for to in (start + QPoint(1, 1), end):
        hand.qtbot.mousePress(hand.canvas.viewport(), RIGHT, pos=start)
        before = hand.canvas.view.viewRect()
        hand.qtbot.mouseMove(hand.canvas.viewport(), to)
        assert (hand.canvas.view.viewRect() != before) is (to == end)
        hand.qtbot.mouseRelease(hand.canvas.viewport(), RIGHT, pos=to)
        assert (menus.menu is not None and menus.menu.isVisible()) is (to != end)
        if to != end:
            menus.menu.close()
            menus.menu = None


@pytest.mark.parametrize(("shape", "thing"), [(Circle((32.0, 32.0), 10.0), "shape"), (Charge((32.0, 42.0)), "charge")])
def test_a_right_click_on_a_shape_selects_it_and_nothing_else(window, hand, menus, shape, thing) -> None:
    far = SegmentedObject(1, (), Region((((2.0, 2.0), (2.0, 9.0), (9.0, 9.0)),)))
    window.session.edit("add", lambda document: objects.accept_objects(edits.add_shape(document, shape), (far,)))
    hand.canvas.setFocus()
    hand.key(KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
    assert window.workspace.object_list.selected_numbers == {1}
    right_click(hand, 32, 42)
    assert (window.session.selected_shape, window.workspace.object_list.selected_keys) == (0, set())
    assert names(window, menus.menu) == [name for name in CONTEXT_MENU_ACTIONS[thing] if name]
    window.actions_by_name["enlarge"].trigger()
    assert window.session.document.shapes == (shape.resized_by(1.0),)


def test_the_menu_of_a_table_row_selects_the_row_and_is_that_of_the_canvas(ready, hand, menus) -> None:
    run(ready, hand)
    ready.resize(1400, 900)
    ready.docks.enter_panel("objects")
    table = ready.panels["objects"].table
    hand.wait(table.isVisible)
    row = table.visualRect(table.model().index(0, 0)).center()
    hand.wait(lambda: table.viewport().visibleRegion().contains(row))
    ask(table.viewport(), row)
    assert len(ready.workspace.object_list.selected_keys) == 1
    assert names(ready, menus.menu) == [n for n in CONTEXT_MENU_ACTIONS["object"] if n in ready.actions_by_name]
    menus.menu.close()
    header = table.horizontalHeader()
    ask(header.viewport(), QPoint(header.sectionViewportPosition(1) + 4, 4))
    menu = QApplication.activePopupWidget()
    assert texts(menu)[:2] == ["#", "Name"]
    hidden = table.isColumnHidden(2)
    menu.actions()[2].trigger()
    assert table.isColumnHidden(2) is not hidden
    menu.close()


def test_the_timeline_shows_the_step_under_the_pointer_and_opens_its_menu(ready, hand, menus) -> None:
    ready.resize(1400, 800)
    run(ready, hand)
    view, navigation = ready.panels["timeline"].view, ready.workspace.navigation
    branch, last = navigation.current_step
    hand.wait(lambda: view.visibleRegion().contains(view.step_position(branch, last // 2).toPoint()))
    ask(view, view.step_position(branch, last // 2).toPoint())
    hand.wait(lambda: abs(navigation.current_step[1] - last // 2) <= 2)  # as exact as a pixel
    assert texts(menus.menu)[0] == "Rename the branch…"
    assert "timeline_parameters" in names(ready, menus.menu)


def test_headings_have_menus(ready, hand, menus) -> None:
    ask(ready.docks.tabs.tabBar(), QPoint(20, 5))
    assert {"Timeline", "Side panel"} <= {*texts(menus.menu)}


@pytest.mark.parametrize("keys", [(KEY.Key_F10, MODIFIER.ShiftModifier), (KEY.Key_Menu, MODIFIER.NoModifier)])
def test_a_key_opens_the_menu_of_what_is_chosen(ready, hand, menus, keys) -> None:
    ready.activateWindow()
    hand.wait(ready.isActiveWindow)
    hand.canvas.setFocus()
    hand.key(KEY.Key_N)
    hand.key(*keys)
    assert names(ready, menus.menu) == [name for name in CONTEXT_MENU_ACTIONS["shape"] if name]
    menus.menu.close()
    hand.key(KEY.Key_Q)
    slider = ready.focusWidget()
    hand.key(*keys)
    by_key = texts(menus.menu)
    menus.menu.close()
    ask(slider, slider.rect().center())
    assert by_key == texts(menus.menu) and "Timeline" in by_key
    menus.menu.close()
