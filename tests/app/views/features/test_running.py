"""Runs: started, steered, paused, stopped and closed, without lost steps or remaining threads."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.display.display_image import shade_edge_map
from cpm_app.model.display.effects import MOTION_PARAMETERS
from cpm_app.model.document import edits
from cpm_app.views.widgets.containers import ElidedLabel
from PySide6.QtCore import QPoint, Qt

from cpm_core import PRESETS, Engine
from cpm_core.model.starts import circle
from cpm_core.model.state import State
from cpm_core.shapes import Circle
from tests.app.reading import contour_counts

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL = Qt.KeyboardModifier.ControlModifier
ALT = Qt.KeyboardModifier.AltModifier


def test_space_runs_to_rest_and_shows_one_closed_contour_around_the_disc(ready, hand) -> None:
    hand.key(KEY.Key_Space)
    assert ready.session.status.phase == "running"
    assert ready.actions_by_name["run"].text() == "Pause"
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle)
    assert contour_counts(hand.canvas.layers.contours) == (1, 0)
    assert ready.panels["run"].status.state.startswith("Finished")
    numbers = {label.accessibleName(): label.text() for label in ready.panels["run"].findChildren(ElidedLabel)}
    assert numbers["Contours"] == "1 closed, 0 open"
    assert hand.canvas.layers.particles.count == int(numbers["Particles"].replace(",", ""))


def test_pause_stops_the_particles_and_run_continues_from_them(ready, hand) -> None:
    session = ready.session
    session.set_pace(30.0)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: session.status.step >= 2)
    hand.key(KEY.Key_Space)
    assert session.status.phase == "paused"
    hand.wait(lambda: session.idle)
    held, generation = session.status.step, session.store.generation
    hand.key(KEY.Key_Period)
    hand.wait(lambda: session.idle)
    assert session.status.step == held + 1
    hand.key(KEY.Key_Space)
    hand.wait(lambda: session.status.step > held + 1)
    assert session.store.generation == generation


def test_single_steps_are_the_engines_own(ready, hand) -> None:
    values = ready.session.image
    engine, state = Engine(values, PRESETS["shape"]), None
    state = engine.start(circle((32.0, 32.0), 10.0))
    for _ in range(5):
        hand.key(KEY.Key_Period)
        state = engine.step(state, PRESETS["shape"])
    hand.wait(lambda: ready.session.idle)
    np.testing.assert_array_equal(ready.session.scene.snapshot.position, state.position)


def test_a_moved_slider_acts_at_the_next_step_without_a_new_start(ready, hand) -> None:
    engine = Engine(ready.session.image, PRESETS["shape"])
    state = engine.start(circle((32.0, 32.0), 10.0))
    hand.key(KEY.Key_Period)
    hand.wait(lambda: ready.session.idle)
    generation = ready.session.store.generation
    state = engine.step(state, PRESETS["shape"])
    slider = ready.panels["run"].parameters.rows["beta"].slider
    hand.qtbot.keyClick(slider, KEY.Key_PageUp)
    changed = ready.session.document.parameters
    assert changed.beta > PRESETS["shape"].beta
    hand.canvas.setFocus()
    hand.key(KEY.Key_Period)
    state = engine.step(state, changed)
    hand.wait(lambda: ready.session.idle)
    assert ready.session.store.generation == generation
    np.testing.assert_array_equal(ready.session.scene.snapshot.position, state.position)


def test_reset_keeps_the_shapes_and_discards_the_run(ready, hand) -> None:
    hand.key(KEY.Key_Space)
    hand.wait(lambda: ready.session.status.step > 3)
    hand.key(KEY.Key_R)
    assert ready.session.status.phase == "ready"
    assert hand.canvas.layers.particles.count == 0
    hand.wait(lambda: ready.session.idle)
    assert hand.canvas.layers.particles.count == 0
    assert contour_counts(hand.canvas.layers.contours) == (0, 0)
    assert ready.session.document.shapes == (Circle((32.0, 32.0), 10.0),)


def test_a_run_at_rest_continues_with_changed_parameters(ready, hand) -> None:
    session = ready.session
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    generation, step, count = session.store.generation, session.status.step, session.status.count
    session.edit("spacing", lambda document: edits.set_parameter(document, "d_min", 4.0))
    assert ready.actions_by_name["run"].text() == "Resume"
    assert "parameters have changed" in ready.canvas_area.hint.text()
    hand.key(KEY.Key_Space)
    hand.wait(lambda: session.status.phase == "finished" and session.status.step > step)
    hand.wait(lambda: session.idle)
    assert session.store.generation == generation
    assert session.status.count < count
    assert ready.actions_by_name["run"].text() == "Run again"


def test_a_run_that_ended_before_it_came_to_rest_goes_on_on_the_same_timeline(ready, hand, monkeypatch) -> None:
    session, step = ready.session, Engine.step

    def step_to_limit(engine: Engine, state: State, *given: object) -> State:
        after = step(engine, state, *given)
        return after.stop("not at rest after 9 steps") if after.step == 9 else after

    monkeypatch.setattr(Engine, "step", step_to_limit)
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    generation = session.store.generation
    assert session.status.step == 9
    assert ready.actions_by_name["run"].text() == "Resume"
    hand.key(KEY.Key_Space)
    hand.wait(lambda: session.status.converged)
    hand.wait(lambda: session.idle)
    assert session.store.generation == generation
    assert len(session.scene.snapshot.timeline.branches) == 1
    assert session.status.step > 9
    assert ready.actions_by_name["run"].text() == "Run again"


def test_no_result_of_the_previous_image_reaches_an_image_opened_during_a_run(ready, hand, record, tmp_path) -> None:
    other = tmp_path / "other.npy"
    np.save(other, np.indices((40, 50)).sum(axis=0) % 17 * 1.0)
    seen = record("snapshot")
    ready.session.image_changed.connect(seen.clear)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: ready.session.status.step > 0)
    ready.session.open_file(other)
    hand.wait(lambda: ready.session.document.image.name == "other.npy")
    hand.wait(lambda: ready.session.idle)
    assert ready.session.status.phase == "ready"
    assert ready.session.document.shapes == ()
    assert [snapshot for snapshot in seen if snapshot is not None] == []
    assert hand.canvas.layers.particles.count == 0


def test_closing_while_running_ends_both_threads(ready, hand) -> None:
    names = {"cpm-engine", "cpm-reconstruction"}
    assert names <= {thread.name for thread in threading.enumerate()}
    hand.key(KEY.Key_Space)
    hand.wait(lambda: ready.session.status.step > 0)
    ready.close()
    assert not names & {thread.name for thread in threading.enumerate()}


def test_overlays_appear_on_request_and_follow_the_smoothing(window, hand) -> None:
    session = window.session

    def settled_overlays():
        hand.wait(lambda: session.idle)
        return session.scene.overlays

    hand.key(KEY.Key_7, ALT)
    hand.wait(lambda: "edge_map" in session.scene.overlays)
    first = settled_overlays()
    engine = Engine(session.image, PRESETS["shape"])
    np.testing.assert_array_equal(first["edge_map"].shades, shade_edge_map(engine.edge_map(PRESETS["shape"])))
    assert first.get("field") is None
    smoother = replace(PRESETS["shape"], smoothing=2.0)
    session.edit("smoothing", lambda document: edits.set_parameter(document, "smoothing", 2.0))
    hand.wait(lambda: session.scene.overlays["edge_map"] is not first["edge_map"])
    np.testing.assert_array_equal(settled_overlays()["edge_map"].shades, shade_edge_map(engine.edge_map(smoother)))
    window.panels["layers"].boxes["field"].click()
    hand.wait(lambda: "field" in session.scene.overlays)
    field = settled_overlays()["field"]
    np.testing.assert_array_equal(field, engine.force_field(smoother))
    session.edit("beta", lambda document: edits.set_parameter(document, "beta", 1.0))
    assert settled_overlays()["field"] is field


@pytest.mark.parametrize("name", MOTION_PARAMETERS)
def test_at_rest_a_moved_slider_continues_the_run_and_undo_brings_the_rest_back(ready, hand, name) -> None:
    session, row = ready.session, ready.panels["run"].parameters.rows[name]
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    before, parameters = session.scene.snapshot, session.document.parameters
    outline = session.scene.reconstruction.result.contours[0].points
    row.slider.setFocus()
    for _ in range(3):
        hand.qtbot.keyClick(row.slider, KEY.Key_PageDown)
    assert session.status.phase == "running"
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    after, changed = session.scene.snapshot, session.document.parameters
    assert after.state.step > before.state.step
    assert after.state.steering == changed.steering != parameters.steering
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: session.idle)
    assert session.document.parameters == parameters
    assert session.status.phase == "finished"
    np.testing.assert_array_equal(session.scene.snapshot.position, before.position)
    np.testing.assert_array_equal(session.scene.reconstruction.result.contours[0].points, outline)
    hand.key(KEY.Key_Z, CONTROL | Qt.KeyboardModifier.ShiftModifier)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    assert session.document.parameters == changed
    assert session.scene.snapshot.state.steering == changed.steering


def test_what_the_sliders_of_the_motion_change_is_shown_next_to_them(ready, hand) -> None:
    rows = ready.panels["run"].parameters.rows
    hand.key(KEY.Key_Period)
    hand.wait(lambda: ready.session.idle)
    assert rows["beta"].effect.text().endswith("px per step")
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle)
    outline = ready.session.scene.contours[0].length
    words = [rows[name].effect.text() for name in MOTION_PARAMETERS]
    assert words[:2] == ["at rest", f"{outline:.0f} px of contours"]
    assert words[2] == "creeps up to 2.0 px"


def test_a_run_moves_no_slider(ready, hand) -> None:
    rows = ready.panels["run"].parameters.rows

    def places():
        hand.qtbot.wait(1)
        return [row.slider.mapTo(ready, QPoint()) for row in rows.values() if row.isVisible()]

    before = places()
    assert len(before) >= 6
    hand.key(KEY.Key_Period)
    hand.wait(lambda: ready.session.idle)
    assert places() == before
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle)
    assert rows["beta"].effect.text()
    assert places() == before


@pytest.mark.parametrize("name", ["beta"])
def test_a_slider_drag_is_one_step_of_undo(window, hand, name) -> None:
    before = window.session.document.parameters
    slider = window.panels["run"].parameters.rows[name].slider
    slider.setFocus()
    for key in (KEY.Key_PageDown, KEY.Key_Left, KEY.Key_Left):
        hand.qtbot.keyClick(slider, key)
    assert window.session.document.parameters != before
    assert window.actions_by_name["undo"].text().startswith("Undo change of")
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document.parameters == before
    assert not window.actions_by_name["undo"].isEnabled()
