"""What layers, films and comparisons show of a volume in its slices."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.document import edits
from PySide6.QtCore import Qt

from cpm_core.shapes import Box

pytestmark = pytest.mark.shared_window

KEY = Qt.Key


@pytest.fixture
def run(volume, hand):
    """A window in which a run has covered the ball."""
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    return volume


def test_shift_f_shows_what_is_selected_in_the_slices_through_its_middle(volume, hand) -> None:
    volume.session.edit("draw", lambda document: edits.add_shape(document, Box((2.0, 3.0, 4.0), (8.0, 9.0, 16.0))))
    volume.session.select_shape(0)
    hand.key(KEY.Key_F, Qt.KeyboardModifier.ShiftModifier)
    assert volume.session.scene.slices.voxel == (5, 6, 10)
    seen = volume.canvas_area.canvas.view.viewRect()
    assert seen.contains(4.0, 3.0)
    assert seen.contains(16.0, 9.0)
    assert not seen.contains(30.0, 26.0)


def test_a_run_is_shown_beyond_the_divider_in_slices(run, hand) -> None:
    compared, canvas = run.workspace.comparison, run.canvas_area.canvas
    hand.wait(lambda: len(canvas.drawn_scene.contours) == 1)
    compared.select_row(max(compared.rows))
    hand.wait(lambda: bool(compared.agreements))
    far = canvas.sections.from_scene(compared.scene_beyond_divider())
    assert len(far.contours) == 1
    np.testing.assert_array_equal(far.contours[0].points, canvas.drawn_scene.contours[0].points)
