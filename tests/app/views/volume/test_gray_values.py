"""The window of gray values, by mouse and keys: in slices, in the view in space and on plain images alike."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.views.features.volumes import SlicesFeature, SpaceFeature
from cpm_app.views.layers.image_layer import drag_window
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests.app.views.volume.conftest import open_file
from tests.core.formats.images.made import write_series

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
ENDS = (20.0, 200.0)


def drag_levels(widget, right: int, down: int) -> None:
    """Drag with Ctrl and the right button."""
    begin = QPoint(60, 60)
    end = begin + QPoint(right, down)
    QTest.mousePress(widget, Qt.MouseButton.RightButton, CONTROL, begin)
    QTest.mouseMove(widget, begin + QPoint(right // 2, down // 2))
    QTest.mouseMove(widget, end)
    QTest.mouseRelease(widget, Qt.MouseButton.RightButton, CONTROL, end)


def layer(window):
    return window.canvas_area.canvas.layers.image


def in_space(window):
    return window.get_feature(SpaceFeature).panel


def widgets(window):
    """Everything that shows the volume."""
    sides = window.get_feature(SlicesFeature).sides
    return [window.canvas_area.canvas.viewport(), sides[0].viewport(), in_space(window).view]


@pytest.mark.parametrize("which", [0, 1, 2])
def test_a_drag_in_any_view_changes_the_window_of_all(volume, hand, which) -> None:
    panel = in_space(volume)
    camera, zoom = panel.view.camera, volume.canvas_area.canvas.view.viewRect()
    drag_levels(widgets(volume)[which], -100, 40)
    window = layer(volume).window
    assert window[1] - window[0] == pytest.approx(180.0 * 0.75)
    assert window == pytest.approx((20.0 + 22.5 - 18.0, 200.0 - 22.5 - 18.0))
    assert all(view.layers.image.window == window for view in volume.get_feature(SlicesFeature).sides)
    shaded = panel.contents.shaded
    assert (shaded.window.low, shaded.window.high) == window
    assert panel.view.camera == camera, "such a drag does not move the view"
    assert volume.canvas_area.canvas.view.viewRect() == zoom


def test_keys_choose_all_gray_values_and_the_automatic_range(volume, hand) -> None:
    drag_levels(volume.canvas_area.canvas.viewport(), -100, 0)
    assert layer(volume).window != ENDS
    hand.key(KEY.Key_W, Qt.KeyboardModifier.AltModifier | Qt.KeyboardModifier.ShiftModifier)
    assert layer(volume).window == ENDS
    assert volume.actions_by_name["levels_full"].isChecked()
    hand.key(KEY.Key_W, Qt.KeyboardModifier.AltModifier)
    assert volume.actions_by_name["levels_auto"].isChecked()
    assert not volume.actions_by_name["levels_full"].isChecked()


@pytest.mark.own_window
def test_the_automatic_range_of_a_volume_leaves_out_its_extremes(window, hand, tmp_path) -> None:
    values = np.full((20, 20, 20), 50.0)
    values[:10] = 100.0
    values[0, 0, 0] = 5000.0
    np.save(tmp_path / "spike.npy", values)
    open_file(window, hand, tmp_path / "spike.npy")
    assert layer(window).window == (50.0, 5000.0)
    hand.key(KEY.Key_W, Qt.KeyboardModifier.AltModifier)
    hand.wait(lambda: layer(window).window == (50.0, 100.0))
    assert in_space(window).contents.shaded.window.high == 100.0


@pytest.mark.own_window
def test_the_window_of_the_header_comes_first_and_keys_choose_those_of_ct(window, hand, tmp_path) -> None:
    write_series(tmp_path / "head", range(10), Modality="CT", RescaleSlope=1.0, RescaleIntercept=-1024.0,
                 WindowCenter=40.0, WindowWidth=350.0)  # fmt: skip
    window.open_image(str(tmp_path / "head"))
    hand.wait(lambda: window.session.image is not None and window.session.image.is_ct and window.session.idle)
    hand.wait(lambda: window.turns.is_idle)
    assert layer(window).window == (-135.0, 215.0)
    assert layer(window).get_choice("range") == "file"
    for key, ends in (("F1", (-150, 250)), ("F2", (-1350, 150)), ("F3", (-500, 1300)), ("F4", (0, 80))):
        hand.key(getattr(KEY, f"Key_{key}"), Qt.KeyboardModifier.ShiftModifier)
        assert layer(window).window == ends
        assert all(view.layers.image.window == ends for view in window.get_feature(SlicesFeature).sides)
    layer(window).set_option("range", "file")
    assert layer(window).window == (-135.0, 215.0)
    np.save(tmp_path / "plain.npy", np.arange(8000.0).reshape(20, 20, 20))
    open_file(window, hand, tmp_path / "plain.npy")
    assert layer(window).window == (0.0, 7999.0)
    hand.key(KEY.Key_F4, Qt.KeyboardModifier.ShiftModifier)
    assert layer(window).window == (0.0, 7999.0), "these are no Hounsfield units"


@given(
    st.tuples(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6)),
    st.floats(-2000.0, 2000.0),
    st.floats(-2000.0, 2000.0),
)
def test_a_drag_keeps_the_window_in_order_and_in_the_range(range_, right, down) -> None:
    ends = (range_[0], range_[0] + range_[1])
    low, high = drag_window(ends, ends, right, down)
    assert ends[0] <= low <= high <= ends[1]
