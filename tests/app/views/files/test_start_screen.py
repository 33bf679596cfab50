"""The start screen shows recent work as pictures, and is walked by keys."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.samples import load_samples
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.storage.thumbnails import THUMBNAIL_SIZE
from cpm_app.views.application import make_application
from cpm_app.views.features.files import OpenSaveFeature, StartFeature
from cpm_app.views.files.start_screen import StartScreen
from cpm_app.views.main_window import make_window
from cpm_app.views.window import dialogs
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QFileDialog
from pytestqt.qtbot import QtBot

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.image.region import Region
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects
from cpm_core.shapes import Circle
from tests.app.acting import open_image

pytestmark = pytest.mark.usefixtures("pictures_taken")

KEY, ALT = Qt.Key, Qt.KeyboardModifier.AltModifier


def screen(window: MainWindow) -> StartScreen:
    return window.get_feature(StartFeature).screen


def names(window: MainWindow) -> list[str]:
    grid = screen(window).recent
    return [grid.item(row).text().partition("\n")[0] for row in range(grid.count())]


@pytest.fixture
def other(tmp_path: Path) -> Path:
    path = tmp_path / "other.npy"
    np.save(path, np.eye(64))
    return path


def test_recent_work_is_opened_by_keys_alone(window, hand, other) -> None:
    open_image(window, hand, other)
    hand.key(KEY.Key_Home, ALT)
    assert screen(window).isVisible()
    assert names(window) == ["other.npy", "disc.npy"]
    assert screen(window).recent.hasFocus()
    hand.key(KEY.Key_Right)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: window.session.document.image.name == "disc.npy")
    assert not screen(window).isVisible()
    assert window.session.status.phase == "ready"
    assert hand.canvas.hasFocus()


def test_a_sample_is_opened_by_a_click(window, hand) -> None:
    hand.key(KEY.Key_Home, ALT)
    grid = screen(window).samples
    place = grid.visualItemRect(grid.item(0)).center()
    hand.qtbot.mouseClick(grid.viewport(), Qt.MouseButton.LeftButton, pos=place)
    hand.wait(lambda: window.session.document.image.name == load_samples()[0].path.name)
    hand.wait(lambda: window.session.idle)


def test_what_was_open_has_a_picture_and_one_that_is_gone_is_not_shown(window, hand, other, image_file) -> None:
    open_image(window, hand, other)
    pictures = window.get_feature(StartFeature).pictures
    assert pictures.load_thumbnail(image_file).size() == THUMBNAIL_SIZE
    assert pictures.load_thumbnail(other).isNull()
    image_file.unlink()
    hand.key(KEY.Key_Home, ALT)
    assert names(window) == ["other.npy"]


def test_a_saved_session_has_a_picture_at_once(ready, hand, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "work.cpm"), ""))
    hand.key(KEY.Key_S, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: not ready.get_feature(OpenSaveFeature).document_file.unsaved)
    assert not ready.get_feature(StartFeature).pictures.load_thumbnail(tmp_path / "work.cpm").isNull()


def test_a_session_saved_when_asked_is_recent_work_and_has_a_picture(
    ready, hand, other, image_file, tmp_path, monkeypatch
) -> None:
    monkeypatch.setattr(dialogs, "ask_about_unsaved", lambda *_: "save")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "work.cpm"), ""))
    ready.open_image(str(other))
    hand.wait(lambda: ready.session.document.image.name == other.name and ready.session.idle)
    hand.key(KEY.Key_Home, ALT)
    assert names(ready)[:2] == ["other.npy", "work.cpm"]
    pictures = ready.get_feature(StartFeature).pictures
    assert not pictures.load_thumbnail(tmp_path / "work.cpm").isNull()
    assert not pictures.load_thumbnail(image_file).isNull()


def test_where_nothing_can_be_opened_the_start_screen_is_shown(qtbot: QtBot, workspace: Workspace, tmp_path) -> None:
    make_application()
    window = make_window(workspace)
    window.show()
    window.open_image(str(tmp_path / "gone.png"))
    qtbot.waitUntil(lambda: screen(window).isVisible(), timeout=20_000)
    assert not screen(window).back_button.isVisible()
    assert screen(window).error_label.text().startswith("gone.png in ")
    qtbot.keyClick(screen(window).samples, KEY.Key_Escape)
    assert screen(window).isVisible()
    window.close()
    window.deleteLater()


def test_a_session_with_objects_opens_with_the_tool_that_goes_on_with_them(
    qtbot: QtBot, workspace: Workspace, image_file
) -> None:
    whole = SegmentedObject(1, (), Region(((((20.0, 20.0), (20.0, 40.0), (40.0, 40.0))),)))
    session = SessionFile(ImageFile(image_file.name), objects=SegmentedObjects((whole,)))
    save_session(session, image_file.with_suffix(".cpm"))
    make_application()
    window = make_window(workspace)
    window.show()
    window.open_image(str(image_file.with_suffix(".cpm")))
    qtbot.waitUntil(window.actions_by_name["objects"].isChecked, timeout=20_000)
    assert window.canvas_area.canvas.dispatcher.tool.name == "objects"
    window.close()
    window.deleteLater()


def test_a_file_that_cannot_be_opened_is_not_mistaken_for_the_sample_that_is_open(window, hand, tmp_path) -> None:
    open_image(window, hand, load_samples()[0].path)
    broken = tmp_path / "broken.nii"
    broken.write_bytes(b"no image")
    drop(window, broken)
    hand.wait(lambda: screen(window).isVisible())
    assert screen(window).error_label.text().startswith("broken.nii ")
    hand.qtbot.mouseClick(screen(window).back_button, Qt.MouseButton.LeftButton)
    window.session.edit("draw", lambda document: edits.add_shape(document, Circle((40.0, 40.0), 5.0)))
    drop(window, broken)
    hand.wait(lambda: "broken.nii" in window.canvas_area.messages.text)
    assert not screen(window).isVisible(), "work stays in sight"


def drop(window: MainWindow, path: Path) -> None:
    """Drop a file on the window."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    place, both = QPointF(50.0, 50.0), Qt.MouseButton.LeftButton
    window.dropEvent(QDropEvent(place, Qt.DropAction.CopyAction, data, both, Qt.KeyboardModifier.NoModifier))


@pytest.mark.parametrize("sample", [load_samples()[0], load_samples()[-1]], ids=lambda sample: sample.path.name)
def test_a_copy_of_a_sample_starts_as_the_sample_does(window, hand, tmp_path, sample) -> None:
    copy = Path(shutil.copy(sample.path, tmp_path))
    open_image(window, hand, copy)
    document = window.session.document
    assert (document.shapes, document.mode) == (sample.shapes, sample.mode)
    assert document.parameters.scales <= sample.parameters.scales
    assert replace(document.parameters, scales=sample.parameters.scales) == sample.parameters
    assert window.get_feature(OpenSaveFeature).recent.paths[0] == copy, "it is a file of the user"


def test_a_start_with_a_sample_offers_the_newest_work(window, hand, other, image_file) -> None:
    bar = window.offers
    window.get_feature(StartFeature).offer_recent_work()
    open_image(window, hand, load_samples()[0].path)
    assert "disc.npy" in bar.text
    hand.qtbot.mouseClick(bar.buttons[1], Qt.MouseButton.LeftButton)
    assert screen(window).isVisible()
    open_image(window, hand, other)
    assert not bar.text
