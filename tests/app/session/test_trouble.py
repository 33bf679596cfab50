"""Bad input leads to one clear sentence in one place, and the program goes on with what it had."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Picture
from PySide6.QtCore import QMimeData, QPoint, Qt, QUrl
from PySide6.QtGui import QDropEvent

pytestmark = pytest.mark.shared_window

KEY = Qt.Key


def no_image(folder: Path) -> Path:
    path = folder / "notes.png"
    path.write_text("this is no picture")
    return path


def one_pixel(folder: Path) -> Path:
    path = folder / "pixel.png"
    Picture.new("L", (1, 1)).save(path)
    return path


def constant(folder: Path) -> Path:
    path = folder / "flat.png"
    Picture.new("L", (32, 32), 7).save(path)
    return path


def not_a_number(folder: Path) -> Path:
    path = folder / "endless.npy"
    values = np.eye(32)
    values[3, 4] = np.inf
    np.save(path, values)
    return path


def missing(folder: Path) -> Path:
    return folder / "nowhere.png"


def folder_itself(folder: Path) -> Path:
    return folder


def test_an_unusable_file_is_reported_in_one_sentence_and_the_image_stays(ready, hand, tmp_path, cases) -> None:
    for make in cases([no_image, one_pixel, constant, not_a_number, missing, folder_itself]):
        document, step = ready.session.document, ready.session.status.step
        ready.session.open_file(make(tmp_path))
        hand.wait(lambda: bool(ready.canvas_area.messages.text))
        hand.wait(lambda: ready.session.idle)
        said = ready.canvas_area.messages.text
        assert said.endswith(".")
        assert "\n" not in said
        assert "An unexpected error" not in said
        assert "Traceback" not in said
        assert ready.session.document == document
        hand.key(KEY.Key_Escape)
        assert ready.canvas_area.messages.text == ""
        hand.key(KEY.Key_Period)
        hand.wait(lambda step=step: ready.session.status.step == step + 1)


def test_a_run_goes_on_while_another_file_turns_out_to_be_unusable(ready, hand, tmp_path) -> None:
    ready.session.set_pace(30.0)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: ready.session.status.step >= 1)
    ready.session.open_file(no_image(tmp_path))
    hand.wait(lambda: bool(ready.canvas_area.messages.text))
    step = ready.session.status.step
    hand.wait(lambda: ready.session.status.step > step or ready.session.status.phase == "finished")


def test_a_dropped_file_is_opened_and_a_remote_address_is_reported(window, hand, tmp_path) -> None:
    path = tmp_path / "dropped.npy"
    np.save(path, np.eye(20))

    def drop(url: QUrl) -> None:
        data = QMimeData()
        data.setUrls([url])
        actions, button = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
        event = QDropEvent(QPoint(50, 50), actions, data, button, Qt.KeyboardModifier.NoModifier)
        window.dropEvent(event)

    drop(QUrl("https://example.org/picture.png"))
    assert "not a file on this computer" in window.canvas_area.messages.text
    drop(QUrl.fromLocalFile(str(path)))
    hand.wait(lambda: window.session.document.image.name == "dropped.npy")
