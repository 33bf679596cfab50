"""The line below the image says after a run what was found and what Enter will do, whatever tool is in use."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest
from cpm_app.session.features import object_selection
from cpm_app.session.features.object_selection import ObjectSelection
from cpm_app.session.features.outcome import describe_outcome
from cpm_app.session.features.selector import find_proposals
from cpm_app.session.worker.reconstruction import ReconstructionRequest
from PySide6.QtCore import Qt

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL = Qt.KeyboardModifier.ControlModifier


def end_run(window, hand) -> str:
    """Run to the end with the mending tool in hand, and return the sentence below the image."""
    hand.key(KEY.Key_J)
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    selection = window.workspace.object_selection
    hand.wait(lambda: window.session.idle and selection.idle and selection.offer_is_known)
    return window.canvas_area.hint.text()


def test_objects_that_were_found_are_counted_and_enter_accepts_them(ready, hand) -> None:
    said = end_run(ready, hand)
    assert said.startswith("1 proposal")
    assert "Enter accepts it" in said
    hand.key(KEY.Key_Return)
    assert len(ready.session.document.objects.items) == 1
    ready.workspace.object_list.select_objects(())
    hand.wait(lambda: ready.canvas_area.hint.text() == "Objects: 1. Ctrl+E exports them.")


def test_enter_accepts_the_objects_of_a_run_that_are_being_found_once_they_are_offered(
    ready, hand, monkeypatch
) -> None:
    shown = threading.Event()
    monkeypatch.setattr(object_selection, "find_proposals", lambda *given: shown.wait() and find_proposals(*given))
    selection = ready.workspace.object_selection
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: not selection.offer_is_known and not selection.idle)
    hand.key(KEY.Key_Return)
    hand.wait(lambda: ready.canvas_area.hint.text().endswith("The objects of the run are still being found."))
    assert ready.canvas_area.crosshair.position is None
    assert not ready.session.document.objects.items
    shown.set()
    hand.wait(lambda: selection.idle and selection.offer_is_known)
    assert len(ready.session.document.objects.items) == 1


@pytest.mark.parametrize("fails", [False, True])
def test_enter_right_at_the_end_of_a_run_waits_for_the_contours_of_its_last_step(
    ready, hand, monkeypatch, fails
) -> None:
    may_make, make = threading.Event(), ReconstructionRequest.reconstruct

    def make_late(request):
        may_make.wait(60)
        if fails:
            raise ValueError("no contours")
        return make(request)

    monkeypatch.setattr(ReconstructionRequest, "reconstruct", make_late)
    selection, area = ready.workspace.object_selection, ready.canvas_area
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.key(KEY.Key_Return)
    assert selection.has_waiting_keys
    assert area.crosshair.position is None
    may_make.set()
    hand.wait(lambda: ready.session.idle and selection.idle and not selection.has_waiting_keys)
    assert "waits" not in area.hint.text()
    assert len(ready.session.document.objects.items) == (0 if fails else 1)


def test_what_is_said_of_an_edit_gives_way_to_the_cross_hair_and_to_a_run(ready, hand) -> None:
    ready.canvas_area.canvas.setFocus()
    hand.click(5.0, 5.0)
    assert ready.canvas_area.messages.text.startswith("Keep the button down.")
    hand.key(KEY.Key_Return)
    assert ready.canvas_area.messages.text == ""
    assert ready.canvas_area.hint.text().startswith("Arrow keys move the cross-hair")
    hand.key(KEY.Key_Escape)
    hand.click(5.0, 5.0)
    hand.key(KEY.Key_Space)
    assert ready.canvas_area.messages.text == ""
    hand.wait_for_phase("finished")


def test_that_none_is_offered_is_not_said_of_contours_from_before_the_end(ready, hand) -> None:
    end_run(ready, hand)
    hand.key(KEY.Key_X)
    hand.wait(lambda: not ready.workspace.object_selection.proposals)
    store = ready.session.store
    assert "All proposals are rejected" in describe_outcome(ready.workspace)
    before_end = replace(store.scene.reconstruction, result=replace(store.scene.result, stop_reason=""))
    store.set_scene(replace(store.scene, reconstruction=before_end))
    assert "All proposals are rejected" not in describe_outcome(ready.workspace)


def test_the_tool_speaks_again_once_it_is_chosen(ready, hand) -> None:
    said = end_run(ready, hand)
    hand.key(KEY.Key_B)
    assert ready.canvas_area.hint.text() != said
    assert "no particle crosses" in ready.canvas_area.hint.text()


def test_that_all_proposals_are_rejected_is_said_with_what_brings_them_back(ready, hand) -> None:
    end_run(ready, hand)
    panel = ready.panels["objects"]
    ready.docks.reveal_panel("objects")
    hand.key(KEY.Key_X)
    said = "All proposals are rejected: undo that (Ctrl+Z), or click one again (W)."
    hand.wait(lambda: panel.summary.text() == said)
    hand.wait(lambda: describe_outcome(ready.workspace).endswith(said))
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: panel.summary.text() == "1 proposal")
    hand.key(KEY.Key_X)
    hand.wait(lambda: not ready.workspace.object_selection.proposals)
    hand.key(KEY.Key_W)
    hand.click(32.0, 32.0)
    hand.wait(lambda: panel.summary.text() == "1 proposal")


def test_undo_is_not_advised_where_it_brings_no_proposal_back(ready, hand, tmp_path) -> None:
    end_run(ready, hand)
    hand.key(KEY.Key_X)
    hand.wait(lambda: describe_outcome(ready.workspace).endswith("or click one again (W)."))
    ready.session.edit("draw", lambda document: replace(document, shapes=()))
    said = "All proposals are rejected: click one again (W)."
    assert describe_outcome(ready.workspace).endswith(said)
    assert ready.document_file.save_and_wait(tmp_path / "rejected.cpm")
    with hand.qtbot.waitSignal(ready.session.image_changed):
        ready.session.open_file(tmp_path / "rejected.cpm")
    assert not ready.actions_by_name["undo"].isEnabled()
    hand.wait(lambda: describe_outcome(ready.workspace).endswith(said))
    hand.wait(lambda: said in ready.canvas_area.hint.text())


def test_a_run_that_offers_nothing_is_not_said_to_have_been_rejected(ready, hand, monkeypatch) -> None:
    end_run(ready, hand)
    hand.key(KEY.Key_X)
    hand.wait(lambda: describe_outcome(ready.workspace).endswith("or click one again (W)."))
    monkeypatch.setattr(object_selection, "find_proposals", lambda *given: ())
    ready.workspace.object_selection.search_again()
    hand.wait(lambda: describe_outcome(ready.workspace).endswith("No object is offered: click one (W)."))


def test_what_became_of_an_edit_is_said_until_the_next_one_and_other_news_for_a_while(ready, hand) -> None:
    end_run(ready, hand)
    line = ready.canvas_area.messages
    interval = line._timer.interval()
    line._timer.setInterval(1)
    hand.key(KEY.Key_X)
    said = "Rejected proposals: 1. Ctrl+Z brings them back."
    hand.qtbot.wait(20)
    assert line.text == said
    hand.key(KEY.Key_Z, CONTROL)
    assert line.text == ""
    ready.session.messages.show("The view was copied.", category="exporting")
    hand.wait(lambda: line.text == "")
    hand.key(KEY.Key_X)
    hand.key(KEY.Key_W)
    assert line.text == ""
    line._timer.setInterval(interval)


def test_objects_that_are_being_found_are_not_said_to_be_missing(ready, hand, monkeypatch) -> None:
    shown = threading.Event()
    monkeypatch.setattr(object_selection, "find_proposals", lambda *given: shown.wait() and find_proposals(*given))
    selection, panel = ready.workspace.object_selection, ready.panels["objects"]
    ready.docks.reveal_panel("objects")
    hand.wait(lambda: panel.summary.text() == "Nothing yet. Click an object with the Objects tool (W), or run.")
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: not selection.offer_is_known and not selection.idle)
    ready.docks.reveal_panel("objects")
    hand.wait(lambda: panel.summary.text() == "The objects of the run are still being found.")
    shown.set()
    hand.wait(lambda: panel.summary.text() == "1 proposal")


DOUBTFUL = "Doubtful (below 70 %): 1. Click or Ctrl+A, then Enter: accept · X: reject"


def make_unlikely(monkeypatch) -> None:
    """Let nothing that a run finds be likely."""

    def find_unlikely(*arguments):
        found = find_proposals(*arguments)
        return tuple(replace(each, selection=replace(each.selection, confidence=0.06)) for each in found)

    monkeypatch.setattr(object_selection, "find_proposals", find_unlikely)


def test_almost_no_confidence_is_remarked_of_a_proposal_of_a_run_as_of_a_click(ready, hand, monkeypatch) -> None:
    monkeypatch.setattr("cpm_core.objects.partition.estimate_confidence", lambda features: 0.01)
    said = end_run(ready, hand)
    assert said.startswith("There may be no object here: the confidence is almost zero. 1 proposal, 1 %.")


def test_enter_accepts_an_unlikely_object_only_once_it_is_selected(window, hand, monkeypatch) -> None:
    make_unlikely(monkeypatch)
    window.actions_by_name["start_grid"].trigger()
    said = end_run(window, hand)
    assert said == DOUBTFUL
    with hand.qtbot.waitSignal(window.session.messages.shown) as shown:
        hand.key(KEY.Key_Return)
    assert shown.args[0] == said
    assert not window.session.document.objects.items
    (row,) = window.workspace.object_list.rows
    hand.key(KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
    assert window.workspace.object_list.selected_keys == {row.key}
    hand.key(KEY.Key_Return)
    assert [item.confidence for item in window.session.document.objects.items] == [0.06]


def test_what_enter_leaves_is_not_said_to_be_all_that_was_found(window, hand, monkeypatch, tmp_path) -> None:
    def find_one_unlikely(*arguments):
        first, *others = find_proposals(*arguments)
        return first, *(replace(one, selection=replace(one.selection, confidence=0.06)) for one in others)

    monkeypatch.setattr(object_selection, "find_proposals", find_one_unlikely)
    rows, cols = np.ogrid[:60, :110]
    np.save(tmp_path / "discs.npy", 200.0 * ((rows - 30) ** 2 + (cols % 55 - 27) ** 2 < 15**2))
    with hand.qtbot.waitSignal(window.session.image_changed):
        window.session.open_file(tmp_path / "discs.npy")
    window.actions_by_name["start_grid"].trigger()
    assert end_run(window, hand).startswith("2 proposals, 1 doubtful.")
    with hand.qtbot.waitSignal(window.session.messages.shown) as shown:
        hand.key(KEY.Key_Return)
    assert len(window.session.document.objects.items) == 1
    assert shown.args[0] == DOUBTFUL
    listed, panel = window.workspace.object_list, window.panels["objects"]
    assert not listed.selected_keys
    assert window.canvas_area.hint.text() == shown.args[0]
    window.docks.reveal_panel("objects")
    panel.show_selected()
    assert panel.figures.text() == ""  # nothing is selected, and Enter would take nothing
    hand.canvas.setFocus()
    hand.key(KEY.Key_X)
    assert len(window.session.document.objects.items) == len(window.session.document.objects.rejected) == 1
    listed.select_items([listed.rows[-1].key])
    panel.show_selected()
    assert panel.figures.text().startswith("proposal · ")


def test_the_only_object_of_a_drawn_start_is_the_own_of_the_user(ready, hand, monkeypatch) -> None:
    make_unlikely(monkeypatch)
    assert end_run(ready, hand).startswith("1 proposal, 6 %. Enter accepts it")
    hand.key(KEY.Key_Return)
    assert len(ready.session.document.objects.items) == 1


def test_contours_without_an_object_are_counted_and_a_click_is_advised(window, hand, monkeypatch) -> None:
    hand.drag((32.0, 32.0), (32.0, 38.0), (32.0, 42.0))
    monkeypatch.setattr(ObjectSelection, "_find_offered", lambda *_: ())
    said = end_run(window, hand)
    assert said == "1 closed contour, 0 open. No object is offered: click one (W)."


def test_a_skeleton_is_described_and_exported(window, hand) -> None:
    hand.key(KEY.Key_F3, CONTROL)
    said = end_run(window, hand)
    assert said.startswith("1 branch, ")
    assert said.endswith("exports it.")
