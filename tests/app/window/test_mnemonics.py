"""No two entries of a menu are chosen by one letter, in any language."""

from __future__ import annotations

import re
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QMenu

from app.model.text.mnemonics import distinct, mnemonic_of

pytestmark = pytest.mark.shared_window

TEXTS = st.lists(st.text("&&abcABC éß日本1…>", max_size=12), max_size=20)


def plain(text: str) -> str:
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&&")


def doubled(texts) -> list[str]:
    return [letter for letter, count in Counter(filter(None, map(mnemonic_of, texts))).items() if count > 1]


@given(TEXTS)
def test_whatever_entries_say_their_letters_are_distinct_and_their_words_the_same(texts) -> None:
    texts = [re.sub(r"&(?!&|[^\W_])", "", text) for text in texts]
    made = distinct(texts)
    assert doubled(made) == []
    assert [plain(text) for text in made] == [plain(text) for text in texts]
    assert distinct(made) == made


def test_the_first_keeps_its_letter_and_another_one_gets_a_free_one_of_its_own() -> None:
    assert distinct(["S&tart screen", "Export &turntable", "E&xit"]) == ["S&tart screen", "&Export turntable", "E&xit"]
    assert distinct(["&a", "&a", "b && &a"]) == ["&a", "a", "&b && a"]
    assert distinct(["Ouvrir &é", "&Éteindre"]) == ["Ouvrir &é", "É&teindre"]


def menus_of(window) -> list[QMenu]:
    return [menu for menu in window.menuBar().findChildren(QMenu) if menu.actions()]


def test_no_menu_of_the_window_has_a_letter_twice(window) -> None:
    assert doubled([entry.text() for entry in window.menuBar().actions()]) == []
    assert len(menus_of(window)) > 10
    for _ in range(2):  # texts that follow the state of the program change between two openings
        for menu in menus_of(window):
            menu.aboutToShow.emit()
            assert doubled([entry.text() for entry in menu.actions()]) == [], menu.title()
        window.refresh()


def test_no_menu_of_what_is_chosen_has_a_letter_twice(window, hand) -> None:
    window.context_menus.open_at(window.canvas_area, window.canvas_area.mapToGlobal(QPoint(90, 90)))
    menu = window.context_menus.menu
    assert len(menu.actions()) > 3
    assert doubled([entry.text() for entry in menu.actions()]) == []
    menu.close()
