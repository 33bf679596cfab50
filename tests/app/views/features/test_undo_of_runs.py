"""Undo and redo around a finished run: the run goes back to where it was at rest, and nothing moves on by itself."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt

from tests.app.acting import wait_for_offers

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL = Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier


def outcome(window):
    """The document, the particles, the contours, the proposals, and where the run is on the timeline."""
    scene = window.session.scene
    timeline, result = scene.snapshot.timeline, scene.reconstruction.result
    return (
        window.session.document,
        (timeline.branch, scene.snapshot.state.step),
        scene.snapshot.position.tobytes(),
        [contour.points.tobytes() for contour in result.contours],
        [each.proposed_object.region.boundary for each in scene.objects.proposals],
    )


def press_times(hand, key, times, modifier=CONTROL) -> None:
    for _ in range(times):
        hand.key(key, modifier)


def test_undoing_everything_and_redoing_it_gives_back_the_very_result(window, hand) -> None:
    session = window.session
    hand.drag((32.0, 32.0), (32.0, 36.0), (32.0, 40.0))
    hand.key(KEY.Key_I)
    hand.drag((4.0, 4.0), (40.0, 40.0), (60.0, 60.0))
    hand.key(KEY.Key_B)
    hand.drag((6.0, 6.0), (6.0, 30.0), (6.0, 50.0))
    hand.key(KEY.Key_A)
    hand.click(8.0, 56.0)
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    wait_for_offers(window, hand)
    before = outcome(window)
    assert len(before[0].shapes) == 4
    assert before[3] and before[4]
    press_times(hand, KEY.Key_Z, 4)
    assert session.document.shapes == ()
    wait_for_offers(window, hand)
    assert session.scene.snapshot.position.tobytes() == before[2]
    press_times(hand, KEY.Key_Z, 4, CONTROL | SHIFT)
    wait_for_offers(window, hand)
    assert outcome(window) == before


@pytest.mark.parametrize("waits", [True, False])
def test_a_start_that_joined_a_run_at_rest_is_undone_and_redone_with_what_came_of_it(ready, hand, waits) -> None:
    hand.key(KEY.Key_Space)
    wait_for_offers(ready, hand)
    first = outcome(ready)
    hand.key(KEY.Key_C)
    hand.drag((8.0, 8.0), (8.0, 10.0), (8.0, 12.0))
    hand.wait(lambda: ready.session.scene.snapshot.position.tobytes() != first[2])
    wait_for_offers(ready, hand)
    second = outcome(ready)
    hand.key(KEY.Key_I)
    hand.drag((2.0, 2.0), (40.0, 40.0), (58.0, 58.0))
    wait_for_offers(ready, hand)
    third = outcome(ready)
    for expected in (second, first):
        hand.key(KEY.Key_Z, CONTROL)
        if waits:
            wait_for_offers(ready, hand)
            assert outcome(ready) == expected
    for expected in (second, third):
        hand.key(KEY.Key_Z, CONTROL | SHIFT)
        if waits:
            wait_for_offers(ready, hand)
            assert outcome(ready) == expected
    wait_for_offers(ready, hand)
    assert outcome(ready) == third
    assert len(ready.session.document.shapes) == 3
