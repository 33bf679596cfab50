"""Runs stay on the timeline: a reset, another start or the same one again destroys none of them."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.session.timeline.timeline import MAX_TIMELINE_RUNS
from cpm_app.views.features.compare import CompareFeature
from PySide6.QtCore import Qt

from cpm_core.shapes import Circle
from tests.app.acting import run_to_the_end
from tests.app.reading import contour_counts, navigation

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL = Qt.KeyboardModifier.ControlModifier
LEFT = Qt.MouseButton.LeftButton


def names(window) -> list[str]:
    return [branch.name for branch in navigation(window).timeline_state.branches]


def shown(window) -> np.ndarray:
    position = window.session.scene.snapshot.position
    return position[np.lexsort(position.T)]


def wait_for_branch(window, hand, branch: int) -> None:
    hand.wait(lambda: navigation(window).timeline_state.branch == branch and window.session.idle)


def press_name(window, hand, branch: int) -> None:
    view = window.panels["timeline"].view
    point = view.step_position(branch, 0).toPoint()
    point.setX(12)
    hand.qtbot.mouseClick(view, LEFT, pos=point)


def run_from_elsewhere(window, hand) -> None:
    """Another circle in place of the first one, and a run."""
    window.session.edit("move", lambda document: edits.replace_shape(document, 0, Circle((30.0, 28.0), 6.0)))
    run_to_the_end(window, hand)


def test_a_reset_keeps_the_run_and_a_key_goes_back_to_it(rested, hand) -> None:
    panel, before, contours = rested.panels["timeline"], shown(rested), len(rested.session.status.contours)
    hand.canvas.setFocus()
    hand.key(KEY.Key_R)
    hand.wait(lambda: rested.session.idle)
    assert rested.session.status.phase == "ready"
    assert rested.session.scene.snapshot is None
    assert names(rested) == ["Run 1"]
    assert not panel.step.isEnabled()
    hand.key(KEY.Key_End, CONTROL)
    hand.wait(lambda: rested.session.scene.snapshot is not None and rested.session.idle)
    np.testing.assert_array_equal(shown(rested), before)
    assert rested.session.status.phase == "finished"
    hand.wait(lambda: len(rested.session.status.contours) == contours)
    assert not rested.session.status.stale


def test_a_run_from_another_start_is_a_run_beside_the_first(rested, hand) -> None:
    first = shown(rested)
    run_from_elsewhere(rested, hand)
    second = shown(rested)
    assert names(rested) == ["Run 1", "Run 2"]
    assert not rested.session.status.stale
    press_name(rested, hand, 1)
    wait_for_branch(rested, hand, 1)
    np.testing.assert_array_equal(shown(rested), first)
    assert rested.session.status.stale  # its start is no longer drawn
    press_name(rested, hand, navigation(rested).timeline_state.branches[1].identity)
    wait_for_branch(rested, hand, navigation(rested).timeline_state.branches[1].identity)
    np.testing.assert_array_equal(shown(rested), second)
    assert not rested.session.status.stale


def test_a_run_is_compared_with_another_run(rested, hand) -> None:
    run_from_elsewhere(rested, hand)
    compared, wipe = rested.workspace.comparison, rested.get_feature(CompareFeature).wipe
    assert [row.title for row in compared.rows.values()] == ["Shown now", "Run 1", "Run 2"]
    compared.select_row(1)
    hand.wait(lambda: 1 in compared.agreements)
    assert compared.agreements[1].hausdorff < 1.0
    hand.wait(lambda: sum(contour_counts(wipe.mirror.layers.contours)) > 0)
    navigation(rested).remove_branch(1)
    hand.wait(lambda: wipe.mirror is None)
    assert [row.title for row in compared.rows.values()] == ["Shown now", "Run 2"]


def test_a_run_of_another_mode_is_left_and_found_again(rested, hand) -> None:
    first = shown(rested)
    hand.key(KEY.Key_F3, Qt.KeyboardModifier.ControlModifier)
    assert rested.session.document.mode == "skeleton"
    run_to_the_end(rested, hand)
    assert rested.session.status.method == "skeleton"
    assert names(rested) == ["Run 1", "Run 2"]
    press_name(rested, hand, 1)
    wait_for_branch(rested, hand, 1)
    assert rested.session.status.method == "cpm"
    np.testing.assert_array_equal(shown(rested), first)


def test_the_run_that_is_gone_back_to_can_be_deleted(rested, hand) -> None:
    run_from_elsewhere(rested, hand)
    press_name(rested, hand, 1)
    wait_for_branch(rested, hand, 1)
    rested.actions_by_name["timeline_delete"].trigger()
    hand.wait(lambda: names(rested) == ["Run 2"] and rested.session.idle)
    assert navigation(rested).timeline_state.branch == navigation(rested).timeline_state.branches[0].identity


def test_who_runs_too_often_is_told_which_runs_are_gone(rested, hand) -> None:
    said: list[str] = []
    rested.session.messages.shown.connect(lambda text, _: said.append(text))
    for number in range(MAX_TIMELINE_RUNS):
        rested.session.edit("beta", lambda d, n=number: edits.set_parameter(d, "beta", 1.0 + 0.01 * n))
        rested.session.reset()
        rested.session.step()
        hand.wait(lambda: rested.session.idle)
    assert names(rested)[0] == "Run 2"
    assert [text for text in said if text.startswith("Run 1 ")]
