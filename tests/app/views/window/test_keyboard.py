"""The keyboard belongs to the canvas: fields give it back, and keep only what is text for them."""

from __future__ import annotations

import pytest
import shiboken6
from cpm_app.model.document import edits
from cpm_app.views.tools import TOOLS
from cpm_app.views.widgets.containers import OfferBar
from cpm_app.views.window.keyboard import TypedAhead, find_sliders
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QLineEdit, QToolButton

from tests.app.reading import accepted_items

pytestmark = pytest.mark.shared_window

KEY, MODIFIER = Qt.Key, Qt.KeyboardModifier


@pytest.fixture
def board(ready, hand):
    """The ready window, active, with a circle to start from."""
    ready.activateWindow()
    hand.wait(ready.isActiveWindow)
    return ready


@pytest.fixture
def beta(board):
    return board.panels["run"].parameters.rows["beta"]


def focus(hand, widget) -> None:
    widget.setFocus()
    hand.wait(widget.hasFocus)


def type_in(hand, widget, text: str) -> None:
    focus(hand, widget)
    for character in text:
        hand.qtbot.keyClicks(widget, character)


def fields(window) -> dict[str, object]:
    """One field of each kind in the window."""
    window.panels["run"].parameters.more.fold.setChecked(True)
    parameters = window.panels["run"].parameters
    return {
        "number": parameters.rows["beta"].number,
        "slider": parameters.rows["beta"].slider,
        "choice": next(iter(parameters.choices.values())).box,
        "button": window.findChild(QToolButton, "save"),
        "check box": parameters.rows["smoothing"].findChild(QCheckBox),
        "preset": parameters.presets,
        "timeline": window.panels["timeline"].view,
        "step": window.panels["timeline"].step,
    }


KINDS = ("number", "slider", "choice", "button", "check box", "preset", "timeline")


def test_space_runs_from_every_field_that_is_no_text(board, hand, cases) -> None:
    for kind in cases(KINDS):
        field = fields(board)[kind]
        parameters = board.session.document.parameters
        focus(hand, field)
        hand.key(KEY.Key_Space)
        assert board.session.status.phase != "ready"
        assert board.session.document.parameters == parameters
        assert not board.panels["run"].parameters.presets.view().isVisible()
        board.session.reset()
        hand.wait_for_phase("ready")


def test_letters_choose_tools_from_every_field_and_bring_the_keyboard_to_the_canvas(board, hand, cases) -> None:
    for kind in cases(KINDS):
        field = fields(board)[kind]
        for tool in TOOLS:
            focus(hand, field)
            keys = QKeySequence(tool.shortcut)[0]
            hand.key(keys.key(), keys.keyboardModifiers())
            assert hand.canvas.dispatcher.tool.name == tool.name
            assert hand.canvas.hasFocus()


def test_escape_gives_the_keyboard_back_from_every_field(board, hand, cases) -> None:
    for kind in cases(KINDS):
        focus(hand, fields(board)[kind])
        hand.key(KEY.Key_Escape)
        assert hand.canvas.hasFocus()


def test_the_canvas_gets_the_keyboard_of_a_button_that_goes_when_it_is_pressed(window, hand) -> None:
    bar = window.findChild(OfferBar)
    for _ in range(2):
        bar.add_offer("Shall it be?", ("Yes", list))
    focus(hand, bar.buttons[0])
    hand.key(KEY.Key_Return)
    hand.wait(hand.canvas.hasFocus)
    bar.clear()


def test_enter_gives_the_keyboard_back_from_every_field(board, hand, cases) -> None:
    for kind in cases(["number", "slider", "choice", "timeline"]):
        focus(hand, fields(board)[kind])
        hand.key(KEY.Key_Return)
        assert hand.canvas.hasFocus()


def test_a_number_is_entered_by_enter_and_space_then_runs(board, hand, beta) -> None:
    focus(hand, beta.number)
    beta.number.selectAll()
    type_in(hand, beta.number, "0.5")
    hand.key(KEY.Key_Return)
    assert board.session.document.parameters.beta == 0.5
    assert beta.number.text().startswith("0.5")
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")


def test_escape_restores_the_value_from_before_the_first_key(board, hand, cases) -> None:
    for kind in cases(["number", "slider", "choice"]):
        board.session.edit("β", lambda document: edits.set_parameter(document, "beta", 0.777))  # between two steps
        before = board.session.document.parameters
        field = fields(board)[kind]
        focus(hand, field)
        for _ in range(2):
            hand.key(KEY.Key_Right if kind == "slider" else KEY.Key_Down)
        assert board.session.document.parameters != before
        hand.key(KEY.Key_Escape)
        assert board.session.document.parameters == before
        assert hand.canvas.hasFocus()


def test_enter_presses_the_focused_button(board, hand) -> None:
    box = fields(board)["check box"]
    focus(hand, box)
    hand.key(KEY.Key_Return)
    assert board.session.document.parameters.smoothing == "auto"
    assert box.hasFocus()


@pytest.fixture
def proposed(board, hand):
    """The window after a run that proposes the disc."""
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    selection = board.workspace.object_selection
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    return board


def test_enter_accepts_wherever_the_focus_is_but_in_a_field_of_text(proposed, hand) -> None:
    hand.key(KEY.Key_O, MODIFIER.ControlModifier | MODIFIER.ShiftModifier)
    table = proposed.panels["objects"].table
    hand.wait(lambda: table.hasFocus() and table.rows.items)
    hand.key(KEY.Key_Down)
    for kind in ("table", "slider", "choice", "check box", "timeline"):
        focus(hand, table if kind == "table" else fields(proposed)[kind])
        assert "Enter accepts it" in proposed.canvas_area.hint.text()
        hand.key(KEY.Key_Return)
        assert (kind, len(accepted_items(proposed))) == (kind, 1)
        assert hand.canvas.hasFocus()
        hand.key(KEY.Key_Z, MODIFIER.ControlModifier)
        hand.wait(lambda: proposed.workspace.object_selection.idle and proposed.workspace.object_selection.proposals)
        proposed.workspace.object_list.select_items(())


def test_the_first_enter_after_a_slider_was_dragged_accepts(proposed, hand, beta) -> None:
    where = beta.slider.rect().center()
    hand.qtbot.mousePress(beta.slider, Qt.MouseButton.LeftButton, pos=where)
    hand.qtbot.mouseRelease(beta.slider, Qt.MouseButton.LeftButton, pos=where)
    assert beta.slider.hasFocus()
    selection = proposed.workspace.object_selection
    hand.wait(lambda: proposed.session.status.phase == "finished" and selection.idle and selection.proposals)
    hand.key(KEY.Key_Return)
    assert len(accepted_items(proposed)) == 1


def test_enter_in_a_field_of_text_keeps_the_text_which_the_line_says_and_the_next_accepts(proposed, hand, beta) -> None:
    focus(hand, beta.number)
    assert "Enter keeps what is typed" in proposed.canvas_area.hint.text()
    hand.key(KEY.Key_Return)
    assert not accepted_items(proposed)
    assert "Enter accepts it" in proposed.canvas_area.hint.text()
    hand.key(KEY.Key_Return)
    assert len(accepted_items(proposed)) == 1


def test_enter_accepts_after_escape_has_left_a_field(proposed, hand, beta) -> None:
    focus(hand, beta.number)
    hand.key(KEY.Key_Escape)
    hand.key(KEY.Key_Return)
    assert len(accepted_items(proposed)) == 1


def test_a_widget_that_is_hidden_or_disabled_gives_the_keyboard_to_the_canvas(board, hand) -> None:
    rows = board.panels["run"].parameters.rows
    fields(board)
    focus(hand, rows["smoothing"].slider)
    hand.qtbot.mouseClick(rows["smoothing"].findChild(QCheckBox), Qt.MouseButton.LeftButton)
    assert not rows["smoothing"].slider.isEnabled()
    assert hand.canvas.hasFocus()
    focus(hand, rows["beta"].slider)
    hand.qtbot.mouseClick(board.findChild(QToolButton, "mode_skeleton"), Qt.MouseButton.LeftButton)
    assert not rows["beta"].isVisible()
    assert hand.canvas.hasFocus()


def test_a_table_that_opens_is_walked_at_once(board, hand) -> None:
    hand.key(KEY.Key_Space)
    hand.wait(lambda: board.session.status.phase == "finished" and board.workspace.object_selection.idle)
    shapes = board.session.document.shapes
    hand.wait(lambda: bool(board.workspace.object_list.rows))
    board.workspace.contour_selection.select()
    hand.canvas.setFocus()
    hand.key(KEY.Key_O, MODIFIER.ControlModifier | MODIFIER.ShiftModifier)
    hand.wait(board.panels["objects"].table.hasFocus)
    hand.key(KEY.Key_Down)
    assert len(board.workspace.object_list.selected_keys) == 1
    assert board.session.document.shapes == shapes
    hand.key(KEY.Key_Escape)
    assert hand.canvas.hasFocus()


def test_the_key_of_a_panel_brings_its_tab_to_the_front_and_the_keyboard_there_and_back(board, hand) -> None:
    layers = board.panels["layers"]
    hand.canvas.setFocus()
    hand.key(KEY.Key_F8)
    assert layers.isVisible()
    assert layers.isAncestorOf(QApplication.focusWidget())
    hand.key(KEY.Key_F8)
    assert layers.isVisible()
    assert hand.canvas.hasFocus()


@pytest.mark.own_window  # a panel remembers the slider that was used last
def test_f6_goes_around_the_areas_that_are_seen_both_ways(board, hand) -> None:
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.canvas.setFocus()
    slider, timeline = find_sliders(board.panels["run"])[0], board.panels["timeline"].view
    around = [slider, timeline, hand.canvas]
    for widget in around:
        hand.key(KEY.Key_F6)
        hand.wait(widget.hasFocus)
    for widget in (*around[-2::-1], hand.canvas):
        hand.key(KEY.Key_F6, MODIFIER.ShiftModifier)
        hand.wait(widget.hasFocus)


@pytest.mark.own_window
def test_dialogs_keep_their_keys(board, hand) -> None:
    dialog = board.actions_by_name["preferences"]
    dialog.trigger()
    shown = QApplication.activeModalWidget()
    shown.turn_to("files")
    box = shown.findChild(QCheckBox)
    checked = box.isChecked()
    box.setFocus()
    hand.qtbot.keyClick(box, KEY.Key_Space)
    assert box.isChecked() is not checked
    assert board.session.status.phase == "ready"
    assert shown.findChild(QComboBox) is not None
    shown.reject()


def test_what_is_typed_ahead_goes_into_the_field_and_nothing_is_kept_for_one_that_never_opens(qtbot) -> None:
    awaited, (early, field) = [True, True], (QLineEdit(), QLineEdit())
    for widget in (early, field):
        qtbot.addWidget(widget)
    typed, dropped = (TypedAhead(early, lambda number=number: awaited[number]) for number in (0, 1))
    awaited[1] = False
    qtbot.keyClicks(early, "rib")
    typed.type_into(field)
    assert (early.text(), field.text()) == ("", "rib")
    qtbot.waitUntil(lambda: not shiboken6.isValid(dropped))
    awaited[:] = [True, True]
    qtbot.keyClicks(early, "x")
    assert early.text() == "x"
