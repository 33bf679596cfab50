"""No underlined letter chooses two visible entries of a menu of the window."""

from __future__ import annotations

import pytest
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from app.model.text.mnemonics import letter_of

pytestmark = pytest.mark.shared_window


def letters(actions: list[QAction]) -> list[str]:
    return [letter for action in actions if action.isVisible() and (letter := letter_of(action.text()))]


def menus(outer: QMenu) -> list[QMenu]:
    outer.aboutToShow.emit()
    inner = [made for action in outer.actions() if isinstance(made := action.menu(), QMenu)]
    return [outer, *(menu for each in inner for menu in menus(each))]


def test_no_letter_chooses_two_entries_of_a_menu(window):
    bar = window.menuBar().actions()

    assert len(letters(bar)) == len(bar) == len(set(letters(bar)))
    opened = [menu for action in bar for menu in menus(action.menu())]
    assert len(opened) > len(bar)
    for menu in opened:
        assert len(letters(menu.actions())) == len(set(letters(menu.actions()))), menu.title()


def test_an_entry_that_appears_gets_a_letter_of_its_own(window):
    menu = window.menuBar().actions()[0].menu()
    menu.aboutToShow.emit()
    taken = letter_of(next(action.text() for action in menu.actions() if letter_of(action.text())))
    added = QAction(f"&{taken} 再 Qxzwjykv", menu)
    menu.addAction(added)

    menu.aboutToShow.emit()

    assert letter_of(added.text()) not in {"", taken}
    menu.removeAction(added)
