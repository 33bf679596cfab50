"""Grids, thresholds and starts at centers in a volume, by mouse and keys."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from cpm_core.shapes import BoxGrid, BoxThreshold
from tests.app.views.volume.conftest import SHAPE

pytestmark = pytest.mark.shared_window

KEY, CONTROL, SHIFT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


def drawing(hand):
    return hand.canvas.layers["drawing"]


def everywhere(hand) -> int:
    return sum(discs.count for discs in drawing(hand).computed.values())


def test_a_drag_fills_a_box_with_a_grid_that_every_slice_shows(volume, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_G)
    hand.drag((4, 4), (10, 12), (20, 26))
    (grid,) = volume.session.document.shapes
    assert isinstance(grid, BoxGrid)
    assert np.allclose(grid.first[1:], (4, 4), atol=0.5)
    assert np.allclose(grid.last[1:], (20, 26), atol=0.5)
    assert volume.session.selected_shape == 0
    near = grid.seeds()[np.abs(grid.seeds()[:, 0] - 12) <= 4.0]
    (section,) = hand.canvas.drawn_scene.document.shapes
    assert len(section.seeds()) == len(near) > 0
    hand.key(KEY.Key_BracketRight)
    (wider,) = volume.session.document.shapes
    assert wider.spacing > grid.spacing
    assert (wider.first, wider.last) == (grid.first, grid.last)
    assert "spacing" in volume.canvas_area.hint.text()
    hand.key(KEY.Key_Z, CONTROL)
    assert volume.session.document.shapes == (grid,)
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    assert volume.session.scene.reconstruction.result.labels[12, 14, 16] == 1


def test_a_threshold_shows_the_strong_edges_in_its_box_and_starts_there(volume, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_H)
    hand.drag((2, 2), (10, 12), (25, 29))
    (start,) = volume.session.document.shapes
    assert isinstance(start, BoxThreshold)
    hand.wait(lambda: start in volume.session.scene.image_seeds)
    seeds = volume.session.scene.image_seeds[start]
    away = np.linalg.norm(seeds - (np.array(SHAPE) - 1) / 2, axis=1)
    assert len(seeds) > 50
    assert np.abs(away - 7.0).max() < 3.0
    assert 0 < everywhere(hand) < len(seeds)
    before = everywhere(hand)
    for _ in range(10):
        hand.key(KEY.Key_BracketRight)
    hand.wait(lambda: volume.session.idle and everywhere(hand) < before)
    volume.workspace.slices.go_to(0)
    assert everywhere(hand) == 0
    volume.workspace.slices.go_to(12)
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    assert volume.session.scene.snapshot.state.step > 0
