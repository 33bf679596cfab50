"""What is changed in the preferences acts at once, and is there again at the next start."""

from __future__ import annotations

from dataclasses import replace

import pytest
from cpm_app.model.document import edits
from cpm_app.model.preferences.table import (
    AUTOSAVE_PREFERENCE,
    CONTOUR_WIDTH,
    INK_PREFERENCES,
    PAGE_TITLES,
    SHAPE_WIDTH,
    UNIT_PREFERENCE,
)
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.features.files import RecoveryFeature
from cpm_app.views.features.help import HelpFeature, PreferencesFeature
from cpm_app.views.theme import theme
from cpm_app.views.theme.theme import get_canvas_style
from cpm_app.views.window.preferences import ShortcutsPage
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QColor, QKeySequence
from PySide6.QtWidgets import QPushButton

from cpm_core.shapes import Barrier

KEY = Qt.Key
CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def dialog(window, hand):
    made = window.get_feature(PreferencesFeature).open_preferences()
    yield made
    made.reject()


def type_into(hand, field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, text)
    hand.qtbot.keyClick(field, KEY.Key_Return)


def across(window, color: str) -> int:
    """Number of pixels of a color in the row through the middle of the canvas."""
    canvas = window.canvas_area.canvas
    picture = canvas.grab().toImage()
    y = canvas.map_from_image((32.0, 32.0)).toPoint().y()
    near = QColor(color)
    return sum(
        abs(picture.pixelColor(x, y).red() - near.red()) < 40
        and abs(picture.pixelColor(x, y).blue() - near.blue()) < 40
        for x in range(picture.width())
    )


def test_the_dialog_fits_a_small_screen_and_every_page_opens(dialog) -> None:
    assert dialog.width() <= 1280 - 80
    assert dialog.height() <= 720 - 80
    for name in PAGE_TITLES:
        dialog.turn_to(name)
        shown = [row for row in dialog.rows.values() if row.isVisible()]
        assert bool(shown) != dialog.findChild(ShortcutsPage).isVisible()


def test_lines_of_shapes_get_wider_at_once(window, dialog, hand) -> None:
    barrier = Barrier(((5.0, 50.0), (60.0, 50.0)))
    window.session.edit("draw barrier", lambda document: edits.add_shape(document, barrier))
    before = across(window, theme.BARRIER_COLOR)
    dialog.turn_to("appearance")
    type_into(hand, dialog.rows[SHAPE_WIDTH.label], "4.2")
    assert window.preferences.read_preference(SHAPE_WIDTH) == 4.2
    assert across(window, theme.BARRIER_COLOR) > 2 * before > 0


def test_reset_of_a_page_restores_its_defaults_and_no_others(window, dialog, hand) -> None:
    preferences = window.preferences
    preferences.store_preference(CONTOUR_WIDTH, 4.0)
    preferences.store_preference(INK_PREFERENCES["contour"], "#123456")
    assert get_canvas_style().resolve_color(theme.CONTOUR_COLOR) == "#123456"
    dialog.turn_to("appearance")
    button = next(b for b in dialog.findChildren(QPushButton) if b.text() == "Reset this page")
    hand.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert preferences.read_preference(CONTOUR_WIDTH) == CONTOUR_WIDTH.default
    assert get_canvas_style().resolve_color(theme.CONTOUR_COLOR) == INK_PREFERENCES["contour"].default
    assert get_canvas_style().contours == 1.0


def test_without_autosave_there_is_no_journal(ready, hand) -> None:
    journal = ready.get_feature(RecoveryFeature).journal
    journal.write()
    journal.flush()
    assert journal.path.exists()
    dialog = ready.get_feature(PreferencesFeature).open_preferences()
    dialog.turn_to("files")
    hand.qtbot.mouseClick(
        dialog.rows[AUTOSAVE_PREFERENCE.label],
        Qt.MouseButton.LeftButton,
        pos=dialog.rows[AUTOSAVE_PREFERENCE.label].rect().topLeft(),
    )
    dialog.rows[AUTOSAVE_PREFERENCE.label].setChecked(False)
    journal.write()
    journal.flush()
    assert not journal.path.exists()
    dialog.reject()


def press_as_new_key(hand, dialog, action: str, key: Qt.Key, modifier=Qt.KeyboardModifier.NoModifier) -> None:
    dialog.turn_to("shortcuts")
    dialog.findChild(ShortcutsPage).list.setCurrentItem(dialog.findChild(ShortcutsPage).rows[action])
    dialog.findChild(ShortcutsPage).keys.setFocus()
    hand.qtbot.keyClick(dialog.findChild(ShortcutsPage).keys, key, modifier)


def test_a_new_key_acts_and_is_shown_everywhere(ready, hand) -> None:
    dialog = ready.get_feature(PreferencesFeature).open_preferences()
    press_as_new_key(hand, dialog, "run", KEY.Key_F4)
    dialog.reject()
    action = ready.actions_by_name["run"]
    assert action.shortcut() == QKeySequence("F4")
    assert "(F4)" in action.toolTip()
    hand.key(Qt.Key.Key_Question)
    assert "F4" in ready.get_feature(HelpFeature).guide.text.toPlainText()
    ready.get_feature(HelpFeature).guide.close()
    ready.canvas_area.canvas.setFocus()
    hand.key(KEY.Key_F4)
    assert ready.session.status.phase != "ready"
    assert "F4" in Preferences().read_key("shortcuts", "")


def test_a_key_of_another_action_is_told_and_can_be_taken_over(window, dialog, hand) -> None:
    page = dialog.findChild(ShortcutsPage)
    press_as_new_key(hand, dialog, "run", KEY.Key_O, CTRL)
    assert "Open" in page.message.text()
    assert window.actions_by_name["run"].shortcut() == QKeySequence("Space")
    assert page.take_over.isVisible()
    hand.qtbot.mouseClick(page.take_over, Qt.MouseButton.LeftButton)
    assert window.actions_by_name["run"].shortcut() == QKeySequence("Ctrl+O")
    assert window.actions_by_name["open"].shortcuts() == []
    dialog.reset()
    assert window.actions_by_name["run"].shortcut() == QKeySequence("Space")
    assert window.actions_by_name["open"].shortcut() == QKeySequence("Ctrl+O")


def test_panels_have_keys_too_and_actions_are_found_by_typing(window, dialog, hand) -> None:
    page = dialog.findChild(ShortcutsPage)
    press_as_new_key(hand, dialog, "panel_timeline", KEY.Key_F9, CTRL | SHIFT)
    assert window.findChild(QAction, "panel_timeline").shortcut() == QKeySequence("Ctrl+Shift+F9")
    page.search.setFocus()
    hand.qtbot.keyClicks(page.search, "timeline")
    seen = [name for name, item in page.rows.items() if not item.isHidden()]
    assert "panel_timeline" in seen
    assert "open" not in seen


def test_no_two_actions_share_a_key_by_default(window) -> None:
    held = [key for action in window.shortcuts.actions for key in action.default]
    assert len(held) == len(set(held))


def test_another_unit_is_shown_at_once(window, hand, monkeypatch) -> None:
    session = window.session
    image = replace(session.image, spacing=(0.5, 0.5), unit="µm")
    monkeypatch.setattr(type(session), "image", property(lambda self: image))
    window.pointer_readout._on_place_changed((10.0, 20.0))
    assert "5 µm" in window.pointer_readout.text()
    window.preferences.store_preference(UNIT_PREFERENCE, "nm")
    window.pointer_readout._on_place_changed((10.0, 20.0))
    assert "5000 nm" in window.pointer_readout.text()
    window.preferences.store_preference(UNIT_PREFERENCE, "px")
    window.pointer_readout._on_place_changed((10.0, 20.0))
    assert "µm" not in window.pointer_readout.text()
