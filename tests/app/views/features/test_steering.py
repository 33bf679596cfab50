"""Interventions act in a run at once: charges, regions, barriers, new initializations, the eraser and their undo."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.session.worker.commands import call_run
from cpm_app.session.worker.run import Run
from cpm_app.views.features.run import TimelineFeature
from PySide6.QtCore import Qt

from cpm_core.field.placed_charges import CHARGE_RADIUS, PlacedCharge
from cpm_core.shapes import Barrier, Charge, Circle, Points

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL = Qt.KeyboardModifier.ControlModifier
ALT = Qt.KeyboardModifier.AltModifier


@pytest.fixture
def shown(ready):
    """The newest snapshot."""
    return lambda: ready.session.scene.snapshot


@pytest.fixture
def begun(ready, hand, shown):
    """A run paused at its first step, on a single scale."""
    ready.session.edit("scales", lambda document: edits.set_parameter(document, "scales", 1))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Period)
    hand.wait(lambda: ready.session.idle)
    assert ready.session.status.phase == "paused"
    return ready


@pytest.fixture
def rested(begun, hand):
    """A run that has come to rest."""
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: begun.session.idle)
    assert begun.session.status.converged
    return begun


def near(snapshot, place, distance) -> int:
    return int(np.count_nonzero(np.hypot(*(snapshot.position - place).T) < distance))


def test_particles_at_rest_go_to_a_charge_that_is_dropped_beside_them_and_back_when_it_is_undone(
    rested, hand, shown
) -> None:
    generation = rested.session.store.generation
    beside = (32.0, 32.0 + 18.0 + 0.7 * CHARGE_RADIUS)
    assert near(shown(), beside, 8.0) == 0
    hand.key(KEY.Key_A)
    hand.click(*beside)
    hand.key(KEY.Key_BracketRight)
    hand.wait(lambda: near(shown(), beside, 8.0) > 3)
    hand.wait_for_phase("finished")
    assert rested.session.store.generation == generation
    assert not rested.session.status.stale
    hand.key(KEY.Key_Z, CONTROL)
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: rested.session.idle and rested.session.status.phase == "finished")
    assert rested.session.document.charges == ()
    assert near(shown(), beside, 8.0) == 0
    assert rested.session.store.generation == generation


def test_particles_follow_a_charge_while_it_is_dragged(rested, hand, shown) -> None:
    session = rested.session
    hand.key(KEY.Key_A)
    hand.press(32, 62)
    hand.wait(lambda: near(shown(), (32.0, 62.0), 8.0) > 3)
    for row in range(33, 53):
        hand.move(row, 62)
        hand.wait(lambda: shown().state.charges == (PlacedCharge(session.document.shapes[-1].position, 2.0),))
    hand.wait(lambda: near(shown(), (52.0, 62.0), 8.0) > 3)
    assert hand.canvas.dispatcher.is_dragging
    hand.release(52, 62)
    assert session.document.shapes[-1].position == pytest.approx((52, 62), abs=0.5)
    hand.key(KEY.Key_Z, CONTROL)
    assert session.document.charges == ()
    hand.wait(lambda: shown().state.charges == ())


def test_the_field_is_shown_with_the_charge_that_is_dragged(begun, hand, record) -> None:
    fields = record("overlays")
    hand.key(KEY.Key_9, ALT)
    hand.wait(lambda: len(fields) == 1)
    hand.key(KEY.Key_A)
    hand.press(32, 10)
    hand.wait(lambda: len(fields) == 2)
    hand.move(32, 14)
    hand.wait(lambda: len(fields) >= 3)
    hand.release(32, 14)
    plain, first, moved = (overlays["field"] for overlays in (fields[0], fields[1], fields[-1]))
    off = np.argwhere(np.abs(first - plain).sum(axis=0) > 0)
    assert len(off)
    assert np.hypot(*(off - (32, 10)).T).max() < 5 * CHARGE_RADIUS
    toward = [(field - plain)[1, 32, 12] for field in (first, moved)]
    assert toward[0] < 0 < toward[1]


def test_a_barrier_drawn_during_a_run_stops_the_front_until_it_is_undone(ready, hand, shown) -> None:
    session = ready.session
    session.edit("scales", lambda document: edits.set_parameter(document, "scales", 1))
    session.edit("small", lambda document: edits.set_shapes(document, (Circle((32.0, 20.0), 3.0),)))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Period)
    hand.wait(lambda: session.idle)
    hand.key(KEY.Key_B)
    hand.click(2, 32)
    hand.click(62, 32)
    hand.key(KEY.Key_Return)
    assert isinstance(session.document.shapes[-1], Barrier)
    assert not session.status.stale
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    inside = np.hypot(*(shown().position - 32.0).T) < 20.0
    assert shown().position[inside, 1].max() < 33.0
    generation = session.store.generation
    hand.key(KEY.Key_Delete)
    hand.wait(lambda: shown().position[:, 1].max() > 48.0)
    assert session.store.generation == generation


def test_a_circle_drawn_during_a_run_adds_particles_when_the_button_is_released(begun, hand, shown) -> None:
    before = begun.session.status.count
    hand.key(KEY.Key_C)
    hand.press(8, 8)
    hand.move(8, 10)
    hand.move(8, 12)
    hand.wait(lambda: begun.session.idle)
    assert begun.session.status.count == before
    hand.release(8, 12)
    hand.wait(lambda: begun.session.status.count > before)
    circle = begun.session.document.shapes[-1]
    assert begun.session.status.count == before + len(circle.seeds())
    joined = shown().position[-len(circle.seeds()) :]
    np.testing.assert_allclose(np.sort(joined, axis=0), np.sort(circle.seeds(), axis=0), atol=1e-9)
    assert not begun.session.status.stale
    assert begun.actions_by_name["run"].text() == "Resume"


def test_undo_brings_erased_particles_back_however_far_the_run_has_gone_since(begun, hand, shown) -> None:
    session = begun.session
    session.edit("a start that stays", lambda document: edits.add_shape(document, Points(((56.0, 56.0),))))
    hand.wait(lambda: session.idle)
    before = shown()
    strokes = [((22.0, 30.0), (22.0, 32.0), (22.0, 34.0)), ((42.0, 30.0), (42.0, 32.0), (42.0, 34.0))]
    hand.key(KEY.Key_E)
    states = [before]
    for stroke in strokes:
        hand.drag(*stroke)
        hand.wait(lambda: session.idle)
        assert shown().state.count < states[-1].state.count
        states.append(shown())
    assert begun.actions_by_name["undo"].text() == "Undo erase"
    for _ in range(3):
        hand.key(KEY.Key_Period)
        hand.wait(lambda: session.idle)
    assert session.status.step == before.state.step + 3
    states[-1] = shown()
    for state in reversed(states[:-1]):
        hand.key(KEY.Key_Z, CONTROL)
        hand.wait(lambda: session.idle)
        np.testing.assert_array_equal(shown().position, state.position)
        assert session.status.step == before.state.step
    assert not session.status.stale
    for state in states[1:]:
        hand.key(KEY.Key_Y, CONTROL)
        hand.wait(lambda: session.idle)
        np.testing.assert_array_equal(shown().position, state.position)


def test_steps_with_interventions_are_reproduced_exactly(begun, hand, shown) -> None:
    session, navigation = begun.session, begun.get_feature(TimelineFeature).navigation
    seen = {}

    def take_a_step() -> None:
        hand.wait(lambda: session.idle)
        seen[navigation.current_step] = shown().position
        hand.key(KEY.Key_Period)
        hand.wait(lambda: session.idle)

    session.post_command(call_run(None, Run.set_timeline_budget, 0))
    session.edit("charge", lambda document: edits.add_shape(document, Charge((20.0, 20.0))))
    take_a_step()
    session.edit("points", lambda document: edits.add_shape(document, Points(((5.0, 5.0), (8.0, 8.0)))))
    take_a_step()
    hand.key(KEY.Key_E)
    hand.click(8, 8)
    take_a_step()
    session.edit("barrier", lambda document: edits.add_shape(document, Barrier(((2.0, 30.0), (60.0, 30.0)))))
    take_a_step()
    take_a_step()
    for (branch, step), position in seen.items():
        navigation.go_to(branch, step)
        hand.wait(lambda step=step: session.idle and shown().state.step == step)
        np.testing.assert_array_equal(shown().position, position)
