"""The divider between what is shown now and the chosen result."""

from __future__ import annotations

from dataclasses import replace

import pytest
from cpm_app.session.features.comparison import CURRENT_KEY
from cpm_app.views.features.compare import CompareFeature
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from tests.app.reading import contour_counts

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
SHIFT = Qt.KeyboardModifier.ShiftModifier
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def wipe(ready, hand):
    """The divider of a window with a finished run, which has been chosen."""
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.scene.result is not None and ready.session.idle)
    feature, compared = ready.get_feature(CompareFeature), ready.workspace.comparison
    hand.key(KEY.Key_D, Qt.KeyboardModifier.ControlModifier)
    hand.wait(feature.panel.isVisible)
    hand.canvas.setFocus()
    compared.select_row(max(compared.rows))
    hand.wait(lambda: compared._latest.idle and len(compared.agreements) == 1)
    return feature.wipe


def drag(divider, by: int) -> None:
    """Press on the divider, move with the button down, and release."""
    start = divider.rect().center()
    for kind, at, button in (
        (QMouseEvent.Type.MouseButtonPress, start, LEFT),
        (QMouseEvent.Type.MouseMove, start + QPoint(by, 0), Qt.MouseButton.NoButton),
        (QMouseEvent.Type.MouseButtonRelease, start + QPoint(by, 0), LEFT),
    ):
        there = QPointF(divider.mapToGlobal(at))
        event = QMouseEvent(kind, divider.mapFromGlobal(there), there, button, LEFT, Qt.KeyboardModifier.NoModifier)
        QApplication.sendEvent(divider, event)


def test_both_sides_show_their_result_at_the_same_place(ready, wipe, hand) -> None:
    ready.session.store.set_scene(replace(ready.session.scene, reconstruction=None))
    mirror = wipe.mirror
    assert [name.text() for name in wipe.names] == [
        "Shown now",
        ready.workspace.comparison.rows[ready.workspace.comparison.selected].title,
    ]
    assert sum(contour_counts(mirror.layers.contours)) > 0
    assert sum(contour_counts(hand.canvas.layers.contours)) == 0
    for act in (lambda: hand.canvas.zoom_by(2.0), lambda: hand.canvas.pan_by(30.0, 10.0)):
        act()
        assert mirror.view.viewRect().center().x() == pytest.approx(hand.canvas.view.viewRect().center().x(), abs=1e-6)
        assert mirror.magnification == pytest.approx(hand.canvas.magnification)
    layer, mirrored = hand.canvas.layers["image"], mirror.layers["image"]
    layer.set_option("gamma", 2.0)
    layer.set_opacity(0.5)
    assert (mirrored.get_amount("gamma"), mirrored.opacity) == (2.0, 0.5)


def test_the_divider_is_dragged_and_moved_by_arrow_keys_and_esc_ends_it(ready, wipe, hand) -> None:
    divider = wipe.divider
    start = divider.geometry().center().x()
    drag(divider, -100)
    assert divider.geometry().center().x() == pytest.approx(start - 100, abs=1)
    divider.setFocus()
    before = wipe.share
    hand.key(KEY.Key_Right)
    assert wipe.share == pytest.approx(before + 0.05, abs=0.01)
    hand.key(KEY.Key_Left, SHIFT)
    assert wipe.share < before + 0.05
    hand.key(KEY.Key_End)
    assert wipe.share == 1.0
    hand.key(KEY.Key_Escape)
    assert wipe.mirror is None
    assert ready.workspace.comparison.selected == CURRENT_KEY
    assert hand.canvas.hasFocus()
