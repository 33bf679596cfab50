"""The size of a voxel is shown, and set by hand where a file does not tell it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.views.features.files import OpenSaveFeature
from app.views.features.offers import PixelSizeFeature
from app.views.features.run import TimelineFeature
from app.views.features.volumes import SlicesFeature, SpaceFeature
from cpm_core import load_volume
from tests.app.volumes.conftest import open_file

pytestmark = pytest.mark.shared_window

CONTROL = Qt.KeyboardModifier.ControlModifier


def label(window):
    return window.feature(SlicesFeature).bar.voxel


def size(window):
    """The size of a voxel by all that tell it: image, document and view in space."""
    image, reference = window.session.image, window.session.document.image
    assert (image.spacing, image.unit) == (reference.spacing, reference.unit)
    assert window.feature(SpaceFeature).panel.contents.image is image
    return image.spacing, image.unit


def choose(window, hand, sizes, unit) -> None:
    """Type a size in the dialog that a click on the label opens, and use it."""
    hand.qtbot.mouseClick(label(window), Qt.MouseButton.LeftButton)
    dialog = window.feature(PixelSizeFeature).dialog
    for field, number in zip(dialog.sides, sizes, strict=True):
        field.selectAll()
        hand.qtbot.keyClicks(field, str(number))
    dialog.unit.setCurrentText(unit)
    hand.qtbot.mouseClick(dialog.use_button, Qt.MouseButton.LeftButton)


def test_a_volume_without_a_size_offers_to_set_it(volume, hand) -> None:
    bar = volume.feature(PixelSizeFeature).bar
    assert "does not tell the size of a voxel" in bar.text
    hand.qtbot.mouseClick(bar.buttons[0], Qt.MouseButton.LeftButton)
    assert volume.feature(PixelSizeFeature).dialog.isVisible()
    volume.feature(PixelSizeFeature).dialog.reject()


def test_the_size_that_is_set_is_shown_taken_back_and_set_again(volume, hand) -> None:
    values, gray = volume.session.image.values, volume.canvas_area.canvas.layers.image
    gray.choose_window(30.0, 90.0)
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


def test_a_run_from_before_another_size_is_repeated_with_its_own_size_from_a_session(volume, hand, tmp_path) -> None:
    """States are in the session for the last step alone; the others are computed again."""
    hand.drag((13.5, 15.5), (13.5, 19.5))
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    choose(volume, hand, (3.0, 0.5, 0.5), "mm")
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: volume.session.status.phase == "finished" and not volume.session.status.stale)
    navigation = volume.feature(TimelineFeature).navigation
    hand.wait(lambda: len(navigation.outline.branches) == 2)
    first = navigation.outline.branches[0].identity

    def at_step(step: int) -> np.ndarray:
        navigation.go(first, step)
        hand.wait(lambda: navigation.place == (first, step) and volume.session.idle)
        return volume.session.scene.snapshot.position.copy()

    known = at_step(7)
    files = volume.feature(OpenSaveFeature)
    assert files.document_file.save_at_once(tmp_path / "ball.cpm")
    volume.open_image(str(tmp_path / "ball.cpm"))
    hand.wait(lambda: volume.session.idle and len(navigation.outline.branches) == 2)
    at_step(3)
    np.testing.assert_array_equal(at_step(7), known)
    assert volume.session.image.spacing == (3.0, 0.5, 0.5)


def test_a_session_keeps_the_size_and_another_program_reads_it(volume, hand, tmp_path, volume_file) -> None:
    choose(volume, hand, (2.0, 0.5, 0.5), "mm")
    files = volume.feature(OpenSaveFeature)
    assert files.document_file.save_at_once(tmp_path / "ball.cpm")
    kept = json.loads((tmp_path / "ball.cpm").read_text())["image"]["reading"]
    assert kept == {"spacing": [2.0, 0.5, 0.5], "unit": "mm"}
    assert load_volume(volume_file, **kept).spacing == (2.0, 0.5, 0.5)
    open_file(volume, hand, volume_file)
    volume.open_image(str(tmp_path / "ball.cpm"))
    hand.wait(lambda: volume.session.image.unit == "mm" and volume.session.idle)
    assert size(volume) == ((2.0, 0.5, 0.5), "mm")
    hand.qtbot.mouseClick(label(volume), Qt.MouseButton.LeftButton)
    dialog = volume.feature(PixelSizeFeature).dialog
    hand.qtbot.mouseClick(dialog.reset_button, Qt.MouseButton.LeftButton)
    assert size(volume) == ((1.0, 1.0, 1.0), None)


def test_the_size_of_a_pixel_of_an_image_can_be_set_as_well(window, hand) -> None:
    window.actions_by_name["pixel_size"].trigger()
    dialog = window.feature(PixelSizeFeature).dialog
    for field in dialog.sides:
        field.setValue(0.25)
    dialog.unit.setCurrentText("µm")
    hand.qtbot.mouseClick(dialog.use_button, Qt.MouseButton.LeftButton)
    assert (window.session.image.spacing, window.session.image.unit) == ((0.25, 0.25), "µm")
    assert window.canvas_area.canvas.layers["scale_bar"].item.isVisible()


def test_a_size_that_no_voxel_has_is_refused_in_a_sentence(volume, hand) -> None:
    choose(volume, hand, (100000.0, 0.001, 0.5), "mm")
    assert size(volume)[1] is None
    assert "The size of a voxel" in volume.canvas_area.messages.text


def test_the_action_is_in_the_menu_under_the_name_of_what_is_open(volume, hand, image_file) -> None:
    action = volume.actions_by_name["pixel_size"]
    assert action.text().replace("&", "") == "Size of a voxel…"
    open_file(volume, hand, image_file)
    assert action.text().replace("&", "") == "Size of a pixel…"
