"""No underlined letter chooses two visible entries of a menu of the window."""

from __future__ import annotations

import pytest
from cpm_app.model.text.keys import find_mnemonic
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QWidget

pytestmark = pytest.mark.shared_window


def letters(actions: list[QAction]) -> list[str]:
    return [letter for action in actions if action.isVisible() and (letter := find_mnemonic(action.text()))]


def menus(window: QWidget, actions: list[QAction]) -> list[QMenu]:
    """The menus that actions open, and those within them; what QAction.menu gives is deleted by Qt 6.8."""
    opened = [menu for menu in window.findChildren(QMenu) if menu.menuAction() in actions]
    for menu in opened:
        menu.aboutToShow.emit()
    return [*opened, *(inner for menu in opened for inner in menus(window, menu.actions()))]


def test_no_letter_chooses_two_entries_of_a_menu(window):
    bar = window.menuBar().actions()

    assert len(letters(bar)) == len(bar) == len(set(letters(bar)))
    opened = menus(window, bar)
    assert len(opened) > len(bar)
    for menu in opened:
        assert len(letters(menu.actions())) == len(set(letters(menu.actions()))), menu.title()


def test_an_entry_that_appears_gets_a_letter_of_its_own(window):
    menu = menus(window, window.menuBar().actions()[:1])[0]
    menu.aboutToShow.emit()
    taken = find_mnemonic(next(action.text() for action in menu.actions() if find_mnemonic(action.text())))
    added = QAction(f"&{taken} 再 Qxzwjykv", menu)
    menu.addAction(added)

    menu.aboutToShow.emit()

    assert find_mnemonic(added.text()) not in {"", taken}
    menu.removeAction(added)
