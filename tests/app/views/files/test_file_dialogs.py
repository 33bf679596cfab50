"""File dialogs begin beside the image, name kinds of files instead of listing suffixes, and replace nothing unasked."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.samples import load_samples
from cpm_app.session.storage.folders import initial_folder, remember_folder
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.features.compare import CompareFeature
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.window import dialogs
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

pytestmark = pytest.mark.shared_window

CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
ROOT = Path(__file__).parents[4]


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> dict[str, tuple[object, ...]]:
    """What the last dialog of each title was asked for; each is cancelled."""
    asked: dict[str, tuple[object, ...]] = {}

    def ask(_: object, title: str, *rest: object) -> tuple[str, str]:
        asked[title] = rest
        return "", ""

    monkeypatch.setattr(QFileDialog, "getOpenFileName", ask)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", ask)
    return asked


def of_image(path: Path) -> Document:
    return Document(ImageReference(path.name, str(path), (9, 9), 1.0))


ASKS: dict[str, Callable[[MainWindow], object]] = {
    "Open": lambda window: window.get_feature(OpenSaveFeature).ask_for_document(),
    "Save session": lambda window: window.get_feature(OpenSaveFeature).save_as(),
    "Compare with ground truth": lambda window: window.get_feature(CompareFeature)._ask_for_truth(),
}


def test_every_dialog_begins_beside_the_image_and_lists_no_suffixes(window, seen, image_file, cases) -> None:
    for title in cases(ASKS):
        ASKS[title](window)
        begin, filters, _, options = seen[title]
        assert Path(begin) == image_file.parent or Path(begin).parent == image_file.parent
        assert options & QFileDialog.Option.HideNameFilterDetails
        assert len(filters.split(";;")) >= 1


def test_images_and_sessions_are_offered_together_and_apart(window, hand, seen) -> None:
    hand.key(Qt.Key.Key_O, CTRL)
    names = [kind.partition(" (")[0] for kind in seen["Open"][1].split(";;")]
    assert names == ["Images and sessions", "Images", "Sessions", "All files"]


def test_a_folder_chosen_for_an_image_holds_for_this_image_and_this_kind_of_file(qapp, tmp_path) -> None:
    preferences, mine, other = Preferences(), of_image(tmp_path / "a.png"), of_image(tmp_path / "b.png")
    (tmp_path / "out").mkdir()
    remember_folder(preferences, mine, "export", tmp_path / "out" / "a.svg")
    assert initial_folder(preferences, mine, "export") == tmp_path / "out"
    assert initial_folder(preferences, mine, "session") == tmp_path
    assert initial_folder(preferences, other, "export") == tmp_path


def test_without_an_image_of_the_user_a_dialog_begins_where_the_last_one_ended(qapp, tmp_path) -> None:
    preferences, sample = Preferences(), of_image(load_samples()[0].path)
    assert initial_folder(preferences, sample, "export") == Path.home()
    remember_folder(preferences, of_image(tmp_path / "a.png"), "export", tmp_path / "a.svg")
    assert (
        initial_folder(preferences, sample, "export") == initial_folder(preferences, Document(), "export") == tmp_path
    )
    assert initial_folder(preferences, sample, "open") == Path.home()
    remember_folder(preferences, Document(), "export", tmp_path / "gone" / "a.svg")
    assert initial_folder(preferences, Document(), "export") == Path.home()


@pytest.mark.parametrize("agreed", [False, True])
def test_a_file_that_gets_its_suffix_from_the_program_is_not_replaced_unasked(
    ready, hand, monkeypatch, tmp_path, agreed
) -> None:
    (tmp_path / "work.cpm").write_text("other work")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "work"), ""))
    monkeypatch.setattr(dialogs, "ask_to_replace", lambda parent, name: agreed and name == "work.cpm")
    hand.key(Qt.Key.Key_S, CTRL | SHIFT)
    hand.wait(lambda: ready.session.idle)
    assert ((tmp_path / "work.cpm").read_text() != "other work") == agreed


def test_only_one_module_asks_for_files() -> None:
    asking = [path for path in (ROOT / "app").rglob("*.py") if "QFileDialog" in path.read_text(encoding="utf-8")]
    assert [path.name for path in asking] == ["dialogs.py"]
