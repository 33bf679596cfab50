"""The session applied to a folder of images gives the same as the command line, and stops when it is canceled."""

from __future__ import annotations

import multiprocessing
import shlex

import pytest
from cpm_app.views.window.window import MainWindow
from PIL import Image as Picture
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from cpm_core import cli
from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An image and one that is damaged, in a folder that is chosen."""
    place = tmp_path / "images"
    place.mkdir()
    Picture.fromarray(disc().astype("uint8")).save(place / "disc.png")
    (place / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n broken")
    (place / "notes.txt").write_text("no image")
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(place))
    return place


def apply(hand: Hand) -> None:
    hand.key(Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier)


def test_a_folder_is_run_as_by_the_command_line(ready: MainWindow, hand: Hand, folder, tmp_path) -> None:
    apply(hand)
    assert not ready.actions_by_name["apply_to_folder"].isEnabled()
    hand.wait(lambda: ready.canvas_area.messages.text.startswith("1 of 2 images finished. 1 could not be used."))
    assert ready.actions_by_name["apply_to_folder"].isEnabled()
    images = " ".join(shlex.quote(str(path)) for path in sorted(folder.glob("*.png")))
    command = f"batch {images} --session {folder}/contours/session.cpm --output {tmp_path}/again --workers 1"
    assert cli.main(shlex.split(command)) == 1
    for file in (tmp_path / "again").iterdir():
        if file.name != "summary.csv":
            assert file.read_bytes() == (folder / "contours" / file.name).read_bytes()
    assert {path.name for path in (folder / "contours").iterdir()} == {
        *("session.cpm", "summary.csv", "measures.csv"),
        *(f"disc_contours.{suffix}" for suffix in ("svg", "measures.csv", "png")),
    }


def test_it_stops_when_it_is_canceled_and_leaves_no_process(ready: MainWindow, hand: Hand, folder) -> None:
    apply(hand)
    hand.wait(lambda: bool(multiprocessing.active_children()))
    hand.key(Qt.Key.Key_Period, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: not multiprocessing.active_children())
    hand.wait(lambda: ready.session.tasks.idle)


def test_a_folder_without_an_image_is_reported(ready: MainWindow, hand: Hand, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path / "nowhere"))
    apply(hand)
    hand.wait(lambda: "contains no readable image" in ready.canvas_area.messages.text)
