"""A session brings back what was seen: contours, the run with its steering, its branches, the truth, the step shown."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.session.worker.commands import call_run
from cpm_app.session.worker.run import Run
from cpm_app.views.features.run import TimelineFeature
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QToolButton

from cpm_core.formats.sessions.recorded_run import restore_shown_state
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.shapes import Circle
from tests.app.acting import run_to_the_end
from tests.app.reading import document_file, navigation

pytestmark = pytest.mark.shared_window

KEY = Qt.Key


@pytest.fixture
def steered(ready, hand):
    """A window with a run, a branch of it with another damping, and a run from elsewhere."""
    session = ready.session
    run_to_the_end(ready, hand)
    navigation(ready).go_to(1, 10)
    hand.wait(lambda: session.idle and session.status.step == 10)
    session.edit("beta", lambda document: edits.set_parameter(document, "beta", 1.4))
    run_to_the_end(ready, hand)
    session.edit("move", lambda document: edits.replace_shape(document, 0, Circle((30.0, 28.0), 6.0)))
    run_to_the_end(ready, hand)
    return ready


def saved(window, hand, path: Path) -> Path:
    document_file(window).save(path)
    hand.wait(lambda: path.exists() and not document_file(window).unsaved and window.session.idle)
    return path


def reopened(window, hand, path: Path) -> list[str]:
    """Open a file again; what is said meanwhile."""
    said: list[str] = []
    opened: list[bool] = []
    window.session.messages.shown.connect(lambda text, _: said.append(text))
    window.session.image_changed.connect(lambda: opened.append(True))
    window.session.open_file(path)
    hand.wait(lambda: bool(opened) and window.session.idle and not window.session.status.busy)
    return said


def particles(window) -> bytes:
    state = window.session.scene.snapshot.state
    return b"".join(getattr(state.particles, name).tobytes() for name in ("position", "velocity", "identity"))


def lines(window) -> list[bytes]:
    return [contour.points.tobytes() for contour in window.session.scene.contours]


def test_what_was_seen_is_there_again(steered, hand, tmp_path) -> None:
    before, contours = particles(steered), lines(steered)
    figures = steered.session.scene.snapshot.metrics
    names = [(branch.name, branch.first) for branch in navigation(steered).timeline_state.branches]
    assert [name for name, _ in names] == ["Run 1", "Branch 1", "Run 2"]
    reopened(steered, hand, saved(steered, hand, tmp_path / "a.cpm"))
    assert particles(steered) == before
    assert lines(steered) == contours
    assert [(branch.name, branch.first) for branch in navigation(steered).timeline_state.branches] == names
    status = steered.session.status
    assert (status.phase, status.stale, status.steered) == ("finished", False, False)
    np.testing.assert_array_equal(steered.session.scene.snapshot.metrics.epsilon, figures.epsilon)
    assert not document_file(steered).unsaved


def test_every_step_and_its_steering_can_be_gone_back_to(steered, hand, tmp_path) -> None:
    places = [(1, 10), (1, 25), (2, 12), (2, 30), (3, 3)]

    def at(branch: int, step: int) -> bytes:
        navigation(steered).go_to(branch, step)
        hand.wait(lambda: steered.session.idle and navigation(steered).current_step == (branch, step))
        hand.wait(lambda: steered.session.status.step == step)
        return particles(steered)

    before = [at(*place) for place in places]
    saved(steered, hand, tmp_path / "a.cpm")
    reopened(steered, hand, tmp_path / "a.cpm")
    assert navigation(steered).current_step == places[-1]
    assert [at(*place) for place in places] == before


def test_a_shown_run_for_which_there_is_no_memory_left_is_no_failure(steered, hand, tmp_path) -> None:
    navigation(steered).go_to(1, 10)
    hand.wait(lambda: steered.session.idle and steered.session.status.step == 10)
    saved(steered, hand, tmp_path / "a.cpm")
    steered.session.post_command(call_run(None, Run.set_timeline_budget, 0))
    said = reopened(steered, hand, tmp_path / "a.cpm")
    steered.get_feature(TimelineFeature).apply_memory_limit()
    assert [branch.name for branch in navigation(steered).timeline_state.branches] == ["Run 2"]
    assert not [text for text in said if "no longer exists" in text]


def test_a_paused_run_goes_on_as_if_the_window_had_stayed_open(ready, hand, tmp_path) -> None:
    for _ in range(13):
        ready.session.step()
    hand.wait(lambda: ready.session.idle)
    saved(ready, hand, tmp_path / "a.cpm")
    run_to_the_end(ready, hand)
    end = particles(ready)
    reopened(ready, hand, tmp_path / "a.cpm")
    assert (ready.session.status.phase, ready.session.status.step) == ("paused", 13)
    run_to_the_end(ready, hand)
    assert particles(ready) == end


def test_an_intervention_is_repeated_after_opening(ready, hand, tmp_path) -> None:
    session = ready.session
    for _ in range(8):
        session.step()
    session.edit("draw", lambda document: edits.add_shape(document, Circle((20.0, 20.0), 5.0)))
    session.erase(((32.0, 42.0), (34.0, 42.0)), 3.0, "erase")
    for _ in range(8):
        session.step()
    hand.wait(lambda: session.idle)
    before = particles(ready)
    content = json.loads(saved(ready, hand, tmp_path / "a.cpm").read_text())
    assert {"step", "join", "erase"} <= {key for one in content["runs"]["runs"][0]["actions"] for key in one}
    content["runs"]["states"] = []
    (tmp_path / "b.cpm").write_text(json.dumps(content))
    reopened(ready, hand, tmp_path / "b.cpm")
    assert particles(ready) == before
    assert not session.status.stale


def test_a_session_saved_at_a_step_that_a_branch_shares_is_whole(steered, hand, tmp_path) -> None:
    session = steered.session

    def save_and_reopen() -> None:
        shown, before = navigation(steered).current_step, particles(steered)
        said = reopened(steered, hand, saved(steered, hand, tmp_path / "a.cpm"))
        assert (said, navigation(steered).current_step) == ([], shown)
        assert particles(steered) == before

    def go_to(branch: int, step: int) -> None:
        navigation(steered).go_to(branch, step)
        hand.wait(lambda: session.idle and session.status.step == step)

    for place in [(1, 0), (2, 10), (2, 4)]:
        go_to(*place)
        save_and_reopen()
    session.edit("draw", lambda document: edits.add_shape(document, Circle((20.0, 20.0), 5.0)))  # begins a branch
    hand.wait(lambda: session.idle)
    assert navigation(steered).current_step == (4, 4)
    save_and_reopen()


def test_a_run_that_was_reset_is_on_the_timeline_after_opening(ready, hand, tmp_path) -> None:
    run_to_the_end(ready, hand)
    hand.key(KEY.Key_R)
    hand.wait(lambda: ready.session.idle)
    reopened(ready, hand, saved(ready, hand, tmp_path / "a.cpm"))
    assert ready.session.status.phase == "ready"
    assert [branch.name for branch in navigation(ready).timeline_state.branches] == ["Run 1"]


def test_a_run_is_there_again_as_it_was_after_another_mode_has_been_chosen(ready, hand, tmp_path) -> None:
    hand.qtbot.mouseClick(ready.findChild(QToolButton, "mode_automatic"), Qt.MouseButton.LeftButton)
    run_to_the_end(ready, hand)
    hand.qtbot.mouseClick(ready.findChild(QToolButton, "mode_shape"), Qt.MouseButton.LeftButton)
    hand.wait(lambda: ready.session.idle)
    found, contours = ready.session.scene.reconstruction.result.provenance, lines(ready)
    reopened(ready, hand, saved(ready, hand, tmp_path / "a.cpm"))
    assert ready.session.document.mode == "shape"
    assert ready.session.scene.reconstruction.result.provenance.parameters == found.parameters
    assert lines(ready) == contours


def test_contours_selected_by_a_slider_at_rest_are_there_again_in_another_mode(ready, hand, tmp_path) -> None:
    """So they are for `cpm export`, which shows what the window shows."""
    run_to_the_end(ready, hand)
    contours, begun = lines(ready), ready.session.document.parameters
    ready.session.edit("length", lambda document: edits.set_parameter(document, "min_length", 1e4))
    hand.wait(lambda: lines(ready) != contours)
    hand.wait(lambda: ready.session.idle)
    assert not lines(ready)
    hand.qtbot.mouseClick(ready.findChild(QToolButton, "mode_automatic"), Qt.MouseButton.LeftButton)
    hand.wait(lambda: ready.session.idle)
    path = saved(ready, hand, tmp_path / "a.cpm")
    reopened(ready, hand, path)
    assert ready.session.document.mode == "automatic"
    assert not lines(ready)
    state, method, at_step, shown = restore_shown_state(load_session(path), ready.session.image)
    assert (state.step, method, shown.min_length) == (ready.session.status.step, "cpm", 1e4)
    assert at_step == begun


def test_a_skeleton_is_there_again(ready, hand, tmp_path) -> None:
    hand.key(KEY.Key_F3, Qt.KeyboardModifier.ControlModifier)
    run_to_the_end(ready, hand)
    length = ready.session.scene.skeleton.length
    reopened(ready, hand, saved(ready, hand, tmp_path / "a.cpm"))
    assert ready.session.scene.skeleton.length == length


DAMAGES = [
    (("runs", 0, "branches", 0, "steps"), [[[99], 4]]),
    (("runs", 0, "branches", 0, "steps"), [[[], 1], [[0], 10**12]]),
    (("runs", 0, "branches", 1, "parent"), 77),
    (("runs", 0, "document"), "no document"),
    (("runs", 1, "actions", 0, "step", "beta"), -5.0),
    (("states", 0, "state", "position", "data"), "AAAA"),
    (("runs",), 3),
]
"""Pieces of a session file, and what they are replaced by."""


def test_damaged_runs_are_one_sentence_and_everything_else_is_opened(steered, hand, tmp_path, cases) -> None:
    whole = saved(steered, hand, tmp_path / "a.cpm").read_text()
    for path, value in cases(DAMAGES):
        content = json.loads(whole)
        at = content["runs"]
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = value
        (tmp_path / "b.cpm").write_text(json.dumps(content))
        said = reopened(steered, hand, tmp_path / "b.cpm")
        assert len([text for text in said if "damaged" in text]) == 1
        assert [branch.name for branch in navigation(steered).timeline_state.branches] == []
        assert steered.session.document.shapes == (Circle((30.0, 28.0), 6.0),)


def test_the_truth_comes_back(ready, hand, tmp_path) -> None:
    truth, scene = ready.workspace.comparison, lambda: ready.session.scene
    np.save(tmp_path / "mask.npy", (np.load(tmp_path / "disc.npy") > 100).astype(np.uint8))
    truth.load_truth_file(tmp_path / "mask.npy")
    truth.set_tolerance(3.0)
    hand.wait(lambda: scene().truth is not None)
    saved(ready, hand, tmp_path / "a.cpm")
    assert load_session(tmp_path / "a.cpm").truth.path == "mask.npy"
    truth.set_tolerance(1.0)
    reopened(ready, hand, tmp_path / "a.cpm")
    hand.wait(lambda: scene().truth is not None)
    assert truth.tolerance == 3.0


def test_a_run_that_running_again_gives_is_no_work_and_a_steered_one_is(ready, hand, tmp_path) -> None:
    saved(ready, hand, tmp_path / "a.cpm")
    run_to_the_end(ready, hand)
    assert document_file(ready).unsaved_parts == ()
    navigation(ready).go_to(1, 10)
    hand.wait(lambda: ready.session.idle and ready.session.status.step == 10)
    ready.session.edit("beta", lambda document: edits.set_parameter(document, "beta", 1.4))
    run_to_the_end(ready, hand)
    assert document_file(ready).unsaved_parts == ("the parameters", "the runs")
    ready.session.undo()
    assert document_file(ready).unsaved_parts == ("the runs",)
    saved(ready, hand, tmp_path / "a.cpm")
    assert document_file(ready).unsaved_parts == ()
