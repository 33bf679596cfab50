"""A larger model that is chosen in the preferences answers clicks as soon as it is on this computer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.preferences.table import MODEL_FOLDER, MODEL_PREFERENCE, OWN_MODEL
from cpm_app.session.storage.session_file import DocumentFile
from cpm_app.views.features.help import PreferencesFeature
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

import cpm_core as cpm
from cpm_core.formats.sessions.session_file import load_session

osam = pytest.importorskip("osam")
onnx_models = pytest.importorskip("tests.core.objects.onnx_models")

KEY = Qt.Key


@pytest.fixture
def image_file(tmp_path) -> Path:
    """A disk that the border cuts, so that no contour closes around it, and of which the model takes a few levels."""
    path = tmp_path / "disk.npy"
    rows, cols = np.indices((64, 64))
    np.save(path, np.where(np.hypot(rows - 32, cols) < 18, 50.0 + 5.0 * rows, 20.0))
    return path


def choose(hand, name: str, folder: str = "") -> None:
    """Choose a model in the dialog."""
    dialog = hand.window.get_feature(PreferencesFeature).open_preferences()
    dialog.turn_to("objects")
    if folder:
        field = dialog.rows[MODEL_FOLDER.label]
        field.setFocus()
        hand.qtbot.keyClicks(field, folder)
        hand.qtbot.keyClick(field, KEY.Key_Return)
    box = dialog.rows[MODEL_PREFERENCE.label]
    box.setFocus()
    for _ in range(box.findData(name) - box.currentIndex()):
        hand.qtbot.keyClick(box, KEY.Key_Down)
    dialog.reject()


def accept_object_at(hand, row: float, col: float) -> None:
    selection = hand.window.workspace.object_selection
    hand.window.activateWindow()
    hand.wait(hand.window.isActiveWindow)
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: selection.ready and selection.idle)
    hand.click(row, col)
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    hand.key(KEY.Key_Return)
    hand.wait(lambda: bool(hand.window.session.document.objects.items))


def test_files_of_ones_own_answer_and_the_session_names_them(window, hand, tmp_path) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    choose(hand, OWN_MODEL, onnx_models.write_model(folder, "efficientsam"))
    updater = window.workspace.object_selection.partition_updater
    hand.wait(lambda: updater._models[2] == str(folder))
    accept_object_at(hand, 32, 8)
    assert DocumentFile(window.session, dict).save_and_wait(tmp_path / "disk.cpm")
    (item,) = load_session(tmp_path / "disk.cpm").objects.items
    assert item.model == "mine"


@pytest.mark.parametrize("action", ["copy_python", "copy_command"])
def test_what_is_copied_does_not_say_that_clicks_without_the_model_give_its_objects(
    window, hand, tmp_path, action
) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    choose(hand, OWN_MODEL, onnx_models.write_model(folder, "efficientsam"))
    updater, messages = window.workspace.object_selection.partition_updater, window.canvas_area.messages
    hand.wait(lambda: updater._models[2] == str(folder))
    accept_object_at(hand, 32, 8)
    hand.wait(lambda: window.session.idle and not updater.preparing)
    clipboard = QApplication.clipboard()
    clipboard.clear()
    window.actions_by_name[action].trigger()
    hand.wait(lambda: bool(clipboard.text()) or messages.text.startswith("Save the session first"))
    assert not clipboard.text()
    file = tmp_path / "disk.cpm"
    assert window.document_file.save_and_wait(file)
    window.actions_by_name[action].trigger()
    hand.wait(lambda: bool(clipboard.text()))
    assert str(file) in clipboard.text()


def test_a_model_is_fetched_after_its_offer_is_taken(window, hand, tmp_path, monkeypatch) -> None:
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(tmp_path / "home"))
    kind, fetched = osam.apis.get_model_type_by_name("sam2:tiny"), []

    def pull(kind, progress, cancel) -> None:
        progress("encoder", 150_000_000, None)
        for blob in kind._blobs.values():
            Path(blob.path).parent.mkdir(parents=True, exist_ok=True)
            Path(blob.path).touch()
        fetched.append(kind.name)

    monkeypatch.setattr(kind, "pull", classmethod(pull))
    choose(hand, "sam2:tiny")
    hand.wait(lambda: bool(window.offers.text))
    assert cpm.MODELS["sam2:tiny"].summary in window.offers.text and not fetched
    updater = window.workspace.object_selection.partition_updater
    hand.qtbot.mouseClick(window.offers.buttons[0], Qt.MouseButton.LeftButton)
    hand.wait(lambda: bool(fetched) and updater._models[2] == "sam2:tiny")
