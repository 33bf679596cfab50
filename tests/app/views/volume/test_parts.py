"""Which part of a file is opened: page, channel, point in time and series, chosen by mouse and keys and kept."""

from __future__ import annotations

import json

import numpy as np
import pytest
import tifffile
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.offers import FilePartsFeature
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel

from cpm_core import load_image, load_volume
from tests.app.views.volume.conftest import ball, open_file

pytestmark = pytest.mark.shared_window


@pytest.fixture
def hyperstack(tmp_path):
    """Two points in time, nine planes and three channels, each brighter than the one before."""
    path = tmp_path / "cells.ome.tif"
    plane = ball()[12].astype(np.uint8)
    pages = np.array([[[plane // 4 + 2 * z + 20 * c + 60 * t for c in range(3)] for z in range(9)] for t in range(2)])
    tifffile.imwrite(path, pages, metadata={"axes": "TZCYX"}, photometric="minisblack")
    return path


def feature(window) -> FilePartsFeature:
    return window.get_feature(FilePartsFeature)


def ask(window, hand):
    """The dialog, opened by the button of the offer."""
    hand.qtbot.mouseClick(window.offers.buttons[-1], Qt.MouseButton.LeftButton)
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
    contents = "cells.ome.tif contains 9 pages, 3 channels, 2 points in time."
    told = f"{contents} Open now: page 1, time 1. Runs and clicks work on channel 1."
    assert window.offers.findChild(QLabel).text() == told
    # of its channels all are shown
    assert "channel" not in window.canvas_area.messages.text and "time" in window.canvas_area.messages.text
    choose(window, hand, ask(window, hand), page=4, channel=3, time=2)
    expected = load_image(hyperstack, page=4, channel=3, time=2)
    np.testing.assert_array_equal(window.session.image.values, expected.values)
    assert (
        window.offers.findChild(QLabel).text().endswith("Open now: page 4, time 2. Runs and clicks work on channel 3.")
    )


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
    window.actions_by_name["parts"].trigger()
    dialog = feature(window).dialog
    assert (dialog.page.value(), dialog.channel.value(), dialog.time.value()) == (4, 3, 2)
    dialog.reject()


def test_a_file_of_one_image_has_nothing_to_choose(window, hand, image_file) -> None:
    open_file(window, hand, image_file)
    assert not window.actions_by_name["parts"].isEnabled()
    assert not window.offers.findChild(QLabel).text()


def test_sessions_and_recent_files_keep_the_part(window, hand, hyperstack, image_file, tmp_path) -> None:
    open_file(window, hand, hyperstack)
    choose(window, hand, ask(window, hand), page=4, channel=3, time=2)
    values = window.session.image.values
    files = window.get_feature(OpenSaveFeature)
    assert files.document_file.save_and_wait(tmp_path / "cells.cpm")
    kept = json.loads((tmp_path / "cells.cpm").read_text())["image"]["reading"]
    assert kept == {"page": 4, "channel": 3, "time": 2}
    open_file(window, hand, image_file)
    window.open_image(str(tmp_path / "cells.cpm"))
    hand.wait(lambda: window.session.document.image.name == hyperstack.name and window.session.idle)
    np.testing.assert_array_equal(window.session.image.values, values)
    open_file(window, hand, image_file)
    open_file(window, hand, hyperstack)
    np.testing.assert_array_equal(window.session.image.values, values)


def test_infrared_next_to_color_is_a_channel_that_can_be_chosen(window, hand, tmp_path) -> None:
    path, plane = tmp_path / "field.tif", ball()[12].astype(np.uint8)
    bands = np.stack([plane // 4, plane // 3, plane // 2, plane], axis=-1)
    tifffile.imwrite(path, bands, photometric="rgb", extrasamples=["unspecified"])
    open_file(window, hand, path)
    assert window.session.image.colors is not None
    dialog = ask(window, hand)
    assert dialog.channel.text().startswith("Red, green and blue")
    choose(window, hand, dialog, channel=4)
    np.testing.assert_array_equal(window.session.image.values, plane)
    assert window.offers.findChild(QLabel).text().endswith("Open now: channel 4.")
