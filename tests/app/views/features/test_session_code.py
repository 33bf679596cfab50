"""A session as a script and as a command: run, they give the objects of the window to the bit."""

from __future__ import annotations

import shlex
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from cpm_app.model.document import edits
from cpm_app.session.features import session_code
from cpm_app.session.worker.reconstruction import ReconstructionRequest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

import cpm_core as cpm
from cpm_core import cli
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.shapes import PolygonRegion

pytestmark = pytest.mark.shared_window

KEY, SHIFT, NONE = Qt.Key, Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.NoModifier


def disk(row: float, col: float, radius: float) -> np.ndarray:
    return np.hypot(*(np.indices((64, 64)) - np.array((row, col))[:, None, None])) < radius


@pytest.fixture
def image_file(tmp_path):
    """A picture of three disks, the last one faint."""
    path = tmp_path / "three disks.png"
    values = np.where(disk(18, 18, 9), 140, np.where(disk(42, 42, 12), 220, np.where(disk(16, 48, 8), 60, 40)))
    PIL.Image.fromarray(values.astype(np.uint8)).save(path)
    return path


def click(hand, row: float, col: float, modifier: Qt.KeyboardModifier = NONE) -> None:
    selection = hand.window.workspace.object_selection
    for act in (hand.qtbot.mousePress, hand.qtbot.mouseRelease):
        act(hand.canvas.viewport(), Qt.MouseButton.LeftButton, modifier, hand.at(row, col))
    hand.wait(lambda: selection.idle and selection.answered)


def copied(hand, action: str) -> str:
    """What an action of the menu Edit puts on the clipboard; empty where it asks to save the session."""
    clipboard, messages = QApplication.clipboard(), hand.window.canvas_area.messages
    clipboard.clear()
    hand.window.actions_by_name[action].trigger()
    hand.wait(lambda: bool(clipboard.text()) or "ave the session first" in messages.text)
    return clipboard.text()


def check_both(hand, tmp_path: Path, shown) -> str:
    """Run the script and the command, compare what they find with what the window shows, and return the command."""
    found: dict[str, object] = {}
    exec(copied(hand, "copy_python"), found)
    objects = found["objects"]
    assert len(objects) == len(shown) > 0
    for one, other in zip(objects, shown, strict=True):
        np.testing.assert_array_equal(one.mask, other.mask)
        assert one.region == other.region
    command = copied(hand, "copy_command")
    words = shlex.split(command)
    masks, lines = tmp_path / "masks.tif", [tmp_path / "command.csv", tmp_path / "window.csv"]
    assert cli.main([*words[1 : words.index("--export")], "--export", str(masks), str(lines[0])]) == 0
    labels = np.asarray(PIL.Image.open(masks))
    for number, one in enumerate(shown, start=1):
        np.testing.assert_array_equal(labels == number, one.mask)
    assert labels.max() == len(shown)
    cpm.export(shown, lines[1], image=hand.window.session.image)
    assert [contour.points.tolist() for contour in cpm.load_contours(lines[0])] == [
        contour.points.tolist() for contour in cpm.load_contours(lines[1])
    ]
    return command


def test_a_run_with_its_start_limits_and_sliders_is_repeated(ready, hand, tmp_path) -> None:
    slow = replace(ready.session.document.parameters, beta=0.6, time_step=0.25)
    limit = PolygonRegion(((1.5, 1.5), (1.5, 62.5), (62.5, 62.5), (62.5, 1.5)))
    ready.session.edit("limit", lambda document: replace(document, shapes=(*document.shapes, limit), parameters=slow))
    selection = ready.workspace.object_selection
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    check_both(hand, tmp_path, tuple(each.selection for each in selection.proposals))


def test_clicks_and_corrections_are_repeated_in_their_order(window, hand, tmp_path) -> None:
    selection = window.workspace.object_selection
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: selection.ready and selection.idle)
    shown = []
    for places in (((42, 42),), ((18, 18), (18, 24), (30, 30)), ((16, 48),)):
        for number, place in enumerate(places):
            click(hand, *place, SHIFT if number == 2 else NONE)
        shown.append(selection.proposals[0].selection)
        if len(shown) < 3:
            hand.key(KEY.Key_Return)
            hand.wait(lambda: selection.idle and len(window.session.document.objects.items) == len(shown))
    check_both(hand, tmp_path, tuple(shown))


def test_objects_that_were_picked_of_those_of_a_run_and_one_of_another_size_are_repeated(ready, hand, tmp_path) -> None:
    selection, session = ready.workspace.object_selection, ready.session
    ready.actions_by_name["mode_automatic"].trigger()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and len(selection.proposals) == 3)
    shown = [each.selection for each in selection.proposals]
    hand.key(KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
    hand.key(KEY.Key_Return)
    hand.wait(lambda: selection.idle and len(session.document.objects.items) == 3)
    index = next(number for number, one in enumerate(shown) if one.mask[18, 18])
    ready.workspace.object_list.select_objects([session.document.objects.items[index].number])
    ready.actions_by_name["delete_object"].trigger()
    hand.wait(lambda: selection.idle and len(session.document.objects.items) == 2)
    gone = shown.pop(index)
    assert f"--pick {('2,3', '1,3', '1,2')[index]} " in check_both(hand, tmp_path, tuple(shown))

    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: selection.ready and selection.idle)
    click(hand, *np.argwhere(gone.mask).mean(axis=0))
    plain = selection.proposals[0].selection
    hand.key(KEY.Key_BracketRight)
    hand.wait(lambda: selection.idle and selection.proposals[0].selection.size > plain.size)
    shown.append(selection.proposals[0].selection)
    assert "--larger 1" in check_both(hand, tmp_path, tuple(shown))


def test_a_run_that_the_window_shows_is_not_repeated(ready, hand, tmp_path, monkeypatch) -> None:
    repeated = []
    run = session_code.run
    monkeypatch.setattr(session_code, "run", lambda *given, **named: repeated.append(1) or run(*given, **named))
    selection = ready.workspace.object_selection
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: selection.ready and selection.idle)
    click(hand, 42, 42)  # without a run, on contours that are found everywhere meanwhile
    hand.key(KEY.Key_Return)
    hand.wait(lambda: selection.idle and len(ready.session.document.objects.items) == 1)
    ready.session.edit("no start", lambda document: replace(document, shapes=()))
    hand.wait(lambda: selection.idle)
    assert "--object" in copied(hand, "copy_command")
    assert not repeated
    ready.session.edit("no object", lambda document: replace(document, objects=SegmentedObjects()))
    ready.actions_by_name["mode_automatic"].trigger()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and len(selection.proposals) == 3)
    hand.key(KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
    hand.key(KEY.Key_Return)
    hand.wait(lambda: selection.idle and len(ready.session.document.objects.items) == 3)
    assert copied(hand, "copy_command")
    assert not repeated
    ready.session.edit("damping", lambda document: edits.set_parameter(document, "beta", 0.7))
    hand.wait(lambda: ready.session.status.phase == "finished" and ready.session.idle)
    copied(hand, "copy_command")
    assert repeated  # what is shown has been steered


@pytest.mark.parametrize(("second", "ended"), [("copy_command", False), ("copy_view", False), ("copy_view", True)])
def test_what_was_copied_last_stays_on_the_clipboard(ready, hand, monkeypatch, second, ended) -> None:
    """A script that is still being checked, or just has been, when something else is copied does not take its place."""
    clipboard, go_on, find, begun = QApplication.clipboard(), threading.Event(), session_code._find_code, []

    def find_slowly_at_first(*given):
        begun.append(1)
        if len(begun) == 1:
            go_on.wait()
        return find(*given)

    monkeypatch.setattr(session_code, "_find_code", find_slowly_at_first)
    clipboard.clear()
    ready.actions_by_name["copy_python"].trigger()
    try:
        hand.wait(lambda: bool(begun))
        if ended:
            script = ready.session.tasks.current[-1]
            go_on.set()
            script.wait()
        ready.actions_by_name[second].trigger()
        hand.wait(lambda: clipboard.text().startswith("cpm ") or not clipboard.image().isNull())
    finally:
        go_on.set()
    hand.wait(lambda: ready.session.idle)
    assert "import" not in clipboard.text()


def test_contours_that_are_still_being_made_are_not_taken_for_those_of_the_run(ready, hand, monkeypatch) -> None:
    """A slider moved away and back has its value again before its contours."""
    session, selection = ready.session, ready.workspace.object_selection
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    hand.key(KEY.Key_Return)
    hand.wait(lambda: selection.idle and bool(session.document.objects.items) and session.idle)
    length = session.document.parameters.min_length
    session.edit("away", lambda document: edits.set_parameter(document, "min_length", 1e4))
    hand.wait(lambda: not session.scene.contours and session.idle)
    away, go_on, make = session.scene.result, threading.Event(), ReconstructionRequest.reconstruct
    monkeypatch.setattr(ReconstructionRequest, "reconstruct", lambda request: (go_on.wait(), make(request))[1])
    try:
        session.edit("back", lambda document: edits.set_parameter(document, "min_length", length))
        hand.wait(lambda: session.scene.timeline.parameters == session.document.parameters)
        assert session.scene.result is away
        assert "result.objects" in copied(hand, "copy_python")
    finally:
        go_on.set()


def test_a_copy_that_is_canceled_is_no_longer_announced(ready, hand, monkeypatch) -> None:
    def wait_for_cancel(*given):
        while True:
            given[-1].check_cancelled()
            time.sleep(0.001)

    monkeypatch.setattr(session_code, "_find_code", wait_for_cancel)
    messages = ready.canvas_area.messages
    ready.actions_by_name["copy_python"].trigger()
    assert messages.text == "The clipboard stays as it was until the copy is ready."
    hand.canvas.setFocus()
    hand.key(KEY.Key_Period, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: ready.session.tasks.idle)
    assert messages.text == ""
    ready.actions_by_name["copy_python"].trigger()
    ready.actions_by_name["copy_view"].trigger()  # which cancels it
    hand.wait(lambda: ready.session.tasks.idle)
    assert messages.text == "The view was copied."


@pytest.mark.parametrize("actions", [["reject"], ["accept", "delete_object"]], ids=["rejected", "deleted"])
def test_proposals_that_are_gone_are_left_out(ready, hand, tmp_path, actions) -> None:
    selection = ready.workspace.object_selection
    ready.actions_by_name["mode_automatic"].trigger()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and len(selection.proposals) == 3)
    first, _, last = (each.selection for each in selection.proposals)
    ready.workspace.object_list.select_objects([selection.proposals[1].key])
    for action in actions:
        ready.actions_by_name[action].trigger()
    hand.qtbot.wait(20)
    hand.wait(lambda: selection.idle and len(selection.proposals) == 2)
    check_both(hand, tmp_path, (first, last))


def test_of_a_run_whose_proposals_are_all_rejected_one_is_to_be_accepted_first(ready, hand, tmp_path) -> None:
    selection, messages = ready.workspace.object_selection, ready.canvas_area.messages
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    assert copied(hand, "copy_python")
    hand.key(KEY.Key_X)
    hand.wait(lambda: selection.idle and not selection.proposals)
    for action in ("copy_python", "copy_command"):
        assert copied(hand, action) == ""
        assert messages.text == "Accept an object and save the session first: another run would not offer the same."
    assert ready.document_file.save_and_wait(tmp_path / "rejected.cpm")
    assert copied(hand, "copy_python") == "" and messages.is_error


def test_an_object_without_clicks_is_found_again_among_those_of_the_run(ready, hand, tmp_path) -> None:
    """So it is for an object of a file that names no clicks."""
    selection, session = ready.workspace.object_selection, ready.session
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    shown = selection.proposals[0].selection
    hand.key(KEY.Key_Return)
    hand.wait(lambda: selection.idle and bool(session.document.objects.items))
    bare = replace(session.document.objects.items[0], clicks=())
    session.edit("bare", lambda document: replace(document, objects=replace(document.objects, items=(bare,))))
    hand.wait(lambda: selection.idle and session.idle)
    check_both(hand, tmp_path, (shown,))


def test_that_what_was_drawn_by_hand_needs_a_saved_session_is_known_without_a_run(ready, hand, monkeypatch) -> None:
    repeated = []
    monkeypatch.setattr(session_code, "run", lambda *given, **named: repeated.append(1))
    hand.canvas.setFocus()
    hand.key(KEY.Key_J)
    hand.drag((30, 20), (30, 30))
    hand.wait(lambda: bool(ready.session.document.objects.items))
    for action in ("copy_python", "copy_command"):
        assert copied(hand, action) == ""
    assert not repeated


def test_it_is_said_at_once_that_the_clipboard_stays_as_it_was_and_then_that_the_copy_is_ready(
    ready, hand, monkeypatch
) -> None:
    clipboard, messages, go_on, find = (
        QApplication.clipboard(), ready.canvas_area.messages, threading.Event(), session_code._find_code
    )  # fmt: skip
    monkeypatch.setattr(session_code, "_find_code", lambda *given: (go_on.wait(), find(*given))[1])
    clipboard.setText("old")
    ready.actions_by_name["copy_python"].trigger()
    try:
        assert messages.text == "The clipboard stays as it was until the copy is ready."
        assert clipboard.text() == "old"
    finally:
        go_on.set()
    hand.wait(lambda: messages.text == "Copied: paste it into a file or a terminal.")
    assert "import" in clipboard.text()


def test_what_was_drawn_by_hand_is_taken_from_the_saved_session(window, hand, tmp_path) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_J)
    hand.press(30, 20)
    hand.move(30, 30)
    hand.release(30, 30)
    hand.wait(lambda: bool(window.session.document.objects.items))
    assert copied(hand, "copy_python") == ""
    file = tmp_path / "hand.cpm"
    assert window.document_file.save_and_wait(file)
    (item,) = window.session.document.objects.items
    found: dict[str, object] = {}
    exec(copied(hand, "copy_python"), found)
    assert found["objects"][0].region == item.region
    words = shlex.split(copied(hand, "copy_command"))
    masks = tmp_path / "masks.tif"
    assert cli.main([*words[1 : words.index("--to")], "--to", str(masks)]) == 0
    np.testing.assert_array_equal(np.asarray(PIL.Image.open(masks)) == 1, item.region.paste((64, 64)))
