"""The size of a voxel is shown, and set by hand where a file does not state it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.offers import PixelSizeFeature
from cpm_app.views.features.volumes import SlicesFeature, SpaceFeature
from PySide6.QtCore import Qt

from cpm_core import load_volume
from tests.app.views.volume.conftest import open_file

pytestmark = pytest.mark.shared_window

CONTROL = Qt.KeyboardModifier.ControlModifier


def label(window):
    return window.get_feature(SlicesFeature).bar.voxel


def size(window):
    """The size of a voxel by all that tell it: image, document and view in space."""
    image, reference = window.session.image, window.session.document.image
    assert (image.spacing, image.unit) == (reference.spacing, reference.unit)
    assert window.get_feature(SpaceFeature).panel.contents.image is image
    return image.spacing, image.unit


def choose(window, hand, sizes, unit) -> None:
    """Type a size in the dialog that a click on the label opens, and use it."""
    hand.qtbot.mouseClick(label(window), Qt.MouseButton.LeftButton)
    dialog = window.get_feature(PixelSizeFeature).dialog
    for field, number in zip(dialog.sides, sizes, strict=True):
        field.selectAll()
        hand.qtbot.keyClicks(field, str(number))
    dialog.unit.setCurrentText(unit)
    hand.qtbot.mouseClick(dialog.use_button, Qt.MouseButton.LeftButton)


def test_the_size_that_is_set_is_shown_taken_back_and_set_again(volume, hand) -> None:
    values, gray = volume.session.image.values, volume.canvas_area.canvas.layers.image
    gray.set_window(30.0, 90.0)
    choose(volume, hand, (2.0, 0.5, 0.5), "mm")
    assert size(volume) == ((2.0, 0.5, 0.5), "mm")
    assert label(volume).text() == "2 × 0.5 × 0.5 mm"
    assert volume.session.image.values is values, "gray values are shared, not copied"
    assert gray.window == (30.0, 90.0)
    hand.key(Qt.Key.Key_Z, CONTROL)
    assert size(volume) == ((1.0, 1.0, 1.0), None)
    assert label(volume).text() == "Size…"
    hand.key(Qt.Key.Key_Y, CONTROL)
    assert size(volume) == ((2.0, 0.5, 0.5), "mm")


def test_a_run_takes_the_size_and_one_before_it_is_out_of_date(volume, hand) -> None:
    hand.drag((13.5, 15.5), (13.5, 19.5))
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    assert not volume.session.status.stale
    choose(volume, hand, (1.0, 0.5, 0.5), "mm")
    assert volume.session.status.stale
    hand.key(Qt.Key.Key_Z, CONTROL)
    assert not volume.session.status.stale
    hand.key(Qt.Key.Key_Y, CONTROL)
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: volume.session.status.phase == "finished" and not volume.session.status.stale)
    hand.wait(lambda: volume.session.idle)
    assert volume.session.scene.reconstruction.result.image.spacing == (1.0, 0.5, 0.5)


def test_a_session_keeps_the_size_and_another_program_reads_it(volume, hand, tmp_path, volume_file) -> None:
    choose(volume, hand, (2.0, 0.5, 0.5), "mm")
    files = volume.get_feature(OpenSaveFeature)
    assert files.document_file.save_and_wait(tmp_path / "ball.cpm")
    kept = json.loads((tmp_path / "ball.cpm").read_text())["image"]["reading"]
    assert kept == {"spacing": [2.0, 0.5, 0.5], "unit": "mm"}
    assert load_volume(volume_file, **kept).spacing == (2.0, 0.5, 0.5)
    open_file(volume, hand, volume_file)
    volume.open_image(str(tmp_path / "ball.cpm"))
    hand.wait(lambda: volume.session.image.unit == "mm" and volume.session.idle)
    assert size(volume) == ((2.0, 0.5, 0.5), "mm")
    hand.qtbot.mouseClick(label(volume), Qt.MouseButton.LeftButton)
    dialog = volume.get_feature(PixelSizeFeature).dialog
    hand.qtbot.mouseClick(dialog.reset_button, Qt.MouseButton.LeftButton)
    assert size(volume) == ((1.0, 1.0, 1.0), None)


def test_a_run_on_voxels_that_are_no_cubes_is_there_again_after_opening(volume, hand, tmp_path, volume_file) -> None:
    choose(volume, hand, (0.2, 1.0, 1.0), "mm")
    hand.drag((13.5, 15.5), (13.5, 19.5))
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    found = volume.session.scene.snapshot.position
    volume.get_feature(OpenSaveFeature).document_file.save_and_wait(tmp_path / "ball.cpm")
    open_file(volume, hand, volume_file)
    said: list[str] = []
    volume.session.messages.shown.connect(lambda text, _: said.append(text))
    volume.open_image(str(tmp_path / "ball.cpm"))
    hand.wait(lambda: volume.session.image.unit == "mm" and volume.session.idle)
    assert not [text for text in said if "damaged" in text]
    np.testing.assert_array_equal(volume.session.scene.snapshot.position, found)
