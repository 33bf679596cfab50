"""An image begins with fresh parameters, and work done while it is being opened is not lost."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.modes import adapt_shapes_to_mode, initial_parameters
from cpm_app.model.preferences.table import KEEP_PARAMETERS
from cpm_app.session.tasks import opening
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.help import PreferencesFeature
from cpm_app.views.window import dialogs
from cpm_app.views.window.dialogs import UnsavedAnswer
from cpm_app.views.window.window import MainWindow
from PySide6.QtWidgets import QCheckBox, QWidget

from cpm_core import PRESETS, load_image
from tests.app.acting import draw_circle

pytestmark = pytest.mark.shared_window

FRESH = PRESETS["shape"]


@pytest.fixture(autouse=True)
def forgetful(window: MainWindow) -> Iterator[None]:
    """Let no test keep parameters for the next one."""
    yield
    window.preferences.store_preference(KEEP_PARAMETERS, False)
    window.session.keeps_parameters = False


@pytest.fixture
def other(tmp_path: Path) -> Path:
    path = tmp_path / "other.npy"
    np.save(path, 1000.0 + np.eye(64))
    return path


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Callable[[UnsavedAnswer], list[str]]:
    """Sets the answer to the question about unsaved work, and returns the names that are asked about."""

    def answering(answer: UnsavedAnswer) -> list[str]:
        names: list[str] = []

        def ask(_: QWidget, name: str, lost: Sequence[str]) -> UnsavedAnswer:
            assert lost
            names.append(name)
            return answer

        monkeypatch.setattr(dialogs, "ask_about_unsaved", ask)
        return names

    return answering


@pytest.fixture
def held(window: MainWindow, monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """The next images take until this event to be read."""
    ready = threading.Event()

    def load(path: Path, check_cancelled, **_):
        assert ready.wait(20.0)
        return load_image(path, check_cancelled=check_cancelled)

    monkeypatch.setattr(opening, "load_image", load)
    return ready


def tune(window: MainWindow, name: str = "beta", value: float = 1.9) -> None:
    window.session.edit("damping", lambda document: edits.set_parameter(document, name, value))


def open_image(window: MainWindow, hand, path: Path) -> None:
    before = window.session.image
    window.open_image(str(path))
    hand.wait(lambda: window.session.image is not before and window.session.idle)
    assert window.session.document.image.name == path.name


def test_a_new_image_begins_with_the_parameters_of_its_mode_not_with_those_of_the_last_one(window, hand, other) -> None:
    tune(window)
    open_image(window, hand, other)
    assert window.session.document.parameters == initial_parameters("shape") == FRESH


def test_parameters_are_kept_for_the_next_image_by_choice(window, hand, other) -> None:
    dialog = window.get_feature(PreferencesFeature).open_preferences()
    dialog.turn_to("run")
    box = dialog.rows[KEEP_PARAMETERS.label]
    assert isinstance(box, QCheckBox)
    assert not box.isChecked()
    box.click()
    dialog.reject()
    tune(window)
    open_image(window, hand, other)
    assert window.session.document.parameters == replace(FRESH, beta=1.9)
    assert not window.get_feature(OpenSaveFeature).document_file.unsaved


@pytest.mark.parametrize("keeps", [False, True])
def test_an_image_without_room_for_all_scales_limits_only_its_own(window, hand, tmp_path, other, keeps) -> None:
    small = tmp_path / "small.npy"
    np.save(small, np.eye(20))
    window.session.keeps_parameters = keeps
    open_image(window, hand, small)
    assert window.session.document.parameters.scales == 2
    assert "2" in window.canvas_area.messages.text
    open_image(window, hand, other)
    assert window.session.document.parameters == FRESH


# While an image is being opened


def test_a_mode_chosen_while_an_image_is_being_opened_is_that_of_the_image_with_its_preset(
    window, hand, other, held
) -> None:
    window.open_image(str(other))
    window.actions_by_name["mode_automatic"].trigger()
    held.set()
    hand.wait(lambda: window.session.document.image.name == "other.npy" and window.session.idle)
    document = window.session.document
    assert (document.mode, document.parameters) == ("automatic", initial_parameters("automatic"))
    assert document.starts == adapt_shapes_to_mode("automatic", ())
    window.session.run()
    hand.wait_for_phase("finished")


@pytest.mark.parametrize("answer", ["cancel", "discard"])
def test_work_done_while_an_image_is_being_opened_is_asked_about(window, hand, other, held, asked, answer) -> None:
    names = asked(answer)
    window.open_image(str(other))
    draw_circle(window)
    held.set()
    hand.wait(lambda: bool(names))
    if answer == "cancel":
        hand.wait(lambda: "other.npy" in window.canvas_area.messages.text)
        assert window.session.document.image.name == "disc.npy"
        assert len(window.session.document.shapes) == 1
    else:
        hand.wait(lambda: window.session.document.image.name == "other.npy")
    assert names == ["disc.cpm"]


def test_work_saved_at_the_question_is_in_its_file(window, hand, other, held, asked, tmp_path) -> None:
    asked("save")
    window.open_image(str(other))
    draw_circle(window)
    window.get_feature(OpenSaveFeature).document_file.path = tmp_path / "kept.cpm"
    held.set()
    hand.wait(lambda: window.session.document.image.name == "other.npy")
    assert (tmp_path / "kept.cpm").is_file()
