"""The palette and the bars show what is in use, and only that."""

from __future__ import annotations

import pytest
from cpm_app.model.state.resolve import INITIAL_PACE_INDEX
from cpm_app.views.tools import AUTO_GROUP, TOOLS_BY_GROUP
from cpm_app.views.window.bars import ToolPalette
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor

from tests.app.views.window.windows import is_open

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL = Qt.KeyboardModifier.ControlModifier


def frame_color(button) -> QColor:
    """The color in the middle of the left edge of a button."""
    return button.grab().toImage().pixelColor(0, button.height() // 2)


def test_only_the_tool_in_use_looks_chosen(window, hand) -> None:
    buttons = window.findChild(ToolPalette).buttons
    hand.key(KEY.Key_C)
    hand.key(KEY.Key_G, CONTROL)
    hand.wait(lambda: window.session.idle)
    assert window.actions_by_name["start_grid"].isChecked()
    plain, chosen = frame_color(buttons["Stroke"]), frame_color(buttons["Circle"])
    assert chosen != plain
    assert frame_color(buttons[AUTO_GROUP]) == plain


def test_no_word_of_the_palette_is_cut(window) -> None:
    for group, button in window.findChild(ToolPalette).buttons.items():
        assert button.width() >= max(map(button.fontMetrics().horizontalAdvance, TOOLS_BY_GROUP)), group


def test_starts_everywhere_do_not_cover_what_is_clicked(window, hand) -> None:
    dots = hand.canvas.layers.drawing.computed["grid"]
    hand.key(KEY.Key_C)
    hand.key(KEY.Key_G, CONTROL)
    hand.wait(lambda: dots.count > 0)
    hand.key(KEY.Key_W)
    assert dots.count == 0
    hand.key(KEY.Key_C)
    assert dots.count > 0


def test_accept_names_its_key_in_the_menu(window) -> None:
    action = window.actions_by_name["accept"]
    assert action.text().endswith("\tEnter")
    assert action.toolTip().startswith("Accept: ")


def test_the_next_image_runs_at_the_usual_speed(window, hand, image_file) -> None:
    slider = window.speed.slider
    for _ in range(3):
        hand.key(KEY.Key_BracketLeft, CONTROL)
    assert slider.value() == INITIAL_PACE_INDEX - 3
    before = window.session.image
    window.session.open_file(image_file)
    hand.wait(lambda: window.session.image is not before and is_open(window.session, image_file))
    assert slider.value() == INITIAL_PACE_INDEX
