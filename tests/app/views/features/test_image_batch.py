"""The session applied to a folder of images gives the same as the command line, and stops when it is canceled."""

from __future__ import annotations

import multiprocessing
import shlex

import pytest
from cpm_app.views.export.batch_dialog import BatchDialog
from cpm_app.views.window.window import MainWindow
from PIL import Image as Picture
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from cpm_core import cli
from cpm_core.cli import workers
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


def ask(hand: Hand) -> BatchDialog:
    """The dialog on the chosen folder."""
    hand.window.activateWindow()
    hand.wait(hand.window.isActiveWindow)
    hand.key(Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier)
    dialog = hand.window.findChild(BatchDialog)
    assert dialog.isVisible()
    return dialog


def apply(hand: Hand) -> None:
    """Run the chosen folder in the formats that are checked."""
    dialog = ask(hand)
    hand.qtbot.keyClick(dialog, Qt.Key.Key_Return)
    hand.wait(lambda: not hand.window.findChildren(BatchDialog))


def check(dialog: BatchDialog, *names: str) -> None:
    """Check the formats of these names alone."""
    for row in dialog.list.rows.values():
        row.setCheckState(0, Qt.CheckState.Checked if row.text(0) in names else Qt.CheckState.Unchecked)


def test_a_folder_gets_the_objects_as_by_the_command_line_in_the_checked_formats(
    ready: MainWindow, hand: Hand, folder, tmp_path
) -> None:
    dialog = ask(hand)
    assert (dialog.suffixes, dialog.summary.text()) == ((".table.csv",), "No file will be replaced.")
    check(dialog)
    assert not dialog.run_button.isEnabled()
    check(dialog, "labelme", "Labels, TIFF", "CSV, one row per object")
    hand.qtbot.mouseClick(dialog.run_button, Qt.MouseButton.LeftButton)
    assert not ready.actions_by_name["apply_to_folder"].isEnabled()
    line = ready.canvas_area.messages
    hand.wait(lambda: line.text.startswith("1 of 2 images finished. Objects: 1, 0 of them doubtful, in "))
    assert line.text.endswith("Could not be used: broken.png.")
    assert ready.actions_by_name["apply_to_folder"].isEnabled()
    images = " ".join(shlex.quote(str(path)) for path in sorted(folder.glob("*.png")))
    command = f"batch {images} --session {folder}/objects/session.cpm --output {tmp_path}/images/again --workers 1"
    assert cli.main([*shlex.split(command), "--export", "labelme", "masks", "csv"]) == 1
    names = {"disc.json", "disc_objects.tif", "disc_objects.csv", "objects.csv"}
    for name in names:
        assert (folder / "again" / name).read_bytes() == (folder / "objects" / name).read_bytes()
    assert {path.name for path in (folder / "objects").iterdir()} == {"session.cpm", "summary.csv", *names}
    dialog = ask(hand)
    assert dialog.suffixes == (".labelme.json", ".tif", ".table.csv")
    assert dialog.summary.text().startswith("Files that will be replaced: 3, except")
    dialog.reject()


def test_the_end_of_a_folder_stays_to_be_read(ready: MainWindow, hand: Hand, folder, monkeypatch) -> None:
    monkeypatch.setattr(workers, "run_locally", lambda jobs, *_: ((job, workers.run_job(job)) for job in jobs))
    (folder / "broken.png").unlink()
    apply(hand)
    line = ready.canvas_area.messages
    hand.wait(lambda: line.text.startswith("1 of 1 images finished. Objects: 1, 0 of them doubtful, in "))
    assert not line.is_error
    assert not line._timer.isActive()


def test_it_stops_when_it_is_canceled_and_leaves_no_process(ready: MainWindow, hand: Hand, folder) -> None:
    apply(hand)
    hand.wait(lambda: bool(multiprocessing.active_children()))
    hand.key(Qt.Key.Key_Period, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: not multiprocessing.active_children())
    hand.wait(lambda: ready.session.tasks.idle)


def test_a_folder_without_an_image_is_not_run(ready: MainWindow, hand: Hand, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path / "nowhere"))
    dialog = ask(hand)
    assert "contains no readable image" in dialog.summary.text()
    assert not dialog.run_button.isEnabled()
    dialog.reject()
