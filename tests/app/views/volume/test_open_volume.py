"""A volume is opened and seen slice by slice, by mouse and keys."""

from __future__ import annotations

import numpy as np
import pytest
import tifffile
from cpm_app.views.features.offers import FilePartsFeature
from cpm_app.views.features.volumes import SlicesFeature
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

from cpm_core import PRESETS
from tests.app.views.volume.conftest import SHAPE, ball, open_file

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
MIDDLE = tuple(side // 2 for side in SHAPE)


def bar(window):
    return window.get_feature(SlicesFeature).bar


def shown(window):
    """Axis and index of the slice that is shown."""
    current = window.canvas_area.canvas.drawn_scene.slices.current
    return current.axis, current.index


def turn_wheel(window, notches: int) -> None:
    port = window.canvas_area.canvas.viewport()
    at = QPointF(port.rect().center())
    event = QWheelEvent(at, port.mapToGlobal(at), QPoint(), QPoint(0, -120 * notches), Qt.MouseButton.NoButton,
                        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    QApplication.sendEvent(port, event)


def test_a_volume_opens_at_its_middle_plane_with_the_preset_for_volumes(volume) -> None:
    assert volume.session.document.parameters == PRESETS["volume"]
    assert bar(volume).isVisible()
    assert shown(volume) == (0, MIDDLE[0])
    np.testing.assert_array_equal(volume.canvas_area.canvas.drawn_scene.image.values, ball()[MIDDLE[0]])


def test_keys_wheel_slider_and_field_go_through_the_slices(volume, hand) -> None:
    hand.key(KEY.Key_PageDown)
    assert shown(volume) == (0, 13)
    hand.key(KEY.Key_PageUp)
    hand.key(KEY.Key_PageUp)
    assert shown(volume) == (0, 11)
    turn_wheel(volume, 3)
    assert shown(volume) == (0, 14)
    bar(volume).slider.setFocus()
    hand.qtbot.keyClick(bar(volume).slider, KEY.Key_Home)
    assert shown(volume) == (0, 0)
    hand.key(KEY.Key_PageUp)
    assert shown(volume) == (0, 0), "there is no slice before the first"
    bar(volume).number.selectAll()
    hand.qtbot.keyClicks(bar(volume).number, "20")
    hand.qtbot.keyClick(bar(volume).number, KEY.Key_Return)
    assert shown(volume) == (0, 19)
    assert bar(volume).slider.value() == 20
    assert bar(volume).total_label.text() == "of 24"


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_each_axis_has_its_slices_in_the_same_gray_values(volume, hand, axis) -> None:
    hand.qtbot.mouseClick(bar(volume).axes[axis], Qt.MouseButton.LeftButton)
    assert shown(volume) == (axis, MIDDLE[axis])
    canvas = volume.canvas_area.canvas
    for index in (MIDDLE[axis], 0):
        volume.workspace.slices.go_to(index)
        np.testing.assert_array_equal(canvas.drawn_scene.image.values, np.take(ball(), index, axis=axis))
        assert canvas.layers["image"].window == (20.0, 200.0)
    assert canvas.layers["image"].shades.max() == 0, "what is even in one slice stays as dark as in the volume"


def test_a_stack_opens_at_its_first_page_and_as_one_volume_on_request(window, hand, tmp_path) -> None:
    path = tmp_path / "stack.tif"
    pages = ball().astype(np.uint8) + np.arange(SHAPE[2], dtype=np.uint8)  # no page is even
    tifffile.imwrite(path, pages, photometric="minisblack")
    open_file(window, hand, path)
    assert window.session.image.ndim == 2
    offer = window.offers
    assert offer.text == "stack.tif contains 24 pages. Open now: page 1."
    hand.qtbot.mouseClick(offer.buttons[0], Qt.MouseButton.LeftButton)
    hand.wait(lambda: window.session.image.ndim == 3 and window.session.idle)
    np.testing.assert_array_equal(window.session.image.values, pages)
    window.actions_by_name["parts"].trigger()
    dialog = window.get_feature(FilePartsFeature).dialog
    hand.qtbot.keyClick(dialog.kind, Qt.Key.Key_Down)
    hand.qtbot.mouseClick(dialog.open_button, Qt.MouseButton.LeftButton)
    hand.wait(lambda: window.session.image.ndim == 2 and window.session.idle)
    assert not bar(window).isVisible()


def test_voxels_that_are_no_cubes_are_shown_as_they_are_in_space(window, hand, tmp_path) -> None:
    nibabel = pytest.importorskip("nibabel")
    path = tmp_path / "flat.nii"
    image = nibabel.Nifti1Image(ball().astype(np.uint8), np.diag([1.0, 1.0, 2.0, 1.0]))
    nibabel.save(image, path)
    open_file(window, hand, path)
    canvas = window.canvas_area.canvas
    assert "2 × 1 × 1 mm" in bar(window).voxel.text()
    hand.qtbot.mouseClick(bar(window).axes[1], Qt.MouseButton.LeftButton)
    width, height = canvas.view.viewPixelSize()
    assert width == pytest.approx(2.0 * height), "a pixel that is twice as high takes twice the screen"
