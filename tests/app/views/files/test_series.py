"""Series of DICOM slices in the window: with a gap, two spacings, at a slant, of several times, with no even part."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.views.features.offers import FilePartsFeature
from PySide6.QtCore import Qt

from cpm_core import load_volume
from tests.app.views.volume.conftest import open_file
from tests.core.formats.images.made import VALUES, write_series, write_slice

pytestmark = pytest.mark.shared_window

pytest.importorskip("pydicom")

MANY = np.concatenate([VALUES, VALUES + 1, VALUES + 2])


def bar(window):
    return window.offers


def answer(window, hand, text: str) -> None:
    button = next(button for button in bar(window).buttons if button.text() == text)
    hand.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def write_times(folder, count: int = 9, times: int = 2) -> None:
    folder.mkdir()
    for time in range(times):
        for plane in range(count):
            name, place = f"{time}_{plane}.dcm", (0.0, 0.0, 2.0 * plane)
            values = VALUES[plane] + 100 * time
            write_slice(folder / name, values, place, number=plane + 1, TemporalPositionIdentifier=time + 1)


def test_a_series_with_a_gap_opens_its_longest_even_part_says_so_and_offers_the_other(window, hand, tmp_path) -> None:
    write_series(tmp_path / "s", [*range(9), *range(11, 22)], values=MANY)
    open_file(window, hand, tmp_path / "s")
    assert window.session.image.shape[0] == 11
    assert np.array_equal(window.session.image.values, load_volume(tmp_path / "s").values)
    assert bar(window).text == "s: " + " ".join(window.session.image.notes)
    answer(window, hand, "Choose…")
    dialog = window.get_feature(FilePartsFeature).dialog
    assert dialog.series.itemText(1) == "2: head, slices 1 to 9"
    dialog.series.setFocus()
    hand.qtbot.keyClick(dialog.series, Qt.Key.Key_Down)
    hand.wait(dialog.open_button.isEnabled)
    before = window.session.image
    hand.qtbot.mouseClick(dialog.open_button, Qt.MouseButton.LeftButton)
    hand.wait(lambda: window.session.image is not before and window.session.idle)
    assert np.array_equal(window.session.image.values, MANY[:9])


def test_of_several_times_the_first_is_opened_and_the_others_are_offered(window, hand, tmp_path) -> None:
    write_times(tmp_path / "s")
    open_file(window, hand, tmp_path / "s")
    assert np.array_equal(window.session.image.values, VALUES[:9])
    assert bar(window).text == "s contains 9 planes, 2 points in time. Open now: time 1."
    answer(window, hand, "Choose…")
    dialog = window.get_feature(FilePartsFeature).dialog
    dialog.time.selectAll()
    hand.qtbot.keyClicks(dialog.time, "2")
    before = window.session.image
    hand.qtbot.mouseClick(dialog.open_button, Qt.MouseButton.LeftButton)
    hand.wait(lambda: window.session.image is not before and window.session.idle)
    assert np.array_equal(window.session.image.values, VALUES[:9] + 100)


def test_without_an_even_part_a_slice_is_opened_and_no_volume_is_offered(window, hand, tmp_path) -> None:
    write_series(tmp_path / "s", [0, 1, 2, 3, 4, 9, 10, 11, 12])
    open_file(window, hand, tmp_path / "s")
    assert window.session.image.ndim == 2
    assert "A volume needs at least 8 planes" in window.canvas_area.messages.text
    assert bar(window).text.endswith("4 slices are missing. The longest even part has 5 slices, 1 to 5, 1 mm apart.")
    assert [button.text() for button in bar(window).buttons] == ["Choose…"]
    window.actions_by_name["parts"].trigger()
    dialog = window.get_feature(FilePartsFeature).dialog
    assert [dialog.kind.itemText(row) for row in range(dialog.kind.count())] == ["One as an image"]
    dialog.reject()


def test_a_slice_offers_the_series_around_it(window, hand, tmp_path) -> None:
    write_series(tmp_path / "s", range(10))
    slices = sorted((tmp_path / "s").iterdir())
    open_file(window, hand, slices[3])
    assert window.session.image.ndim == 2
    assert bar(window).text == f"{slices[3].name} seems to be one slice of a series in the folder s."
    window.actions_by_name["parts"].trigger()
    dialog = window.get_feature(FilePartsFeature).dialog
    hand.qtbot.keyClick(dialog.kind, Qt.Key.Key_Down)
    assert dialog.kind.currentText() == "The whole series in s"
    hand.qtbot.mouseClick(dialog.open_button, Qt.MouseButton.LeftButton)
    hand.wait(lambda: window.session.document.image.name == "s" and window.session.idle)
    open_file(window, hand, slices[3])
    answer(window, hand, "Open the series")
    hand.wait(lambda: window.session.document.image.name == "s" and window.session.idle)
    assert np.array_equal(window.session.image.values, VALUES)
    assert bar(window).text == ""
