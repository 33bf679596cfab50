"""A second image lies over the first in all slices, by its place in space; it is undone, saved and removed."""

from __future__ import annotations

import nibabel
import numpy as np
import pytest
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import SlicesFeature, SpaceFeature
from PySide6.QtCore import QMimeData, QPoint, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QFileDialog

from cpm_core.formats.masks.labels import label_palette
from tests.app.views.volume.conftest import ball, open_file

pytestmark = pytest.mark.shared_window

KEY, CONTROL, SHIFT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


def save(path, values, affine):
    nibabel.save(nibabel.Nifti1Image(values, affine), path)  # type: ignore[no-untyped-call]
    return path


@pytest.fixture
def head(window, hand, tmp_path):
    """A window on a ball with a place in space, the axes of the array being (x, y, z)."""
    affine = np.diag([1.0, 1.0, 2.0, 1.0])
    open_file(window, hand, save(tmp_path / "head.nii", ball(shape=(32, 28, 24)), affine))
    return window


@pytest.fixture
def labels(tmp_path):
    """Labels of half the voxels a side, turned, 4 mm from the first voxel of the head; label 2 in a block."""
    values = np.zeros((12, 16, 20), np.uint8)
    values[4:8, 4:10, 2:12] = 2
    affine = np.array([[0.0, 1.5, 0.0, 4.0], [0.0, 0.0, 1.0, 4.0], [2.5, 0.0, 0.0, 4.0], [0.0, 0.0, 0.0, 1.0]])
    return save(tmp_path / "labels.nii", values, affine)


def drop(window, path, keys) -> None:
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    actions = Qt.DropAction.CopyAction | Qt.DropAction.MoveAction
    event = QDropEvent(QPoint(50, 50), actions, data, Qt.MouseButton.LeftButton, keys)
    event.setDropAction(Qt.DropAction.MoveAction)
    window.dropEvent(event)
    assert event.isAccepted() and event.dropAction() == Qt.DropAction.CopyAction


def test_labels_dropped_with_shift_are_shown_where_they_lie_and_undone(head, hand, labels) -> None:
    drop(head, labels, SHIFT)
    hand.wait(lambda: head.session.scene.second is not None)
    second, image = head.session.scene.second, head.session.image
    assert head.session.document.image.name == "head.nii" and second.is_labels
    assert set(np.unique(second.shades)) == {0, 2}
    inverse = np.linalg.inv(np.array([[0, 1.5, 0, 4], [0, 0, 1, 4], [2.5, 0, 0, 4], [0, 0, 0, 1.0]]))
    voxels = np.stack([*np.indices(image.shape, float), np.ones(image.shape)]).reshape(4, -1)
    there = np.rint(inverse @ image.geometry.affine(image.spacing, "RAS") @ voxels)[:3]
    expected = np.all(
        [(at >= low) & (at < high) for at, low, high in zip(there, (4, 4, 2), (8, 10, 12), strict=True)], axis=0
    )
    assert (expected.reshape(image.shape) != (second.shades == 2)).mean() < 0.002  # halfway between two voxels
    for view in (head.canvas_area.canvas, *head.get_feature(SlicesFeature).sides):
        layer = view.layers["second"]
        assert layer.item.isVisible() and layer.opacity == 0.5
        np.testing.assert_array_equal(layer.item.display.shades, view.shown_slice.slice_array(second.shades))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: head.session.scene.second is None)
    assert not head.canvas_area.canvas.layers["second"].item.isVisible()


def test_a_gray_image_is_opened_by_the_menu_switched_saved_and_removed(head, hand, tmp_path, monkeypatch) -> None:
    pet = save(tmp_path / "pet.nii", np.indices((40, 40, 40))[0] / 3.0, np.diag([1.0, 1.0, 1.5, 1.0]))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(pet), ""))
    head.trigger_action("second_image")
    hand.wait(lambda: head.session.scene.second is not None)
    second, layer = head.session.scene.second, head.canvas_area.canvas.layers["second"]
    columns = np.diff(np.moveaxis(second.shades, -1, 0).reshape(second.shades.shape[-1], -1).max(axis=1).astype(int))
    assert not second.is_labels and ((columns > 0).all() or (columns < 0).all())
    head.actions_by_name["layer_second"].trigger()
    assert not layer.item.isVisible()
    head.actions_by_name["layer_second"].trigger()
    saved = tmp_path / "kept.cpm"
    head.get_feature(OpenSaveFeature).document_file.save_and_wait(saved)
    head.trigger_action("remove_second_image")
    assert head.session.scene.second is None and head.session.document.second is None
    head.open_image(str(saved))
    hand.wait(lambda: head.session.scene.second is not None)
    np.testing.assert_array_equal(head.session.scene.second.shades, second.shades)
    assert not head.get_feature(OpenSaveFeature).document_file.unsaved


def test_the_second_image_is_seen_in_space_in_slices_and_as_brightest_voxels(head, hand, labels) -> None:
    view = head.get_feature(SpaceFeature).panel.view
    bar = head.get_feature(SpaceFeature).panel.bar
    table = label_palette(255)[1].astype(int)

    def count_colored() -> int:
        hand.wait(lambda: view.is_idle)
        colors = view._frame.picture.colors.astype(int)
        return int((np.ptp(colors, axis=-1) > 0.4 * np.ptp(table)).sum())

    for part in ("slices", "projection"):
        bar.checks[part].setChecked(True)
        plain = count_colored()
        drop(head, labels, SHIFT)
        hand.wait(lambda: head.session.scene.second is not None)
        assert count_colored() > plain + 50, part
        head.actions_by_name["layer_second"].trigger()
        assert count_colored() == plain, part
        head.actions_by_name["layer_second"].trigger()
        head.trigger_action("remove_second_image")
        hand.wait(lambda: head.session.scene.second is None)
        bar.checks[part].setChecked(False)


def test_a_mask_of_an_image_lies_over_it(window, hand, tmp_path) -> None:
    mask = np.zeros((64, 64), np.uint8)
    mask[20:40, 10:50] = 1
    np.save(tmp_path / "mask.npy", mask)
    drop(window, tmp_path / "mask.npy", SHIFT)
    hand.wait(lambda: window.session.scene.second is not None)
    np.testing.assert_array_equal(hand.canvas.layers["second"].item.display.shades, mask)
    assert hand.color_at(30, 12) != hand.color_at(5, 12)


def test_a_picture_cannot_lie_over_a_volume_and_says_so(head, hand, image_file) -> None:
    drop(head, image_file, SHIFT)
    hand.wait(
        lambda: "is an image, but" in head.canvas_area.messages.text or "volume" in head.canvas_area.messages.text
    )
    assert head.session.document.second is None and head.session.scene.second is None
