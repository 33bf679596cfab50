"""A region of interest that is drawn after a run from everywhere: what is proposed in it, and the way back."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from cpm_core.objects import compute_iou
from tests.app.acting import wait_for_offers

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
NUCLEI = [(row, col) for row in (16.0, 48.0, 80.0) for col in (16.0, 48.0, 80.0)]
LOW, HIGH = 2.0, 64.0
"""Corners of the region, which holds four of the nuclei."""


@pytest.fixture
def image_file(tmp_path):
    """A file with nine nuclei on a noisy background."""
    row, col = np.indices((96, 96))
    away = np.min([np.hypot(row - at[0], col - at[1]) for at in NUCLEI], axis=0)
    noise = np.random.default_rng(4).normal(0.0, 3.0, row.shape)
    path = tmp_path / "nuclei.npy"
    np.save(path, 40.0 + 120.0 * np.clip(9.5 - away, 0.0, 1.0) + noise)
    return path


def proposed(window) -> list[np.ndarray]:
    return [each.selection.mask for each in window.session.scene.objects.proposals if each.selection.confidence > 0.5]


def shown(window):
    """The particles, the contours and the proposals."""
    scene = window.session.scene
    return (
        scene.snapshot.position.tobytes(),
        [contour.points.tobytes() for contour in scene.reconstruction.result.contours],
        [each.proposed_object.region.boundary for each in scene.objects.proposals],
    )


def run_everywhere(window, hand) -> None:
    window.actions_by_name["start_grid"].trigger()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)


def draw_region(hand) -> None:
    hand.key(KEY.Key_I)
    hand.drag((LOW, LOW), (30.0, 30.0), (HIGH, HIGH))


def test_a_region_gives_the_same_objects_after_a_run_as_before_it_and_undo_gives_back_the_run(window, hand) -> None:
    run_everywhere(window, hand)
    wait_for_offers(window, hand)
    whole = shown(window)
    assert len(proposed(window)) == len(NUCLEI)
    step = window.session.status.step
    draw_region(hand)
    hand.wait(lambda: window.session.status.step > step)  # it may be at rest again before anybody looks
    wait_for_offers(window, hand)
    after = proposed(window)
    hand.key(KEY.Key_Z, CONTROL)
    wait_for_offers(window, hand)
    assert shown(window) == whole
    hand.key(KEY.Key_Escape)
    window.session.reset()
    draw_region(hand)
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    wait_for_offers(window, hand)
    before = proposed(window)
    assert len(after) == len(before) == 4
    assert all(max(compute_iou(one, other) for other in before) > 0.9 for one in after)


def test_undo_of_a_slider_moved_during_a_run_gives_the_rest_without_it(window, hand) -> None:
    run_everywhere(window, hand)
    wait_for_offers(window, hand)
    first = window.session.document.parameters
    whole = proposed(window)
    window.session.reset()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("running")
    slider = window.panels["run"].parameters.rows["beta"].slider
    slider.setFocus()
    hand.qtbot.keyClick(slider, KEY.Key_PageUp)
    wait_for_offers(window, hand)
    assert window.session.document.parameters != first
    hand.key(KEY.Key_Z, CONTROL)
    wait_for_offers(window, hand)
    assert window.session.document.parameters == first
    left = proposed(window)
    assert len(left) == len(whole)
    assert all(max(compute_iou(one, other) for other in whole) > 0.9 for one in left)
