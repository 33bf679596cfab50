"""The session applied to a folder of images: the same as by the command line, told as it goes, stopped at once."""

from __future__ import annotations

import multiprocessing
import shlex
import threading

import pytest
from PIL import Image as Picture
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QListWidgetItem

from app.views.export.batch.dialog import BatchDialog
from app.views.features.exchange import BatchFeature
from app.views.main_window import MainWindow
from cpm_core import cli
from cpm_core.cli import workers
from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def folder(tmp_path):
    """Two images and one that is damaged."""
    place = tmp_path / "images"
    place.mkdir()
    for number in (2, 10):
        Picture.fromarray(disc().astype("uint8")).save(place / f"disc{number}.png")
    (place / "disc1.png").write_bytes(b"\x89PNG\r\n\x1a\n broken")
    (place / "notes.txt").write_text("no image")
    return place


@pytest.fixture
def dialog(ready: MainWindow, hand: Hand, folder) -> BatchDialog:
    """The dialog, opened by its key on the folder."""
    hand.key(Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier)
    made = ready.feature(BatchFeature).dialog.shown
    assert made is not None
    hand.qtbot.waitExposed(made)
    made.folder.clear()
    hand.qtbot.keyClicks(made.folder, str(folder))
    made.output.clear()
    hand.qtbot.keyClicks(made.output, str(folder / "found"))
    hand.wait(lambda: made.told.text() == "3 images are ready.")
    return made


def test_a_batch_says_that_loops_are_compiled_until_the_first_image_is_done(ready, hand, dialog, monkeypatch) -> None:
    monkeypatch.setattr("app.session.features.image_batch.is_compiled", lambda: False)
    go_on, whole = threading.Event(), workers.here
    monkeypatch.setattr(workers, "here", lambda *given: go_on.wait(30) and whole(*given))
    batch = ready.workspace.batch
    hand.qtbot.mouseClick(dialog.button, LEFT)
    try:
        hand.wait(lambda: "The inner loops are compiled for this computer" in dialog.told.text())
    finally:
        go_on.set()
    hand.wait(lambda: not batch.running)
    hand.wait(lambda: dialog.told.text().startswith("2 of 3 images are done. 1 could not be used."))


def test_a_folder_is_run_as_by_the_command_line_also_while_the_dialog_is_closed(
    ready: MainWindow, hand: Hand, dialog, folder, tmp_path
) -> None:
    batch = ready.workspace.batch
    assert dialog.table.column("image") == ["disc1.png", "disc2.png", "disc10.png"]
    hand.qtbot.mouseClick(dialog.button, LEFT)
    assert batch.running
    assert not dialog.folder.isEnabled()
    dialog.close()
    assert batch.running
    feature = ready.feature(BatchFeature)
    hand.wait(lambda: feature.dialog.shown is None)
    feature.dialog.open()
    assert feature.dialog.shown is not None
    dialog = feature.dialog.shown
    assert dialog.button.text() == "&Stop"
    hand.wait(lambda: not batch.running)
    hand.wait(lambda: dialog.button.text() == "&Start")
    assert dialog.table.column("state") == ["failed", "done", "done"]
    assert dialog.table.column("contours") == ["–", "1", "1"]
    assert "damaged" in dialog.table.column("remarks")[0]
    assert dialog.told.text().startswith("2 of 3 images are done. 1 could not be used.")
    hand.wait(lambda: "2 of 3 images are done" in ready.canvas_area.messages.text)

    images = " ".join(shlex.quote(str(path)) for path in sorted(folder.glob("*.png")))
    command = f"batch {images} --session {folder}/found/session.cpm --output {tmp_path}/again"
    assert cli.main([*shlex.split(command), "--export", *dialog.suffixes, "--workers", "1"]) == 1
    for file in (tmp_path / "again").iterdir():
        if file.name != "summary.csv":
            assert file.read_bytes() == (folder / "found" / file.name).read_bytes()
    assert len(list((folder / "found").iterdir())) == 2 * len(dialog.suffixes) + 2


def test_it_stops_at_once_and_leaves_no_process(ready: MainWindow, hand: Hand, dialog, folder) -> None:
    batch = ready.workspace.batch
    hand.qtbot.mouseClick(dialog.button, LEFT)
    hand.wait(lambda: bool(multiprocessing.active_children()))
    hand.qtbot.mouseClick(dialog.button, LEFT)
    assert not batch.running
    hand.wait(lambda: not multiprocessing.active_children())
    hand.wait(lambda: ready.session.tasks.idle)
    hand.wait(lambda: dialog.button.text() == "&Start")


def test_without_a_format_or_an_image_it_says_what_is_missing(hand: Hand, dialog, tmp_path) -> None:
    for row in range(dialog.formats.count()):
        item: QListWidgetItem = dialog.formats.item(row)
        item.setCheckState(Qt.CheckState.Unchecked)
    hand.wait(lambda: dialog.told.text() == "No format is chosen: choose one.")
    assert not dialog.button.isEnabled()
    dialog.use_folder(tmp_path / "nothing")
    hand.wait(lambda: dialog.told.text().startswith("There is no image in this folder"))
