"""Starts that need no drawing: switched on and off, shown at their positions, and limited to regions of interest."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.document import edits
from PySide6.QtCore import Qt

from cpm_core import divergence_centers, gradient_threshold, uniform_grid
from cpm_core.shapes import SEEDING_KINDS, Everywhere, PolygonRegion

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
KEYS = {
    "grid": (KEY.Key_G, CONTROL),
    "gradient": (KEY.Key_G, CONTROL | SHIFT),
    "centers": (KEY.Key_C, CONTROL | SHIFT),
}


def expected(kind: str, values: np.ndarray) -> np.ndarray:
    """Seeds that the core finds for an image."""
    match kind:
        case "grid":
            return uniform_grid(values.shape)
        case "gradient":
            return gradient_threshold(values)
    return divergence_centers(values)


@pytest.fixture
def seen(record) -> list:
    """The seeds that the session has reported."""
    return record("image_seeds")


@pytest.mark.parametrize("kind", SEEDING_KINDS)
def test_a_key_starts_everywhere_and_the_same_key_ends_it_each_a_step_of_undo(window, hand, seen, kind) -> None:
    action = window.actions_by_name[f"start_{kind}"]
    hand.key(*KEYS[kind])
    assert window.session.document.shapes == (Everywhere(kind),)
    assert action.isChecked()
    hand.wait(lambda: bool(seen))
    np.testing.assert_array_equal(seen[-1][Everywhere(kind)], expected(kind, window.session.image.values))
    assert sum(discs.count for discs in hand.canvas.layers.drawing.computed.values()) == len(seen[-1][Everywhere(kind)])
    hand.key(*KEYS[kind])
    assert window.session.document.shapes == ()
    assert not action.isChecked()
    assert sum(discs.count for discs in hand.canvas.layers.drawing.computed.values()) == 0
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document.shapes == (Everywhere(kind),)
    assert action.isChecked()
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document.shapes == ()


@pytest.mark.parametrize("kind", SEEDING_KINDS)
def test_a_run_begins_with_the_particles_that_were_shown(window, hand, seen, kind) -> None:
    hand.key(*KEYS[kind])
    window.session.edit("scales", lambda document: edits.set_parameter(document, "scales", 1))
    hand.wait(lambda: bool(seen) and window.session.idle)
    window.session.step()
    hand.wait(lambda: window.session.idle and window.session.status.step == 1)
    window.workspace.navigation.go_to_first()
    hand.wait(lambda: window.session.idle and window.session.status.step == 0)
    first = window.session.scene.snapshot.position
    shown = seen[-1][Everywhere(kind)]
    assert len(shown) > 0
    np.testing.assert_array_equal(np.unique(first, axis=0), np.unique(shown, axis=0))


def test_a_region_of_interest_limits_the_seeds_and_the_smoothing_moves_them(window, hand, seen) -> None:
    hand.key(*KEYS["gradient"])
    hand.wait(lambda: bool(seen))
    everywhere = seen[-1][Everywhere("gradient")]
    region = PolygonRegion(((0.0, 0.0), (0.0, 63.0), (31.5, 63.0), (31.5, 0.0)))
    window.session.edit("region", lambda document: edits.add_shape(document, region))
    hand.wait(lambda: len(seen) == 2)
    np.testing.assert_array_equal(seen[-1][Everywhere("gradient")], everywhere[everywhere[:, 0] < 31.5])
    window.session.edit("smoothing", lambda document: edits.set_parameter(document, "smoothing", 3.0))
    hand.wait(lambda: len(seen) == 3)
    wider = gradient_threshold(window.session.image.values, smoothing=3.0)
    np.testing.assert_array_equal(seen[-1][Everywhere("gradient")], wider[wider[:, 0] < 31.5])
    window.session.edit("damping", lambda document: edits.set_parameter(document, "beta", 1.0))
    hand.wait(lambda: window.session.idle)
    assert len(seen) == 3
