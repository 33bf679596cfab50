"""The model as published in the window: run, watched, gone back to, and equal to that of the library."""

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.modes import find_effective_controls
from PySide6.QtCore import Qt

from cpm_core import Parameters, segment
from cpm_core.shapes import Circle

pytestmark = pytest.mark.shared_window


def test_a_run_as_published_in_the_window_is_that_of_the_library(window, hand) -> None:
    session = window.session
    hand.key(Qt.Key.Key_F4, Qt.KeyboardModifier.ControlModifier)
    assert session.document.mode == "published"
    assert session.document.parameters == session.document.fit_scales(Parameters())
    session.edit("draw", lambda document: edits.add_shape(document, Circle((32.0, 32.0), 10.0)))
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    shown, document = session.scene.snapshot, session.document
    assert shown.method == "published"
    found = segment(session.image, shown.state.start, document.parameters, method="published")
    np.testing.assert_array_equal(found.particles, shown.position)
    assert found.stop_reason == shown.state.stop_reason
    assert not {"reach", "edge_floor", "max_gap"} & find_effective_controls("published")
