"""A large image offers what suits it in one line, and one click takes it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt

from cpm_core.parameters import PRESETS
from cpm_core.segmentation import large_images

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def bar(window, hand, tmp_path: Path, monkeypatch):
    """The line above a noisy image that counts as large."""
    for name, value in (("LARGE_IMAGE_PIXELS", 120 * 120), ("_COARSEST_SCALE_SIDE", 16), ("_SAMPLE_SIDE", 64)):
        monkeypatch.setattr(large_images, name, value)
    row, col = np.indices((128, 128))
    noise = np.random.default_rng(4).normal(0.0, 40.0, row.shape)
    np.save(tmp_path / "large.npy", 60.0 + 120.0 * (np.hypot(row - 64, col - 64) < 40) + noise)
    window.open_image(str(tmp_path / "large.npy"))
    hand.wait(lambda: window.session.document.image.name == "large.npy" and window.session.idle)
    return window.offers


def test_one_click_takes_what_suits_a_large_image_and_one_key_takes_it_back(window, hand, bar):
    before = window.session.document
    assert before.parameters == PRESETS["shape"]
    assert "4 scales" in bar.text
    hand.qtbot.mouseClick(bar.buttons[0], Qt.MouseButton.LeftButton)
    parameters = window.session.document.parameters
    assert parameters.scales == 4
    assert parameters.smoothing > 1.0
    assert not bar.text
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document == before


def test_an_image_of_common_size_after_it_offers_nothing(window, hand, bar, image_file):
    assert bar.text
    window.session.open_file(image_file)
    hand.wait(lambda: window.session.document.image.name == image_file.name and window.session.idle)
    assert not bar.text


def test_of_two_offers_the_second_waits_until_the_first_is_answered(window, hand, bar):
    bar.add_offer("Something else?", ("Yes", lambda: None))
    assert "4 scales" in bar.text
    hand.qtbot.mouseClick(bar.cross, Qt.MouseButton.LeftButton)
    assert (bar.text, [button.text() for button in bar.buttons]) == ("Something else?", ["Yes"])
    hand.qtbot.mouseClick(bar.cross, Qt.MouseButton.LeftButton)
    assert not bar.text
