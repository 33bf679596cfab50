"""A folder of images is a project: done one after another, saved on the way, measured in one table."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits, objects
from cpm_app.model.document.modes import switch_mode
from cpm_app.session.features import image_project
from cpm_app.views.features.files import FolderFeature, OpenSaveFeature
from cpm_app.views.features.project import ProjectFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent

from cpm_core.formats import PROJECT_FOLDER, ProjectImage, Reading, load_project, load_session, project_session
from cpm_core.image.region import Region
from cpm_core.objects.segmented import SegmentedObject
from cpm_core.shapes import Circle, Everywhere
from tests.app.conftest import disc
from tests.app.reading import column_texts, image_name

pytestmark = pytest.mark.shared_window

CONTROL, ALT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier
DONE, DOUBTFUL, NEXT = (Qt.Key.Key_Return, CONTROL), (Qt.Key.Key_Return, ALT), (Qt.Key.Key_Down, ALT)
SQUARE = ((10.0, 10.0), (10.0, 20.0), (20.0, 20.0), (20.0, 10.0))


@pytest.fixture(autouse=True)
def saved_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(image_project, "_SAVE_DELAY", 10)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Twelve images, the mask of one, and other things."""
    path = tmp_path / "plates"
    path.mkdir()
    for number in range(1, 13):
        np.save(path / f"plate{number}.npy", disc(10.0 + number % 3))
    np.save(path / "plate1_mask.npy", disc())
    (path / "notes.txt").write_text("-")
    return path


def table(window: MainWindow) -> list[tuple[str, str, str]]:
    shown = window.get_feature(ProjectFeature).panel.table
    return list(zip(*(column_texts(shown, column) for column in ("image", "state", "objects")), strict=True))


def wait_for(window: MainWindow, hand, expected: str) -> None:
    hand.wait(lambda: image_name(window) == expected and window.session.idle and not window.session.opening_name)


def open_project(window: MainWindow, hand, folder: Path, first: str = "plate1.npy") -> None:
    window.open_image(folder)
    wait_for(window, hand, first)


def press(window: MainWindow, hand, key, expected: str) -> None:
    hand.key(*key)
    wait_for(window, hand, expected)


def add_object(window: MainWindow, confidence: float = 0.5) -> None:
    number = window.session.document.objects.next_number
    new = SegmentedObject(number, (), Region((SQUARE,)), confidence=confidence)
    window.session.edit("add object", lambda document: objects.accept_objects(document, (new,)))


def test_the_images_of_a_folder_are_listed_without_masks_in_the_order_in_which_people_count(window, hand, folder):
    open_project(window, hand, folder)
    assert [image for image, _, _ in table(window)] == [f"plate{number}.npy" for number in range(1, 13)]
    assert {(state, count) for _, state, count in table(window)} == {("○ untouched", "0")}
    assert window.docks.tabs.currentWidget() is window.panels["images"]
    assert window.get_feature(FolderFeature).bar._place.text() == "File 1 of 12"
    assert not (folder / PROJECT_FOLDER).exists()  # nothing is written by looking


def test_a_dropped_folder_is_opened(window, hand, folder) -> None:
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(folder))])
    none = Qt.KeyboardModifier.NoModifier
    window.dropEvent(QDropEvent(QPointF(5, 5), Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton, none))
    wait_for(window, hand, "plate1.npy")
    assert window.workspace.project.folder == folder.resolve()


def test_keys_mark_images_and_lead_to_the_next_undone_one_round_the_folder(window, hand, folder) -> None:
    open_project(window, hand, folder)
    press(window, hand, DONE, "plate2.npy")
    press(window, hand, DOUBTFUL, "plate3.npy")
    hand.key(Qt.Key.Key_Left, ALT)
    wait_for(window, hand, "plate2.npy")
    press(window, hand, NEXT, "plate3.npy")
    window.open_image(folder / "plate12.npy")
    wait_for(window, hand, "plate12.npy")
    press(window, hand, DONE, "plate3.npy")
    assert [state for _, state, _ in table(window)][:3] == ["● done", "? doubtful", "○ untouched"]
    known = load_project(folder).images
    assert {image: found.state for image, found in known.items()} == {
        "plate1.npy": "done", "plate2.npy": "doubtful", "plate12.npy": "done"
    }  # fmt: skip


def test_the_key_pressed_again_takes_the_mark_away_and_stays(window, hand, folder) -> None:
    open_project(window, hand, folder)
    press(window, hand, DONE, "plate2.npy")
    hand.key(Qt.Key.Key_Left, ALT)
    wait_for(window, hand, "plate1.npy")
    press(window, hand, DONE, "plate1.npy")
    assert table(window)[0] == ("plate1.npy", "○ untouched", "0")


def test_the_key_pressed_again_while_the_next_image_is_being_opened_changes_nothing(window, hand, folder) -> None:
    np.save(folder / "plate2.npy", np.kron(disc(), np.ones((40, 40))))  # takes a while
    open_project(window, hand, folder)
    hand.key(*DONE)
    hand.wait(lambda: window.session.opening_name)
    press(window, hand, DONE, "plate2.npy")
    assert [row[1] for row in table(window)[:2]] == ["● done", "○ untouched"]


def test_a_click_on_a_row_opens_its_image(window, hand, folder) -> None:
    open_project(window, hand, folder)
    shown = window.get_feature(ProjectFeature).panel.table
    place = shown.visualRect(shown.rows.index(4, 0)).center()
    hand.qtbot.mouseClick(shown.viewport(), Qt.MouseButton.LeftButton, pos=place)
    wait_for(window, hand, "plate5.npy")
    assert shown.currentIndex().row() == 4


@pytest.mark.usefixtures("asked")
def test_what_is_done_is_saved_on_the_way_without_a_question_and_found_again(window, hand, folder) -> None:
    before = {path: path.read_bytes() for path in folder.iterdir()}
    open_project(window, hand, folder)
    add_object(window)
    window.session.edit("draw circle", lambda document: edits.add_shape(document, Circle((20.0, 30.0), 9.0)))
    document = window.session.document
    press(window, hand, NEXT, "plate2.npy")
    assert window.session.document.shapes == ()
    assert window.session.document.objects.items == ()
    assert table(window)[:2] == [("plate1.npy", "◐ begun", "1"), ("plate2.npy", "○ untouched", "0")]
    hand.key(Qt.Key.Key_Left, ALT)
    wait_for(window, hand, "plate1.npy")
    assert window.session.document == document
    assert {path: path.read_bytes() for path in before} == before
    assert [path.name for path in (folder / PROJECT_FOLDER).glob("*.cpm")] == ["plate1.npy.cpm"]


def test_an_edit_is_saved_after_a_while(window, hand, folder) -> None:
    open_project(window, hand, folder)
    add_object(window)
    path = project_session(folder / "plate1.npy")
    hand.wait(lambda: path.exists() and not window.document_file.unsaved and window.session.idle)
    assert len(load_session(path).objects.items) == 1
    assert load_project(folder).images == {"plate1.npy": ProjectImage("begun", 1)}
    assert "Saved" not in window.canvas_area.messages.text


def test_states_and_sessions_are_there_when_the_folder_is_opened_again(window, hand, folder, image_file) -> None:
    open_project(window, hand, folder)
    add_object(window)
    press(window, hand, DONE, "plate2.npy")
    window.open_image(image_file)
    wait_for(window, hand, "disc.npy")
    assert window.workspace.project.folder is None
    open_project(window, hand, folder, "plate2.npy")
    assert table(window)[0] == ("plate1.npy", "● done", "1")
    window.open_image(folder / "plate1.npy")
    wait_for(window, hand, "plate1.npy")
    assert len(window.session.document.objects.items) == 1


def test_settings_and_classes_go_to_untouched_images(window, hand, folder) -> None:
    open_project(window, hand, folder)
    session = window.session
    session.edit("mode", lambda document: switch_mode(document, "automatic"))
    session.edit("name", lambda document: objects.name_class(document, 1, "colony", "#aabbcc"))
    session.edit("size", lambda document: edits.set_pixel_size(document, (0.5, 0.5), "µm"))
    session.edit("circle", lambda document: edits.add_shape(document, Circle((20.0, 30.0), 9.0)))
    before = session.document
    press(window, hand, DONE, "plate2.npy")
    after = session.document
    assert (after.mode, after.parameters) == (before.mode, before.parameters)
    assert after.objects.classes == before.objects.classes
    assert (after.image.spacing, after.image.unit) == ((0.5, 0.5), "µm")
    assert after.shapes == tuple(shape for shape in before.shapes if not isinstance(shape, Circle))
    assert not window.document_file.unsaved


def test_proposals_are_made_on_each_untouched_image_and_reviewed_by_two_keys(window, hand, folder) -> None:
    open_project(window, hand, folder)
    window.session.edit("mode", lambda document: switch_mode(document, "automatic"))
    window.trigger_action("apply_to_all")
    assert table(window)[1][1] == "◌ to propose"
    hand.key(*DONE)
    for number in (2, 3):
        hand.wait(
            lambda number=number: image_name(window) == f"plate{number}.npy" and window.session.scene.objects.proposals
        )
        hand.canvas.setFocus()
        hand.key(Qt.Key.Key_Return)
        assert len(window.session.document.objects.items) == 1
        hand.key(*DONE)
    wait_for(window, hand, "plate4.npy")
    assert [row[1:] for row in table(window)[1:3]] == [("● done", "1")] * 2


def test_an_image_that_needed_a_start_of_its_own_does_not_end_the_proposals_on_the_next_one(
    window, hand, folder
) -> None:
    open_project(window, hand, folder)
    window.session.edit("mode", lambda document: switch_mode(document, "automatic"))
    window.trigger_action("apply_to_all")
    hand.key(*DONE)
    hand.wait(lambda: image_name(window) == "plate2.npy" and window.session.scene.objects.proposals)
    hand.canvas.setFocus()
    window.trigger_action("mode_shape")
    window.trigger_action("clear")
    hand.drag((32, 32), (32, 36), (32, 40))
    assert not any(isinstance(shape, Everywhere) for shape in window.session.document.shapes)
    for _ in range(2):  # without the proposal
        hand.key(*DONE)
    hand.wait(lambda: image_name(window) == "plate3.npy" and window.session.scene.objects.proposals)
    assert window.session.document.mode == "automatic"


def test_proposals_that_are_not_accepted_are_not_lost_without_a_sentence(window, hand, folder) -> None:
    open_project(window, hand, folder)
    window.session.edit("mode", lambda document: switch_mode(document, "automatic"))
    window.session.run()
    hand.wait(lambda: window.session.scene.objects.proposals and window.session.idle)
    hand.canvas.setFocus()
    hand.key(*DONE)
    said = "Proposals that are not accepted: 1. Accept them, or press the same key again to go on without them."
    assert window.canvas_area.messages.text == said
    assert (image_name(window), table(window)[0][1]) == ("plate1.npy", "○ untouched")
    press(window, hand, DONE, "plate2.npy")
    assert table(window)[0] == ("plate1.npy", "● done", "0")
    hand.key(Qt.Key.Key_Left, ALT)
    wait_for(window, hand, "plate1.npy")
    hand.key(*DONE)
    window.session.run()
    hand.wait(lambda: window.session.scene.objects.proposals and window.session.idle)
    hand.key(*DONE)
    hand.key(Qt.Key.Key_Return)
    press(window, hand, DONE, "plate2.npy")
    assert table(window)[0] == ("plate1.npy", "● done", "1")


def test_an_image_is_not_done_by_a_key_pressed_before_its_proposals_are_there(window, hand, folder) -> None:
    open_project(window, hand, folder)
    window.session.edit("mode", lambda document: switch_mode(document, "automatic"))
    window.trigger_action("apply_to_all")
    hand.key(*DONE)
    hand.wait(lambda: image_name(window) == "plate2.npy")
    hand.key(*DONE)
    said = "Objects are still being found. Wait, or press the same key again to go on without them."
    assert window.canvas_area.messages.text == said
    assert [row[1] for row in table(window)[:2]] == ["● done", "○ untouched"]
    hand.wait(lambda: window.session.scene.objects.proposals)
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_Return)
    press(window, hand, DONE, "plate3.npy")
    assert table(window)[1] == ("plate2.npy", "● done", "1")


def test_enter_in_the_list_of_images_accepts_what_is_proposed(window, hand, folder) -> None:
    open_project(window, hand, folder)
    shown = window.get_feature(ProjectFeature).panel.table
    place = shown.visualRect(shown.rows.index(1, 0)).center()
    hand.qtbot.mouseClick(shown.viewport(), Qt.MouseButton.LeftButton, pos=place)
    wait_for(window, hand, "plate2.npy")
    window.session.edit("mode", lambda document: switch_mode(document, "automatic"))
    window.session.run()
    hand.wait(lambda: window.session.scene.objects.proposals and window.session.idle)
    shown.setFocus()
    hand.key(Qt.Key.Key_Return)
    assert len(window.session.document.objects.items) == 1


def test_the_next_image_is_run_ahead_and_its_proposals_are_those_of_a_run_in_the_window(window, hand, folder) -> None:
    project, scene = window.workspace.project, lambda: window.session.scene
    open_project(window, hand, folder)
    window.session.edit("mode", lambda document: switch_mode(document, "automatic"))
    window.trigger_action("apply_to_all")
    window.session.run()
    hand.wait(lambda: scene().objects.proposals and project._prepared)
    hand.key(*DONE)
    press(window, hand, DONE, "plate2.npy")
    hand.wait(lambda: scene().objects.proposals and scene().contours)
    (ahead,) = scene().objects.proposals
    assert window.session.status.phase != "running"
    assert not window.document_file.unsaved
    assert table(window)[1][1] == "○ untouched"
    window.session.reset()
    window.session.run()
    hand.wait(lambda: window.session.status.phase == "finished" and window.session.idle)
    window.workspace.object_selection.search_again()
    hand.wait(lambda: scene().objects.proposals and scene().objects.proposals[0].selection is not ahead.selection)
    (here,) = scene().objects.proposals
    assert np.array_equal(ahead.selection.mask, here.selection.mask)
    assert ahead.selection.confidence == here.selection.confidence


def test_without_a_start_that_suits_all_images_nothing_is_applied(window, hand, folder) -> None:
    open_project(window, hand, folder)
    window.trigger_action("apply_to_all")
    assert "start everywhere" in window.canvas_area.messages.text
    assert not window.workspace.project.proposes


def test_the_table_of_all_images_has_the_objects_of_each_with_class_and_confidence(
    window, hand, folder, tmp_path, monkeypatch
) -> None:
    open_project(window, hand, folder)
    add_object(window, 0.75)
    press(window, hand, DONE, "plate2.npy")
    add_object(window)
    add_object(window)
    press(window, hand, DONE, "plate3.npy")
    press(window, hand, DONE, "plate4.npy")
    target = tmp_path / "all.csv"
    monkeypatch.setattr(window.files, "ask_where_to_save", lambda *_, **__: target)
    window.trigger_action("export_all_images")
    hand.wait(lambda: target.exists() and window.session.idle)
    rows = list(csv.DictReader(target.read_text("utf-8").splitlines()))
    assert [(row["image"], row["label"], row["class"], row["confidence"]) for row in rows] == [
        ("plate1.npy", "1", "object", "0.75"),
        ("plate2.npy", "1", "object", "0.5"),
        ("plate2.npy", "2", "object", "0.5"),
    ]
    assert next(iter(rows[0])) == "image"
    assert all(float(row["area_px2"]) == 100.0 and float(row["perimeter_px"]) == 40.0 for row in rows)
    assert "3 objects in 2 images; done without an object: 1" in window.canvas_area.messages.text


def test_where_nothing_can_be_saved_one_sentence_says_so_and_one_can_look_on(window, hand, folder) -> None:
    (folder / PROJECT_FOLDER).write_text("a file of this name")
    open_project(window, hand, folder)
    add_object(window)
    hand.wait(lambda: "is not saved" in window.canvas_area.messages.text)
    press(window, hand, NEXT, "plate2.npy")  # after the question about unsaved work
    assert window.get_feature(OpenSaveFeature).document_file.path is None


def test_looking_through_a_folder_writes_nothing(window, hand, folder) -> None:
    open_project(window, hand, folder)
    press(window, hand, NEXT, "plate2.npy")
    press(window, hand, NEXT, "plate3.npy")
    assert not (folder / PROJECT_FOLDER).exists()


def test_the_session_of_another_part_of_a_file_is_not_replaced(window, hand, folder) -> None:
    open_project(window, hand, folder)
    add_object(window)
    path = project_session(folder / "plate1.npy")
    hand.wait(lambda: path.exists() and not window.document_file.unsaved and window.session.idle)
    before = path.read_bytes()
    window.get_feature(OpenSaveFeature).open_part(folder / "plate1.npy", False, Reading(spacing=(2.0, 2.0), unit="mm"))
    hand.wait(lambda: window.session.document.image.unit == "mm" and window.session.idle)
    window.session.edit("draw circle", lambda document: edits.add_shape(document, Circle((20.0, 30.0), 9.0)))
    press(window, hand, NEXT, "plate2.npy")  # after the question about unsaved work
    assert path.read_bytes() == before


def test_a_damaged_project_is_reported_and_left_as_it_is(window, hand, folder) -> None:
    (folder / PROJECT_FOLDER).mkdir()
    (folder / PROJECT_FOLDER / "project.json").write_text("{")
    window.open_image(folder)
    hand.wait(lambda: image_name(window) == "plate1.npy" and window.session.idle)
    assert "damaged" in window.canvas_area.messages.text
    press(window, hand, DONE, "plate2.npy")
    assert table(window)[0][1] == "● done"
    assert (folder / PROJECT_FOLDER / "project.json").read_text() == "{"


def test_a_folder_with_links_to_images_is_a_project_too(window, hand, folder, tmp_path) -> None:
    links = tmp_path / "links"
    links.mkdir()
    for number in (1, 2):
        (links / f"{number}.npy").symlink_to(folder / f"plate{number}.npy")
    window.open_image(links)
    hand.wait(lambda: window.workspace.project.current == links / "1.npy" and window.session.idle)
    add_object(window)
    hand.key(*NEXT)
    hand.wait(lambda: window.workspace.project.current == links / "2.npy" and window.session.idle)
    hand.key(*NEXT)
    hand.wait(lambda: window.workspace.project.current == links / "1.npy" and window.session.idle)
    assert len(window.session.document.objects.items) == 1
