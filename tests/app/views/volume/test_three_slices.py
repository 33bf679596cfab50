"""Three slices side by side, linked by a cross, by mouse and keys."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.views.features.volumes import SlicesFeature
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

from cpm_core.shapes import Sphere
from tests.app.views.volume.conftest import ball, move, press, release

pytestmark = pytest.mark.shared_window

LEFT, SHIFT = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ShiftModifier


def sides(window):
    return window.get_feature(SlicesFeature).sides


def lines(view) -> list[float]:
    """Where the lines of the cross are, row and column."""
    return [line.value() for line in view.cross._lines]


def turn_wheel(view, notches, at, keys=Qt.KeyboardModifier.NoModifier) -> None:
    port, at = view.viewport(), QPointF(at)
    event = QWheelEvent(at, port.mapToGlobal(at), QPoint(), QPoint(0, 120 * notches), Qt.MouseButton.NoButton, keys,
                        Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    QApplication.sendEvent(port, event)


def test_the_other_axes_are_shown_beside_the_canvas(volume, hand) -> None:
    for axis in range(3):
        volume.workspace.slices.set_axis(axis)
        others = [other for other in range(3) if other != axis]
        for view, other in zip(sides(volume), others, strict=True):
            assert view.isVisible()
            here = volume.session.scene.slices.slice_across(other)
            np.testing.assert_array_equal(view.drawn_scene.image.values, np.take(ball(), here.index, axis=other))
            assert lines(view) == list(here.drop_axis(volume.session.scene.slices.voxel))


@pytest.mark.parametrize("button", [Qt.MouseButton.RightButton, LEFT])
def test_a_click_beside_the_canvas_moves_the_cross_and_with_it_the_slice(volume, hand, button) -> None:
    if button == LEFT:
        hand.key(Qt.Key.Key_S)
    rows, _ = sides(volume)  # across the rows: planes run down, columns to the right
    press(rows, (5.0, 20.0), button)
    assert volume.session.scene.slices.voxel == (5, 14, 20)
    assert volume.session.scene.slices.axis == 0
    np.testing.assert_array_equal(hand.canvas.drawn_scene.image.values, ball()[5])
    move(rows, (9.0, 11.0), button)
    assert volume.session.scene.slices.voxel == (9, 14, 11)
    release(rows, (9.0, 11.0), button)
    move(rows, (3.0, 3.0), Qt.MouseButton.NoButton)
    assert volume.session.scene.slices.voxel == (9, 14, 11)
    assert not volume.session.document.shapes


def test_the_wheel_beside_the_canvas_goes_through_the_slices_there(volume) -> None:
    _, columns = sides(volume)
    turn_wheel(columns, -2, columns.viewport().rect().center())
    assert volume.session.scene.slices.voxel == (12, 14, 18)
    assert volume.session.scene.slices.axis == 0


def test_what_is_drawn_in_one_slice_is_seen_in_all_that_cut_it(volume, hand) -> None:
    hand.drag((14, 16), (14, 18), (14, 22))
    (sphere,) = volume.session.document.shapes
    assert isinstance(sphere, Sphere)
    for view in sides(volume):
        (section,) = view.drawn_scene.document.shapes
        assert 0.5 * np.ptp(section.outline, axis=0) == pytest.approx([sphere.radius] * 2, abs=0.2)


def test_the_four_views_have_their_room_in_small_windows_and_a_key_leaves_one_slice(volume, hand) -> None:
    views = (volume.canvas_area.canvas, *sides(volume), volume.panels["space"].view)
    picture = volume.canvas_area.views.geometry
    for size in ((1280, 720), (960, 540)):
        volume.resize(*size)
        hand.wait(lambda: picture().width() >= 0.6 * volume.width())
        hand.wait(lambda: picture().height() >= 0.65 * volume.height())
        assert all(min(view.width(), view.height()) >= 100 for view in views)
    hand.key(Qt.Key.Key_Q, SHIFT)
    assert [view.isVisible() for view in views] == [True, False, False, False]
    hand.wait(lambda: views[0].width() == picture().width())
    hand.key(Qt.Key.Key_Q, SHIFT)
    assert all(view.isVisible() for view in views)
