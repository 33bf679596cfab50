"""The image is shown in the chosen window, from its own values: a narrow window loses no gray value."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.display.display_image import IntensityWindow, apply_window, percentile_window
from cpm_app.views.layers import image_layer
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

IMAGES = arrays(np.float64, (5, 9), elements=st.floats(-1e4, 1e5, allow_subnormal=False, width=32))


@given(IMAGES, st.sampled_from([0.0, 0.1, 1.0, 5.0]))
def test_the_window_is_that_of_the_percentiles(values, percent):
    low, high = percentile_window(values, percent)
    expected = tuple(np.percentile(values, [percent, 100.0 - percent]))
    assert (low, high) == (expected if expected[0] < expected[1] else (values.min(), values.max()))


@given(IMAGES, st.floats(-1e4, 1e5), st.floats(0.1, 1e5), st.sampled_from([0.4, 1.0, 2.2]))
def test_shades_are_the_fraction_of_the_window_to_the_power_of_gamma(values, low, width, gamma):
    shown = apply_window(values, IntensityWindow(low, low + width, gamma))
    exact = 255.0 * np.clip((values - low) / (low + width - low), 0.0, 1.0) ** gamma
    # the table of shades is as coarse as 1 in 4095, where the curve is steepest
    assert (np.abs(shown - exact) <= 0.5 + (1e-6 if gamma == 1.0 else 255.0 * (1 / 8190.0) ** min(gamma, 1.0))).all()


def test_256_neighboring_values_of_16_bits_have_different_shades():
    values = np.arange(65536.0).reshape(256, 256)
    assert len(np.unique(apply_window(values, IntensityWindow(0.0, 65535.0))[40])) <= 2
    assert apply_window(values, IntensityWindow(40 * 256.0, 40 * 256.0 + 255.0))[40].tolist() == list(range(256))


@pytest.fixture
def deep(window, hand, tmp_path):
    """The window on an image of 16 bits in which a single pixel outshines all others."""
    values = 3000.0 + np.arange(64.0 * 64.0).reshape(64, 64) % 200
    values[3, 3] = 65535.0
    np.save(tmp_path / "deep.npy", values)
    window.session.open_file(tmp_path / "deep.npy")
    hand.wait(lambda: window.session.document.image.name == "deep.npy" and window.session.idle)
    window.docks.reveal_panel("layers")
    row = window.panels["layers"].rows["image"]
    hand.qtbot.mouseClick(row.fold, Qt.MouseButton.LeftButton)
    return hand.canvas.layers["image"], row.settings, values


def test_a_hot_pixel_hides_nothing_and_a_percentile_window_shows_more(deep, hand):
    layer, form, values = deep
    assert layer.window == (3000.0, 3199.0)
    assert np.array_equal(layer.shades, apply_window(values, IntensityWindow(3000.0, 3199.0)))
    box = form.fields["range"]
    box.setFocus()
    for _ in range(2):
        hand.qtbot.keyClick(box, Qt.Key.Key_Down)
    hand.wait(lambda: layer.window != (3000.0, 3199.0))
    assert layer.window == tuple(np.percentile(values, [1.0, 99.0]))
    assert layer.shades[10:20].max() > 240
    assert (form.levels.low.value(), form.levels.high.value()) == tuple(np.rint(layer.window))


@pytest.mark.parametrize("at_once", [True, False])
def test_handles_and_fields_choose_the_window_at_once_or_on_the_worker(deep, hand, monkeypatch, at_once):
    layer, form, values = deep
    if not at_once:
        monkeypatch.setattr(image_layer, "_MAX_IMMEDIATE_PIXELS", 0)
    high = form.levels.high
    high.setFocus()
    high.selectAll()
    hand.qtbot.keyClicks(high, "3180")
    hand.qtbot.keyClick(high, Qt.Key.Key_Return)
    expected = apply_window(values, IntensityWindow(3000.0, 3180.0))
    hand.wait(lambda: np.array_equal(layer.shades, expected))
    assert layer.get_choice("range") == "hand"
    histogram = form.levels.histogram
    hand.wait(lambda: histogram.width() > 90)
    begin, end = (
        histogram.mapFromScene(histogram.plotItem.vb.mapViewToScene(QPointF(value, 2.0))) for value in (3000.0, 3100.0)
    )
    hand.qtbot.mousePress(histogram.viewport(), Qt.MouseButton.LeftButton, pos=begin)
    for share in (0.5, 1.0):
        place = QPointF(begin + share * (end - begin))
        move = QMouseEvent(QEvent.Type.MouseMove, place, place, Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton,
                           Qt.KeyboardModifier.NoModifier)  # fmt: skip
        QApplication.sendEvent(histogram.viewport(), move)
    hand.qtbot.mouseRelease(histogram.viewport(), Qt.MouseButton.LeftButton, pos=end)
    low = layer.window[0]
    assert abs(low - 3100.0) <= 1000.0 / histogram.width() * 2
    hand.wait(lambda: np.array_equal(layer.shades, apply_window(values, IntensityWindow(low, 3180.0))))


def test_a_window_chosen_by_hand_is_kept_in_a_session_file_and_not_for_another_image(window, deep, hand, image_file):
    layer, _, _ = deep
    layer.set_window(3050.0, 3090.0)
    layer.set_option("gamma", 0.5)
    layer.set_option("map", "magma")
    state = layer.view_state()
    layer.set_option("range", "0")
    layer.set_option("gamma", 1.0)
    assert layer.window == (3000.0, 3199.0)
    layer.use_view_state(state)
    assert layer.window == (3050.0, 3090.0)
    assert layer.view_state() == state
    window.session.open_file(image_file)
    hand.wait(lambda: window.session.document.image.name == image_file.name)
    assert layer.window == (20.0, 200.0)
    assert layer.get_choice("range") == "0"


@pytest.fixture
def ct(window, hand, tmp_path):
    """The window on a CT of air, water and bone, with the form of its layer."""
    nibabel = pytest.importorskip("nibabel")
    values = np.full((12, 40, 44), -1000, np.int16)
    values[:, 5:35, 5:40], values[:, 15:20, 15:20] = 0, 1200
    nibabel.save(nibabel.Nifti1Image(values.T, np.diag([1.0, 1.0, 2.0, 1.0])), tmp_path / "ct.nii.gz")
    window.session.open_file(tmp_path / "ct.nii.gz")
    hand.wait(lambda: window.session.document.image.name == "ct.nii.gz" and window.session.idle)
    window.docks.reveal_panel("layers")
    row = window.panels["layers"].rows["image"]
    hand.qtbot.mouseClick(row.fold, Qt.MouseButton.LeftButton)
    return hand.canvas.layers["image"], row.settings


def test_ct_has_the_usual_windows_in_its_layer(window, ct, hand):
    layer, form = ct
    levels = form.levels
    assert levels.usual.isVisible()
    assert levels.figures.text() == "W 2200  L 100"
    levels.usual.setFocus()
    for _ in range(3):
        hand.qtbot.keyClick(levels.usual, Qt.Key.Key_Down)
    assert levels.usual.currentText() == "Lung  W 1500  L -600"
    assert layer.window == (-1350.0, 150.0)
    assert (levels.low.value(), levels.high.value(), levels.figures.text()) == (-1350.0, 150.0, "W 1500  L -600")
    assert layer.get_choice("range") == "hand"
    layer.set_window(0.0, 80.0)
    assert levels.usual.currentText().startswith("Brain")
    window.actions_by_name["levels_full"].trigger()
    assert levels.usual.currentIndex() == -1


def test_what_is_no_ct_has_no_windows_of_ct(window, deep, hand):
    _, form, _ = deep
    assert not form.levels.usual.isVisible()
    assert form.levels.figures.text() == "W 199  L 3100"
