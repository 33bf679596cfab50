"""Bad input leads to one clear sentence in one place, and the program goes on with what it had."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Picture
from PySide6.QtCore import QMimeData, QPoint, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QToolButton

from app.model.document import edits
from cpm_core.shapes import Circle

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
    path = folder / "holes.npy"
    values = np.eye(32)
    values[3, 4] = np.nan
    np.save(path, values)
    return path


def missing(folder: Path) -> Path:
    return folder / "nowhere.png"


def folder_itself(folder: Path) -> Path:
    return folder


def test_an_unusable_file_is_reported_in_one_sentence_and_the_image_stays(ready, hand, tmp_path, cases) -> None:
    for make in cases([no_image, one_pixel, constant, not_a_number, missing, folder_itself]):
        document, step = ready.session.document, ready.session.status.step
        ready.session.open(make(tmp_path))
        hand.wait(lambda: bool(ready.canvas_area.messages.text))
        hand.wait(lambda: ready.session.idle)
        said = ready.canvas_area.messages.text
        assert said.endswith(".")
        assert "\n" not in said
        assert "Something unexpected" not in said
        assert "Traceback" not in said
        assert ready.session.document == document
        hand.key(KEY.Key_Escape)
        assert ready.canvas_area.messages.text == ""
        hand.key(KEY.Key_Period)
        hand.wait(lambda step=step: ready.session.status.step == step + 1)


def test_a_file_without_permission_is_reported_and_the_image_stays(ready, hand, tmp_path, monkeypatch) -> None:
    # The tests may run with all permissions, so the error is raised where the file is opened.
    path, document, whole = constant(tmp_path), ready.session.document, Path.open

    def refuse(file: Path, *arguments: object, **named: object) -> object:
        if file == path:
            raise PermissionError(13, "Permission denied")
        return whole(file, *arguments, **named)  # type: ignore[call-overload]

    monkeypatch.setattr(Path, "open", refuse)
    ready.session.open(path)
    hand.wait(lambda: bool(ready.canvas_area.messages.text))
    assert "permission" in ready.canvas_area.messages.text
    assert ready.session.document == document


def test_a_run_goes_on_while_another_file_turns_out_to_be_unusable(ready, hand, tmp_path) -> None:
    ready.session.set_pace(30.0)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: ready.session.status.step >= 1)
    ready.session.open(no_image(tmp_path))
    hand.wait(lambda: bool(ready.canvas_area.messages.text))
    step = ready.session.status.step
    hand.wait(lambda: ready.session.status.step > step or ready.session.status.phase == "finished")


def test_run_without_shapes_explains_what_to_do(window, hand) -> None:
    hand.key(KEY.Key_Space)
    assert "draw a circle" in window.canvas_area.messages.text
    assert window.session.status.phase == "ready"


def test_a_circle_outside_the_image_is_reported_and_can_be_corrected(window, hand) -> None:
    window.session.edit("draw", lambda document: edits.add_shape(document, Circle((-50.0, -50.0), 5.0)))
    hand.key(KEY.Key_Space)
    hand.wait(lambda: bool(window.canvas_area.messages.text))
    assert "inside" in window.canvas_area.messages.text
    assert window.session.status.phase == "ready"
    window.session.edit("move", lambda document: edits.move_shape(document, 0, (80.0, 80.0)))
    hand.key(KEY.Key_Space)
    hand.wait(lambda: window.session.status.step > 0)


def test_a_refused_parameter_is_reported_and_the_old_value_is_shown_again(window) -> None:
    window.panels["parameters"].rows["scales"].changed.emit("scales", 0)
    assert "scales" in window.canvas_area.messages.text.lower()
    assert window.panels["parameters"].rows["scales"].number.value() == window.session.document.parameters.scales


def test_too_many_scales_for_the_image_are_reported_at_the_start(ready, hand) -> None:
    ready.session.edit("scales", lambda document: edits.set_parameter(document, "scales", 8))
    hand.key(KEY.Key_Space)
    hand.wait(lambda: bool(ready.canvas_area.messages.text))
    assert ready.canvas_area.messages.text.startswith("Scales is 8 but must be from 1 to")
    assert ready.session.status.phase == "ready"


def test_a_small_image_opens_with_fewer_scales_and_a_message(window, hand, tmp_path) -> None:
    np.save(tmp_path / "small.npy", np.eye(16))
    window.session.open(tmp_path / "small.npy")
    hand.wait(lambda: window.session.document.image.name == "small.npy")
    assert window.session.document.parameters.scales < 3
    assert "scales" in window.canvas_area.messages.text
    window.session.edit("draw", lambda document: edits.add_shape(document, Circle((8.0, 8.0), 4.0)))
    hand.key(KEY.Key_Period)
    hand.wait(lambda: window.session.status.step == 1)


def test_news_is_shown_over_trouble_which_stays_until_dismissed(window) -> None:
    window.session.say("Something is wrong.", True)
    window.session.say("By the way.", False)
    messages = window.canvas_area.messages
    assert messages.text == "By the way."
    dismiss = next(button for button in messages.findChildren(QToolButton) if "Dismiss" in button.accessibleName())
    dismiss.click()
    assert messages.text == "Something is wrong."
    dismiss.click()
    assert messages.text == ""


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
