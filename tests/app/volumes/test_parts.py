"""Which part of a file is opened: page, channel, point in time and series, chosen by mouse and keys and kept."""

from __future__ import annotations

import json

import numpy as np
import PIL.Image
import pytest
import tifffile
from PySide6.QtCore import Qt

from app.views.features.files import OpenSaveFeature
from app.views.features.offers import StackFeature
from cpm_core import load_image, load_volume
from tests.app.volumes.conftest import SHAPE, ball, open_file

pytestmark = pytest.mark.shared_window


@pytest.fixture
def hyperstack(tmp_path):
    """Two points in time, nine planes and three channels, each brighter than the one before."""
    path = tmp_path / "cells.ome.tif"
    plane = ball()[12].astype(np.uint8)
    pages = np.array([[[plane // 4 + 2 * z + 20 * c + 60 * t for c in range(3)] for z in range(9)] for t in range(2)])
    tifffile.imwrite(path, pages, metadata={"axes": "TZCYX"}, photometric="minisblack")
    return path


def feature(window) -> StackFeature:
    return window.feature(StackFeature)


def ask(window, hand):
    """The dialog, opened by the button of the offer."""
    hand.qtbot.mouseClick(feature(window).bar.buttons[-1], Qt.MouseButton.LeftButton)
    assert feature(window).dialog.isVisible()
    return feature(window).dialog


def choose(window, hand, dialog, **numbers) -> None:
    """Type numbers in the dialog, and open."""
    for name, number in numbers.items():
        field = getattr(dialog, name)
        assert field.isVisible()
        assert field.isEnabled(), name
        field.selectAll()
        hand.qtbot.keyClicks(field, str(number))
    before = window.session.image
    hand.qtbot.mouseClick(dialog.open_button, Qt.MouseButton.LeftButton)
    hand.wait(lambda: window.session.image is not before and window.session.idle)


def test_a_hyperstack_says_what_it_holds_and_opens_each_part(window, hand, hyperstack) -> None:
    open_file(window, hand, hyperstack)
    told = "cells.ome.tif holds 9 pages, 3 channels, 2 points in time. Open now: page 1, channel 1, time 1."
    assert feature(window).bar.text == told
    choose(window, hand, ask(window, hand), page=4, channel=3, time=2)
    expected = load_image(hyperstack, page=4, channel=3, time=2)
    np.testing.assert_array_equal(window.session.image.values, expected.values)
    assert feature(window).bar.text.endswith("Open now: page 4, channel 3, time 2.")


def test_a_volume_of_one_channel_and_time_is_opened_by_the_dialog(window, hand, hyperstack) -> None:
    open_file(window, hand, hyperstack)
    dialog = ask(window, hand)
    dialog.kind.setFocus()
    hand.qtbot.keyClick(dialog.kind, Qt.Key.Key_Up)
    assert dialog.as_volume
    assert not dialog.page.isEnabled(), "a volume has all pages"
    choose(window, hand, dialog, channel=2, time=2)
    expected = load_volume(hyperstack, channel=2, time=2)
    np.testing.assert_array_equal(window.session.image.values, expected.values)


def test_the_menu_opens_the_dialog_again_with_what_is_open(window, hand, hyperstack) -> None:
    open_file(window, hand, hyperstack)
    choose(window, hand, ask(window, hand), page=4, channel=3, time=2)
    window.actions_by_name["choose_part"].trigger()
    dialog = feature(window).dialog
    assert (dialog.page.value(), dialog.channel.value(), dialog.time.value()) == (4, 3, 2)
    dialog.reject()


def test_a_file_of_one_image_has_nothing_to_choose(window, hand, image_file) -> None:
    open_file(window, hand, image_file)
    assert not window.actions_by_name["choose_part"].isEnabled()
    assert not feature(window).bar.text


def test_sessions_and_recent_files_keep_the_part(window, hand, hyperstack, image_file, tmp_path) -> None:
    open_file(window, hand, hyperstack)
    choose(window, hand, ask(window, hand), page=4, channel=3, time=2)
    values = window.session.image.values
    files = window.feature(OpenSaveFeature)
    assert files.document_file.save_at_once(tmp_path / "cells.cpm")
    kept = json.loads((tmp_path / "cells.cpm").read_text())["image"]["reading"]
    assert kept == {"page": 4, "channel": 3, "time": 2}
    open_file(window, hand, image_file)
    window.open_image(str(tmp_path / "cells.cpm"))
    hand.wait(lambda: window.session.document.image.name == hyperstack.name and window.session.idle)
    np.testing.assert_array_equal(window.session.image.values, values)
    open_file(window, hand, image_file)
    open_file(window, hand, hyperstack)
    np.testing.assert_array_equal(window.session.image.values, values)


def test_frames_of_a_film_are_pages(window, hand, tmp_path) -> None:
    frames = [PIL.Image.fromarray(np.full((20, 20), 40 * k, np.uint8) + np.eye(20, dtype=np.uint8)) for k in range(4)]
    frames[0].save(tmp_path / "film.gif", save_all=True, append_images=frames[1:])
    open_file(window, hand, tmp_path / "film.gif")
    assert feature(window).bar.text == "film.gif holds 4 frames. Open now: frame 1."
    choose(window, hand, ask(window, hand), page=3)
    np.testing.assert_array_equal(window.session.image.values, load_image(tmp_path / "film.gif", page=3).values)


def test_arrays_of_an_archive_are_series_and_the_first_is_open(window, hand, tmp_path) -> None:
    path = tmp_path / "two.npz"
    np.savez(path, size=np.array([2.0, 1.0]), first=ball(), second=ball()[:, :, ::2] + 7.0)
    open_file(window, hand, path)
    assert window.session.image.shape == SHAPE
    assert "holds 24 planes, 3 series. Open now: series first." in feature(window).bar.text
    dialog = ask(window, hand)
    dialog.series.setFocus()
    hand.qtbot.keyClick(dialog.series, Qt.Key.Key_Down)
    assert not dialog.open_button.isEnabled(), "what the other series holds is looked for first"
    hand.wait(dialog.open_button.isEnabled)
    choose(window, hand, dialog)
    np.testing.assert_array_equal(window.session.image.values, ball()[:, :, ::2] + 7.0)


def test_points_in_time_of_a_volume_are_chosen(window, hand, tmp_path) -> None:
    nibabel = pytest.importorskip("nibabel")
    values = np.stack([ball().T, ball(4.0).T], axis=-1).astype(np.uint8)
    nibabel.save(nibabel.Nifti1Image(values, np.eye(4)), tmp_path / "beat.nii")
    open_file(window, hand, tmp_path / "beat.nii")
    assert feature(window).bar.text == "beat.nii holds 24 planes, 2 points in time. Open now: time 1."
    choose(window, hand, ask(window, hand), time=2)
    np.testing.assert_array_equal(window.session.image.values, ball(4.0))


def test_gray_levels_of_a_colored_volume_are_chosen(window, hand, tmp_path) -> None:
    colors = np.stack([ball(), ball(4.0), 0.0 * ball()], axis=-1).astype(np.uint8)
    np.savez(tmp_path / "colors.npz", colors=colors, other=ball())
    open_file(window, hand, tmp_path / "colors.npz")
    dialog = ask(window, hand)
    dialog.color.setFocus()
    for _ in range(2):
        hand.qtbot.keyClick(dialog.color, Qt.Key.Key_Down)
    choose(window, hand, dialog)
    np.testing.assert_array_equal(window.session.image.values, ball(4.0))


def test_slices_too_uneven_for_a_volume_open_as_an_image_with_the_reason(window, hand, tmp_path) -> None:
    pydicom = pytest.importorskip("pydicom")
    folder = tmp_path / "series"
    folder.mkdir()
    for index, place in enumerate(np.cumsum(1.0 + np.arange(12.0))):
        write_slice(pydicom, folder / f"{index}.dcm", float(place))
    window.open_image(str(folder))
    hand.wait(lambda: window.session.document.image.name == "series" and window.session.idle)
    assert window.session.image.ndim == 2
    assert "mm apart" in window.canvas_area.messages.text


def write_slice(pydicom, path, place: float) -> None:
    """A slice of a series at a place along the body [mm]."""
    made = pydicom.Dataset()
    made.file_meta = pydicom.dataset.FileMetaDataset()
    made.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
    made.file_meta.MediaStorageSOPClassUID = made.SOPClassUID = pydicom.uid.MRImageStorage
    made.file_meta.MediaStorageSOPInstanceUID = made.SOPInstanceUID = pydicom.uid.generate_uid()
    made.SeriesInstanceUID, made.Modality = "1.2.3", "MR"
    made.ImagePositionPatient, made.ImageOrientationPatient = [0.0, 0.0, place], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    made.PixelSpacing = [1.0, 1.0]
    made.Rows, made.Columns, made.SamplesPerPixel, made.PhotometricInterpretation = 20, 20, 1, "MONOCHROME2"
    made.BitsAllocated = made.BitsStored = 16
    made.HighBit, made.PixelRepresentation = 15, 0
    made.PixelData = (np.arange(400).reshape(20, 20) % 37).astype(np.uint16).tobytes()
    made.save_as(path, enforce_file_format=True)
