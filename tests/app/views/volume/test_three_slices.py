"""Three slices side by side, linked by a cross, by mouse and keys."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.preferences.table import WHEEL_PREFERENCE
from cpm_app.views.features.volumes import SlicesFeature
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

from cpm_core.shapes import Sphere
from tests.app.views.volume.conftest import ball, move, press, release

pytestmark = pytest.mark.shared_window

LEFT, SHIFT = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ShiftModifier
NOTHING, CTRL = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier


def sides(window):
    return window.get_feature(SlicesFeature).sides


def lines(view) -> list[float]:
    """Where the lines of the cross are, row and column."""
    return [line.value() for line in view.cross._lines]


def turn_wheel(view, notches, at, keys=NOTHING) -> None:
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


@pytest.mark.parametrize("wheel", ["scrolls", "zooms"])
def test_the_wheel_scrolls_in_each_view_and_zooms_with_ctrl_or_the_other_way_round(volume, wheel) -> None:
    volume.preferences.store_preference(WHEEL_PREFERENCE, wheel)
    to_scroll, to_zoom = (NOTHING, CTRL) if wheel == "scrolls" else (CTRL, NOTHING)
    for axis, view in enumerate((volume.canvas_area.canvas, *sides(volume))):
        voxel, before = [*volume.session.scene.slices.voxel], view.magnification
        turn_wheel(view, -2, view.viewport().rect().center(), to_scroll)
        voxel[axis] += 2
        assert volume.session.scene.slices.voxel == tuple(voxel)
        assert view.magnification == before
        turn_wheel(view, 2, view.viewport().rect().center(), to_zoom)
        assert view.magnification == pytest.approx(1.44 * before)
        assert volume.session.scene.slices.voxel == tuple(voxel)
        turn_wheel(view, -2, view.viewport().rect().center(), to_zoom)
    volume.preferences.store_preference(WHEEL_PREFERENCE, WHEEL_PREFERENCE.default)


def test_the_wheel_with_shift_sizes_the_brush_in_each_view(volume, hand) -> None:
    hand.key(Qt.Key.Key_J)
    tool, voxel = hand.canvas.dispatcher.tool, volume.session.scene.slices.voxel
    for view in (hand.canvas, *sides(volume)):
        before = tool.radius
        turn_wheel(view, 1, view.viewport().rect().center(), SHIFT)
        assert tool.radius != before
    assert volume.session.scene.slices.voxel == voxel


@pytest.mark.parametrize("button", [Qt.MouseButton.RightButton, LEFT])
def test_the_right_button_and_the_select_tool_move_the_cross_on_the_canvas(volume, hand, button) -> None:
    if button == LEFT:
        hand.key(Qt.Key.Key_S)
    press(hand.canvas, (9.0, 9.0), button)
    assert volume.session.scene.slices.voxel == (12, 9, 9)
    move(hand.canvas, (5.0, 20.0), button)
    release(hand.canvas, (5.0, 20.0), button)
    assert volume.session.scene.slices.voxel == (12, 5, 20)
    assert [lines(view) for view in sides(volume)] == [[12, 20], [12, 5]]


def test_a_click_that_selects_an_object_moves_the_cross_too(volume, hand) -> None:
    hand.key(Qt.Key.Key_J)
    hand.drag((10, 10), (10, 14))
    hand.key(Qt.Key.Key_S)
    hand.click(10, 12)
    assert len(volume.workspace.object_list.selected_keys) == 1
    assert volume.session.scene.slices.voxel == (12, 10, 12)


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
    for *size, share in ((1280, 720, 0.6), (960, 540, 0.57)):
        volume.resize(*size)
        hand.wait(lambda share=share: picture().width() >= share * volume.width())
        hand.wait(lambda: picture().height() >= 0.65 * volume.height())
        assert all(min(view.width(), view.height()) >= 100 for view in views)
    hand.key(Qt.Key.Key_Q, SHIFT)
    assert [view.isVisible() for view in views] == [True, False, False, False]
    hand.wait(lambda: views[0].width() == picture().width())
    hand.key(Qt.Key.Key_Q, SHIFT)
    assert all(view.isVisible() for view in views)
