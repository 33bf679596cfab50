"""The line below the image says after a run what was found and what Enter will do, whatever tool is in use."""

from __future__ import annotations

import pytest
from cpm_app.session.features import outcome
from cpm_app.session.features.object_selection import ObjectSelection
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
    assert said.startswith("1 object found")
    assert "Enter accepts it" in said
    hand.key(KEY.Key_Return)
    assert len(ready.session.document.objects.items) == 1
    assert "Enter accepts" not in ready.canvas_area.hint.text()


def test_the_tool_speaks_again_once_it_is_chosen(ready, hand) -> None:
    said = end_run(ready, hand)
    hand.key(KEY.Key_B)
    assert ready.canvas_area.hint.text() != said
    assert "no particle crosses" in ready.canvas_area.hint.text()


def test_an_object_that_is_not_sure_is_not_called_found(ready, hand, monkeypatch) -> None:
    monkeypatch.setattr(outcome, "MIN_SURE_CONFIDENCE", 1.1)
    assert end_run(ready, hand) == "Nothing sure was found: click an object. Enter accepts the doubtful one."


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
