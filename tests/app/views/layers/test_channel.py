"""The channel of a color image is chosen in the window, undone, kept in a session, and seen."""

from __future__ import annotations

import numpy as np
import PIL.Image
import pytest
from cpm_app.views.features.files import OpenSaveFeature
from PySide6.QtCore import Qt

pytestmark = pytest.mark.shared_window


@pytest.fixture
def colored(window, hand, tmp_path):
    """The window on a color image: on the left a disc in red alone, on the right one in blue alone."""
    row, col = np.indices((60, 80))
    pixels = np.full((60, 80, 3), 60, np.uint8)
    pixels[np.hypot(row - 30, col - 20) < 12, 0] = 220
    pixels[np.hypot(row - 30, col - 60) < 12, 2] = 220
    PIL.Image.fromarray(pixels).save(tmp_path / "colored.png")
    window.session.open_file(tmp_path / "colored.png")
    hand.wait(lambda: window.session.document.image.name == "colored.png" and window.session.idle)
    return window


def test_a_channel_is_taken_with_the_keys_and_undone(colored, hand) -> None:
    row = colored.panels["run"].parameters.choices["channel"]
    assert row.isVisible()
    row.box.setFocus()
    hand.qtbot.keyClick(row.box, Qt.Key.Key_Down)
    assert colored.session.document.parameters.channel == "red"
    colored.actions_by_name["undo"].trigger()
    assert colored.session.document.parameters.channel == "luminance"
    assert row.box.currentText() == "luminance"


def test_a_session_brings_back_the_channel(colored, hand, image_file, tmp_path) -> None:
    colored.panels["run"].parameters.set_parameter("channel", "blue")
    colored.get_feature(OpenSaveFeature).document_file.save(tmp_path / "kept.cpm")
    colored.session.open_file(image_file)
    hand.wait(lambda: colored.session.document.image.name == image_file.name and colored.session.idle)
    assert colored.session.document.parameters.channel == "luminance"
    colored.session.open_file(tmp_path / "kept.cpm")
    hand.wait(lambda: colored.session.document.image.name == "colored.png" and colored.session.idle)
    assert colored.session.document.parameters.channel == "blue"
    assert colored.panels["run"].parameters.choices["channel"].box.currentText() == "blue"


def test_the_channel_of_the_run_can_be_seen_and_follows_the_choice(colored, hand) -> None:
    layer, panel = hand.canvas.layers["image"], colored.panels["run"].parameters
    assert hand.color_at(30.0, 20.0) == (220, 60, 60)
    layer.set_option("content", "channel")
    panel.set_parameter("channel", "red")
    hand.wait(lambda: hand.color_at(30.0, 20.0)[1] > 200)
    red, green, blue = hand.color_at(30.0, 60.0)
    assert red == green == blue < 100
    panel.set_parameter("channel", "blue")
    hand.wait(lambda: hand.color_at(30.0, 60.0)[1] > 200)
    layer.set_option("content", "colors")
    assert hand.color_at(30.0, 20.0) == (220, 60, 60)


def test_the_option_is_restored_by_its_name_in_older_sessions(colored, hand) -> None:
    layer = hand.canvas.layers["image"]
    for shown in ("channel", "colors"):
        layer.use_view_state({"shown": shown, "opacity": 1.0})
        assert layer.get_choice("content") == shown and layer.shown
