"""The images of a folder are opened one after another, in the order in which people count, with their sessions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.preferences.table import SAVE_IN_FOLDER
from cpm_app.session.tasks.opening import find_adjacent_session, sibling_images
from cpm_app.views.features.files import FolderFeature, OpenSaveFeature
from cpm_app.views.window.window import MainWindow
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from cpm_core.formats import natural_sort_key
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, load_session, save_session
from cpm_core.shapes import Circle
from tests.app.acting import draw_circle, open_image
from tests.app.reading import image_name

pytestmark = pytest.mark.shared_window

ALT = Qt.KeyboardModifier.AltModifier
NEXT, BACK = (Qt.Key.Key_Right, ALT), (Qt.Key.Key_Left, ALT)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three images, a session of the second one, and other things."""
    path = tmp_path / "hands"
    path.mkdir()
    for name in ("hand2.npy", "Hand10.npy", "hand1.npy", ".hidden.npy"):
        np.save(path / name, np.eye(64))
    (path / "notes.txt").write_text("-")
    (path / "hand3.npy").mkdir()
    session = SessionFile(ImageFile(str(path / "hand2.npy")), shapes=(Circle((20.0, 20.0), 5.0),))
    save_session(session, path / "hand2.cpm")
    return path


def place(window: MainWindow) -> str:
    bar = window.get_feature(FolderFeature).bar
    return "" if bar.isHidden() else bar._place.text()


def go(window: MainWindow, hand, key, expected: str) -> None:
    hand.key(*key)
    hand.wait(lambda: image_name(window) == expected and window.session.idle)


def test_what_has_been_exported_of_an_image_is_no_next_image(folder: Path) -> None:
    for exported in ("hand1_objects.npy", "hand1_contours.figure.png", "hand1_other.npy", "arm_objects.npy"):
        np.save(folder / "x.npy", np.eye(64))
        (folder / "x.npy").rename(folder / exported)
    names = [path.name for path in sibling_images(folder / "hand1.npy")]
    assert names == ["arm_objects.npy", "hand1.npy", "hand1_other.npy", "hand2.npy", "Hand10.npy"]


def test_images_are_in_the_order_in_which_people_count(folder: Path) -> None:
    names = [path.name for path in sibling_images(folder / "hand2.npy")]
    assert names == ["hand1.npy", "hand2.npy", "Hand10.npy"]


@given(st.lists(st.text()))
def test_any_names_can_be_put_in_order(names: list[str]) -> None:
    ordered = sorted(names, key=natural_sort_key)
    names.reverse()
    assert sorted(names, key=natural_sort_key) == ordered


def test_only_a_session_that_names_the_image_belongs_to_it(folder: Path) -> None:
    assert find_adjacent_session(folder / "hand2.npy") == folder / "hand2.cpm"
    assert find_adjacent_session(folder / "hand1.npy") is None
    save_session(load_session(folder / "hand2.cpm"), folder / "hand1.cpm")
    assert find_adjacent_session(folder / "hand1.npy") is None
    (folder / "hand1.cpm").write_text("{")
    assert find_adjacent_session(folder / "hand1.npy") is None


def test_keys_lead_through_the_folder_and_the_place_is_shown(window, hand, folder) -> None:
    assert not place(window)
    open_image(window, hand, folder / "hand1.npy")
    assert place(window) == "File 1 of 3"
    assert not window.actions_by_name["previous_image"].isEnabled()
    go(window, hand, NEXT, "hand2.npy")
    assert place(window) == "File 2 of 3"
    assert len(window.session.document.shapes) == 1
    assert window.get_feature(OpenSaveFeature).document_file.path == folder / "hand2.cpm"
    go(window, hand, NEXT, "Hand10.npy")
    assert window.session.document.shapes == ()
    assert not window.actions_by_name["next_image"].isEnabled()
    go(window, hand, BACK, "hand2.npy")


def test_a_click_leads_to_the_next_image_and_one_that_has_gone_is_passed_over(window, hand, folder) -> None:
    open_image(window, hand, folder / "hand1.npy")
    (folder / "hand2.npy").unlink()
    hand.qtbot.mouseClick(window.get_feature(FolderFeature).bar.forward, Qt.MouseButton.LeftButton)
    hand.wait(lambda: image_name(window) == "Hand10.npy" and window.session.idle)
    assert place(window) == "File 2 of 2"


def test_work_is_saved_on_the_way_by_choice(window, hand, folder) -> None:
    window.preferences.store_preference(SAVE_IN_FOLDER, True)
    open_image(window, hand, folder / "hand1.npy")
    draw_circle(window)
    go(window, hand, NEXT, "hand2.npy")
    assert load_session(folder / "hand1.cpm").shapes == (Circle((20.0, 30.0), 9.0),)
    go(window, hand, BACK, "hand1.npy")
    assert len(window.session.document.shapes) == 1


def test_saving_on_the_way_never_replaces_the_file_of_other_work(window, hand, folder, monkeypatch) -> None:
    window.preferences.store_preference(SAVE_IN_FOLDER, True)
    open_image(window, hand, folder / "hand2.npy")  # not its session
    draw_circle(window)
    draw_circle(window)
    go(window, hand, BACK, "hand1.npy")
    assert load_session(folder / "hand2.cpm").shapes == (Circle((20.0, 20.0), 5.0),)


def test_where_saving_fails_the_image_stays(window, hand, folder, monkeypatch) -> None:
    window.preferences.store_preference(SAVE_IN_FOLDER, True)
    open_image(window, hand, folder / "hand1.npy")
    window.get_feature(OpenSaveFeature).document_file.path = folder / "none" / "a.cpm"
    draw_circle(window)
    hand.key(*NEXT)
    hand.wait(lambda: "none" in window.canvas_area.messages.text)
    assert image_name(window) == "hand1.npy"


def test_the_buttons_of_the_folder_stay_where_they_are_while_the_pointer_is_over_the_image(
    window, hand, folder
) -> None:
    open_image(window, hand, folder / "hand1.npy")
    forward, places = window.get_feature(FolderFeature).bar.forward, set()
    for at in ((10.0, 10.0), None):
        window.pointer_readout._on_place_changed(at)
        hand.qtbot.wait(20)
        assert bool(window.pointer_readout.text()) == (at is not None)
        places.add(forward.mapTo(window, forward.rect().center()).toTuple())
    assert len(places) == 1
