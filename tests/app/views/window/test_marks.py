"""No underlined letter chooses two menus of the window."""

from __future__ import annotations

import re

import pytest

pytestmark = pytest.mark.shared_window


def test_no_letter_chooses_two_menus_of_the_bar(window):
    letters = [re.search(r"&(\w)", action.text())[1] for action in window.menuBar().actions()]

    assert len(letters) == len(set(letters)) > 1
