"""The timeline in the window: scrubbed, stepped through, branched and compared by mouse and keys."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from cpm_app.model.preferences.table import TIMELINE_MEMORY
from cpm_app.session.timeline.timeline import BYTES_PER_MEGABYTE, Timeline
from cpm_app.session.worker.commands import WorkerCommand
from cpm_app.views import features
from cpm_app.views.features.compare import CompareFeature
from cpm_app.views.widgets.actions import ActionButton
from cpm_app.views.widgets.containers import ElidedLabel
from cpm_app.views.window.preferences import PreferencesDialog
from PySide6.QtCore import Qt

from cpm_core import PRESETS, Engine
from cpm_core.model.starts import circle
from cpm_core.model.state import State
from tests.app.reading import contour_counts, navigation

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
SHIFT, CONTROL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def fresh(ready) -> list[State]:
    """The states of the same run, computed without a window."""
    engine = Engine(ready.session.image, PRESETS["shape"])
    states = [engine.start(circle((32.0, 32.0), 10.0))]
    while not states[-1].stop_reason:
        states.append(engine.step(states[-1], PRESETS["shape"]))
    return states


def shown(window) -> np.ndarray:
    """Positions of the particles on the canvas, in the order of rows and columns."""
    position = window.canvas_area.canvas.layers.particles.position
    return position[np.lexsort(position.T)]


def ordered(state: State) -> np.ndarray:
    return state.position[np.lexsort(state.position.T)]


def wait_for_step(window, hand, step: int) -> None:
    hand.wait(lambda: window.session.status.step == step and window.session.idle)


def scrub(window, hand, branch: int, *steps: int) -> None:
    """Press on the first step and drag through the others."""
    view = window.panels["timeline"].view
    points = [view.step_position(branch, step).toPoint() for step in steps]
    hand.qtbot.mousePress(view, LEFT, pos=points[0])
    for point in points[1:]:
        hand.qtbot.mouseMove(view, point)
    hand.qtbot.mouseRelease(view, LEFT, pos=points[-1])


def go_on_otherwise(window, hand) -> None:
    """Change the damping by its slider, and run to the end."""
    hand.qtbot.keyClick(window.panels["run"].parameters.rows["beta"].slider, KEY.Key_PageUp)
    assert window.session.document.parameters.beta > PRESETS["shape"].beta
    window.canvas_area.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.idle)


def test_scrubbing_back_shows_exactly_the_particles_of_that_step(rested, hand, fresh) -> None:
    assert rested.session.status.step == fresh[-1].step
    scrub(rested, hand, 1, 10, 25, 60, 40)
    step = navigation(rested).current_step[1]
    assert abs(step - 40) <= 1  # a pixel of the timeline may be more than a step
    wait_for_step(rested, hand, step)
    assert rested.session.status.phase == "paused"
    np.testing.assert_array_equal(shown(rested), ordered(fresh[step]))
    numbers = {label.accessibleName(): label.text() for label in rested.panels["run"].findChildren(ElidedLabel)}
    assert numbers["Step"] == str(step)
    assert len(rested.session.scene.snapshot.metrics.step) == step


def test_continuing_differently_from_an_earlier_step_keeps_both_branches(rested, hand, fresh) -> None:
    panel = rested.panels["timeline"]
    panel.step.setFocus()
    panel.step.selectAll()
    hand.qtbot.keyClicks(panel.step, "40")
    hand.qtbot.keyClick(panel.step, KEY.Key_Return)
    wait_for_step(rested, hand, 40)
    np.testing.assert_array_equal(shown(rested), ordered(fresh[40]))
    go_on_otherwise(rested, hand)
    kept, new = navigation(rested).timeline_state.branches
    assert (kept.last, new.parent, new.first) == (fresh[-1].step, kept.identity, 40)
    engine, state = Engine(rested.session.image, PRESETS["shape"]), fresh[40]
    for _ in range(20):
        state = engine.step(state, rested.session.document.parameters)
    scrub(rested, hand, new.identity, 45)
    panel.view.setFocus()
    while navigation(rested).current_step[1] != 60:
        hand.key(KEY.Key_Right if navigation(rested).current_step[1] < 60 else KEY.Key_Left)
    wait_for_step(rested, hand, 60)
    np.testing.assert_array_equal(shown(rested), ordered(state))
    hand.key(KEY.Key_Up)
    hand.wait(lambda: navigation(rested).timeline_state.branch == kept.identity and rested.session.idle)
    np.testing.assert_array_equal(shown(rested), ordered(fresh[60]))
    assert not np.array_equal(ordered(state), ordered(fresh[60]))


def test_a_compared_branch_is_shown_at_its_end_or_at_the_same_step(rested, hand, fresh) -> None:
    scrub(rested, hand, 1, 40)
    hand.wait(lambda: rested.session.status.phase == "paused" and rested.session.idle)
    go_on_otherwise(rested, hand)
    compared, wipe = rested.workspace.comparison, rested.get_feature(CompareFeature).wipe
    row = 1
    compared.select_row(row)
    hand.wait(lambda: sum(contour_counts(wipe.mirror.layers.contours)) > 0)
    beyond = wipe.mirror.layers.particles
    np.testing.assert_array_equal(np.sort(beyond.position, axis=0), np.sort(fresh[-1].position, axis=0))
    hand.canvas.setFocus()
    for _ in range(3):
        hand.key(KEY.Key_Comma)
    step = navigation(rested).current_step[1]
    wait_for_step(rested, hand, step)
    hand.wait(lambda: compared.rows[row].scene.snapshot.state.step == min(step, fresh[-1].step))
    assert beyond.count == fresh[min(step, fresh[-1].step)].count


def test_steps_backwards_return_exactly_and_forwards_repeat_the_branch(rested, hand, fresh) -> None:
    hand.canvas.setFocus()
    last = fresh[-1].step
    for back in range(1, 6):
        hand.key(KEY.Key_Comma)
        wait_for_step(rested, hand, last - back)
        np.testing.assert_array_equal(shown(rested), ordered(fresh[last - back]))
    for forward in range(1, 3):
        hand.key(KEY.Key_Period)
        wait_for_step(rested, hand, last - 5 + forward)
        np.testing.assert_array_equal(shown(rested), ordered(fresh[last - 5 + forward]))
    assert len(navigation(rested).timeline_state.branches) == 1
    assert navigation(rested).last_step(1) == last
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    assert rested.session.status.step == last
    assert len(navigation(rested).timeline_state.branches) == 1


def test_going_back_during_a_run_pauses_it(ready, hand) -> None:
    ready.session.set_pace(60.0)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: ready.session.status.step >= 12)
    scrub(ready, hand, 1, 5)
    hand.wait(lambda: ready.session.idle)
    assert ready.session.status.phase == "paused"
    assert abs(ready.session.status.step - 5) <= 1
    assert navigation(ready).last_step(1) >= 12


def waiting(gate: threading.Event) -> WorkerCommand:
    """Blocks the worker until it is released."""
    return WorkerCommand(lambda _: gate.wait(20))


def test_of_many_requested_steps_only_the_last_is_computed(rested, hand, monkeypatch) -> None:
    gone: list[int] = []
    go_to, gate = Timeline.go_to, threading.Event()
    monkeypatch.setattr(Timeline, "go_to", lambda timeline, *at: gone.append(at[1]) or go_to(timeline, *at))
    rested.session.post_command(waiting(gate))
    scrub(rested, hand, 1, *range(5, 60))
    step = navigation(rested).current_step[1]
    assert abs(step - 59) <= 1
    assert rested.panels["timeline"].step.value() == step  # shown at once, before anything has been computed
    gate.set()
    wait_for_step(rested, hand, step)
    assert gone == [step]


def test_branches_are_named_and_deleted(rested, hand, fresh, monkeypatch) -> None:
    scrub(rested, hand, 1, 40)
    hand.wait(lambda: rested.session.status.phase == "paused" and rested.session.idle)
    assert not rested.actions_by_name["timeline_delete"].isEnabled()
    go_on_otherwise(rested, hand)
    monkeypatch.setattr(features.run, "ask_for_text", lambda *_: "stiffer")
    rested.actions_by_name["timeline_rename"].trigger()
    hand.wait(lambda: [branch.name for branch in navigation(rested).timeline_state.branches] == ["Run 1", "stiffer"])
    fork = navigation(rested).timeline_state.branches[1].first
    rested.actions_by_name["timeline_delete"].trigger()
    hand.wait(lambda: len(navigation(rested).timeline_state.branches) == 1 and rested.session.idle)
    assert rested.session.status.step == fork
    np.testing.assert_array_equal(shown(rested), ordered(fresh[fork]))
    assert not rested.actions_by_name["timeline_delete"].isEnabled()


def test_setting_the_parameters_of_a_step_again_repeats_its_branch(rested, hand, fresh) -> None:
    first = rested.session.document.parameters
    scrub(rested, hand, 1, 40)
    hand.wait(lambda: rested.session.status.phase == "paused" and rested.session.idle)
    set_again = rested.panels["timeline"].findChild(ActionButton, "timeline_parameters")
    assert not set_again.isEnabled()
    go_on_otherwise(rested, hand)
    scrub(rested, hand, 1, 50)
    step = navigation(rested).current_step[1]
    wait_for_step(rested, hand, step)
    assert set_again.isEnabled()
    assert "other values than the sliders show" in rested.canvas_area.hint.text()
    hand.qtbot.mouseClick(set_again, LEFT)
    assert rested.session.document.parameters == first
    assert "other values" not in rested.canvas_area.hint.text()
    assert not set_again.isEnabled()
    assert "parameters of step" in rested.actions_by_name["undo"].text()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Period)
    wait_for_step(rested, hand, step + 1)
    np.testing.assert_array_equal(shown(rested), ordered(fresh[step + 1]))
    assert navigation(rested).timeline_state.branch == 1
    assert len(navigation(rested).timeline_state.branches) == 2


def timeline_of(window):
    return window.session._worker_thread.run.timeline


def test_the_memory_set_in_the_preferences_acts_at_once(rested, hand, fresh) -> None:
    hand.key(KEY.Key_Comma, CONTROL)
    (dialog,) = rested.findChildren(PreferencesDialog)
    dialog.turn_to("run")
    field = dialog.rows["Memory for steps"]
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, "16")
    hand.qtbot.keyClick(field, KEY.Key_Return)
    assert rested.preferences.read_preference(TIMELINE_MEMORY) == 16
    hand.wait(lambda: timeline_of(rested)._states.budget == 16 * BYTES_PER_MEGABYTE)
    hand.qtbot.keyClick(dialog, KEY.Key_Escape)
    hand.wait(lambda: not rested.findChildren(PreferencesDialog))
    navigation(rested).go_by(-1)
    wait_for_step(rested, hand, fresh[-1].step - 1)


@pytest.mark.own_window
def test_with_very_little_memory_every_step_is_still_exact(rested, hand, fresh) -> None:
    timeline_of(rested).set_budget(1)
    for step in (40, 3, 57, 56):
        navigation(rested).go_to(1, step)
        wait_for_step(rested, hand, step)
        np.testing.assert_array_equal(shown(rested), ordered(fresh[step]))
    assert len(timeline_of(rested)._states) <= 2
