"""The export dialog: what is written, under which names, and what is left out."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import PIL.Image
import pytest
import tifffile
from cpm_app.model.document import edits
from cpm_app.model.export import export_file_name, list_export_formats
from cpm_app.views.export import dialog as export_dialog
from cpm_app.views.export.dialog import ExportDialog
from cpm_app.views.features.exchange import ExportFeature
from cpm_app.views.window.dialogs import QuestionDialog
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

import cpm_core
from cpm_core.formats import CONTOURS_WRITABLE
from cpm_core.image.region import Region
from cpm_core.objects.segmented.segmented_object import SegmentedObject
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle
from tests.app.conftest import Hand
from tests.app.exporting import asked, check, export, offered, order
from tests.app.reading import treat_as_saved

pytestmark = pytest.mark.shared_window

KEY, CTRL, SHIFT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
LEFT = Qt.MouseButton.LeftButton
DISCS = ((12, 36, 18), (48, 96, 16), (60, 30, 12))
"""Row, column and radius; the border cuts the first one."""


def inside(disc: tuple[int, int, int]) -> np.ndarray:
    row, col = np.indices((80, 128))
    return np.hypot(row - disc[0], col - disc[1]) < disc[2]


SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def found(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window in which two closed contours and an open one have been found."""
    (tmp_path / "images").mkdir()
    path = tmp_path / "images" / "discs.npy"
    np.save(path, 20.0 + 150.0 * sum(inside(disc) for disc in DISCS))
    session = window.session
    session.open_file(path)
    hand.wait(lambda: session.document.image is not None and session.document.image.name == "discs.npy")
    session.edit("reach", lambda document: replace(document, parameters=Parameters()))
    for row, col, radius in DISCS:
        circle = Circle((float(max(row, 16)), float(col)), 0.6 * radius)
        session.edit("draw", lambda document, circle=circle: edits.add_shape(document, circle))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    assert sorted(contour.closed for contour in window.session.scene.contours) == [False, True, True]
    return window


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "written"
    made.mkdir()
    return made


ANGLES = np.arange(0.0, 2.0 * np.pi, 0.02)


def ring(radius: float) -> tuple[tuple[float, float], ...]:
    points = 30.0 + radius * np.stack([np.sin(ANGLES), np.cos(ANGLES)], axis=1)
    return tuple(map(tuple, points.tolist()))


@pytest.fixture
def two(window: MainWindow) -> MainWindow:
    """A window with an object of a class without a name, which has a hole, and one of another class."""
    first = SegmentedObject(number=7, clicks=(), region=Region((ring(20.0), ring(8.0))), name="cell", category=2)
    other = SegmentedObject(number=9, clicks=(), region=Region((ring(4.0),)))
    session = window.session
    session.edit("take", lambda document: replace(document, objects=replace(document.objects, items=(first, other))))
    return window


def test_the_file_names_image_start_and_whether_the_run_was_steered(found, hand, folder) -> None:
    (path,) = export(hand.qtbot, found, folder, "contours:.json")
    made = json.loads(path.read_text(encoding="utf-8"))["provenance"]
    image = Path(found.session.document.image.path)
    assert made["image"] == {"name": "discs.npy", "sha256": hashlib.sha256(image.read_bytes()).hexdigest()}
    assert [(shape["shape"], shape["center"][1]) for shape in made["shapes"]] == [("circle", disc[1]) for disc in DISCS]
    assert made["parameters"]["reach"] == Parameters().reach
    assert (made["method"], made["version"], "steered" in made) == ("cpm", cpm_core.__version__, False)
    assert made["seeds"] > 30 and made["steps"] == found.session.scene.snapshot.state.step

    found.session.edit("beta", lambda document: replace(document, parameters=Parameters(beta=0.6)))
    found.activateWindow()
    hand.wait(found.isActiveWindow)
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait(lambda: found.session.scene.snapshot.state.step > made["steps"])
    hand.wait_for_phase("finished")
    hand.wait(lambda: found.session.idle)
    before = path.stat().st_mtime_ns
    hand.key(KEY.Key_E, CTRL | SHIFT)
    hand.wait(lambda: path.stat().st_mtime_ns > before and found.session.idle)
    made = json.loads(path.read_text(encoding="utf-8"))["provenance"]
    assert made["steered"] and made["parameters"]["beta"] == 0.6


def test_labels_are_the_closed_contours_and_open_ones_are_counted(found, hand, folder) -> None:
    dialog = asked(hand.qtbot, found)
    check(hand.qtbot, dialog, "contours:.tif")
    assert dialog.summary.text() == "1 file: 2 contours, 1 open ones left out."
    (path,) = order(hand.qtbot, found, dialog, folder)
    labels = tifffile.imread(path)
    for disc in DISCS[1:]:
        label = labels[max(disc[0], 6), disc[1]]
        assert label > 0
        truth = inside(disc)
        assert 2 * ((labels == label) & truth).sum() / ((labels == label).sum() + truth.sum()) > 0.95
    assert "2 contours, 1 open ones left out" in found.canvas_area.messages.text


def test_only_the_selected_contours_are_written(found, hand, folder) -> None:
    lengths = [contour.length for contour in found.session.scene.contours]
    found.workspace.contour_selection.select([0, 2])
    dialog = asked(hand.qtbot, found)
    check(hand.qtbot, dialog, "contours:.json")
    for wanted in ([1, 3], [1, 2, 3]):
        hand.qtbot.mouseClick(dialog.only, LEFT, pos=dialog.only.rect().center() * 0.1)
        assert f": {len(wanted)} contours" in dialog.summary.text()
    hand.qtbot.mouseClick(dialog.only, LEFT, pos=dialog.only.rect().center() * 0.1)
    (path,) = order(hand.qtbot, found, dialog, folder)
    written = [one["length"] for one in json.loads(path.read_text(encoding="utf-8"))["contours"]]
    assert written == pytest.approx([lengths[0], lengths[2]], abs=1e-3)


def test_a_figure_shows_image_contours_and_a_scale_bar(found, hand, folder) -> None:
    found.session.edit("size", lambda document: edits.set_pixel_size(document, (0.25, 0.25), "µm"))
    hand.wait(lambda: found.session.idle)
    (path,) = export(hand.qtbot, found, folder, "contours:.figure.svg")
    assert path.name == "discs_contours.figure.svg"
    root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    assert root.find(f".//{SVG}image") is not None
    assert len(root.findall(f".//{SVG}path")) >= 6
    assert any("µm" in "".join(text.itertext()) for text in root.iter(f"{SVG}text"))


def test_files_are_replaced_only_where_the_user_agrees(two, hand, monkeypatch) -> None:
    image = Path(two.session.document.image.path)
    names, answers = [], [False, True]
    monkeypatch.setattr(export_dialog, "ask_to_replace", lambda _, name, others: names.append(name) or answers.pop(0))
    old = image.with_name(f"{image.stem}.json")
    old.write_text("old")
    dialog = asked(hand.qtbot, two)
    check(hand.qtbot, dialog, "objects:.labelme.json")
    hand.qtbot.mouseClick(dialog.export_button, LEFT)
    assert (names, dialog.isVisible(), old.read_text()) == ([old.name], True, "old")
    hand.qtbot.mouseClick(dialog.export_button, LEFT)
    hand.wait(lambda: two.session.idle and old.read_text() != "old")
    hand.key(KEY.Key_E, CTRL | SHIFT)
    hand.wait(lambda: two.session.idle)
    assert len(names) == 2, "what the program has written is replaced without a question"


def test_the_question_about_several_files_counts_them(two, hand, monkeypatch) -> None:
    image, questions = Path(two.session.document.image.path), []
    monkeypatch.setattr(QuestionDialog, "wait_for_answer", lambda question: questions.append(question.text()) or "keep")
    dialog = asked(hand.qtbot, two)
    check(hand.qtbot, dialog, "objects:.labelme.json", "objects:.png")
    for ending in (".json", "_objects.png"):
        image.with_name(image.stem + ending).write_text("old")
        hand.qtbot.mouseClick(dialog.export_button, LEFT)
    assert questions == [f"Replace “{image.stem}.json”?", f"Replace “{image.stem}.json” and 1 more?"]


def test_every_format_is_offered() -> None:
    assert {*list_export_formats("objects"), *list_export_formats("contours")} == set(CONTOURS_WRITABLE) - {
        ".tiff",
        ".nii",
        ".roi",
    }
    for what in ("objects", "contours"):
        names = [export_file_name("a", what, suffix, False) for suffix in list_export_formats(what)]
        assert len(set(names)) == len(names)


def test_objects_are_offered_and_written_without_a_run_in_several_formats_at_once(two, hand, folder) -> None:
    dialog = asked(hand.qtbot, two)
    assert {key.partition(":")[0] for key in offered(dialog)} == {"objects"}
    assert dialog.windowTitle() == "Export objects"
    check(hand.qtbot, dialog, "objects:.json", "objects:.table.csv", "objects:.nrrd", "objects:.figure.png")
    assert dialog.summary.text() == "4 files: 2 objects."
    paths = order(hand.qtbot, two, dialog, folder)
    stem = Path(two.session.document.image.name).stem
    assert [path.name.removeprefix(stem) for path in paths] == [
        "_objects.seg.nrrd", "_objects.csv", "_objects.json", "_objects.figure.png",
    ]  # fmt: skip
    content = json.loads(paths[2].read_text(encoding="utf-8"))
    assert content["provenance"]["method"] == "objects"
    assert content["provenance"]["image"]["sha256"] == two.session.document.image.sha256
    assert [contour["name"] for contour in content["contours"]] == ["cell", "cell", "object 9"]
    assert len(paths[1].read_text(encoding="utf-8").splitlines()) == 3
    with PIL.Image.open(paths[3]) as figure:
        gray = np.asarray(figure.convert("L")).astype(float)
    assert gray[: len(gray) // 2].std() > 10.0  # the image is there, too


def test_labelme_gets_the_names_of_classes_that_are_asked_for_and_few_vertices(two, hand, monkeypatch) -> None:
    image = Path(two.session.document.image.path)
    dialog = asked(hand.qtbot, two)
    check(hand.qtbot, dialog, "objects:.labelme.json", "objects:.csv")
    assert sorted(dialog.classes) == [1, 2]
    hand.qtbot.keyClicks(dialog.classes[2], "nucleus")
    whole = sum(len(curve) for curve in (ring(20.0), ring(8.0), ring(4.0)))
    assert dialog._vertices.text().endswith(f" of {whole} vertices")
    few = int(dialog._vertices.text().split()[0])
    assert few < 100
    file, table = order(hand.qtbot, two, dialog, image.parent)
    assert file == image.with_suffix(".json"), "labelme opens it with the image"
    content = json.loads(file.read_text(encoding="utf-8"))
    assert content["imagePath"] == image.name
    cell, other = content["shapes"]
    assert (cell["label"], cell["description"], cell["group_id"]) == ("nucleus", "cell", 7)
    assert (other["label"], other["description"], other["group_id"]) == ("object", "object 9", 9)
    assert len(cell["points"]) + len(other["points"]) == few + 2, "a slit visits two vertices twice"
    assert len(table.read_text(encoding="utf-8").splitlines()) == whole + 1
    assert two.session.document.objects.classes[1].name == "nucleus"


def test_the_choice_is_kept_and_repeated_without_a_dialog_for_another_image(two, hand, folder, image_file) -> None:
    export(hand.qtbot, two, folder, "objects:.svg", "objects:.coco.json")
    dialog = asked(hand.qtbot, two)
    assert [file.suffix for file in dialog.checked_files] == [".coco.json", ".svg"]
    dialog.reject()
    items = two.session.document.objects
    copy = image_file.with_name("second.npy")
    copy.write_bytes(image_file.read_bytes())
    treat_as_saved(two)
    two.open_image(copy)
    hand.wait(lambda: two.session.document.image.name == copy.name and two.session.idle)
    two.session.edit("take", lambda document: replace(document, objects=items))
    two.activateWindow()
    hand.wait(two.isActiveWindow)
    hand.key(KEY.Key_E, CTRL | SHIFT)
    written = [copy.with_name(f"second_objects{suffix}") for suffix in (".svg", ".coco.json")]
    hand.wait(lambda: all(path.exists() for path in written) and two.session.idle)
    assert two.get_feature(ExportFeature).dialog is None


def test_the_folder_is_chosen_and_nothing_is_written_where_one_file_cannot_be(two, hand, folder, monkeypatch) -> None:
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(folder))
    (folder / "b_objects.svg").mkdir()
    monkeypatch.setattr(export_dialog, "ask_to_replace", lambda *_: True)
    dialog = asked(hand.qtbot, two)
    check(hand.qtbot, dialog, "objects:.geojson", "objects:.svg")
    hand.qtbot.mouseClick(dialog._folder_button, LEFT)
    dialog.base.selectAll()
    hand.qtbot.keyClicks(dialog.base, "b")
    hand.qtbot.mouseClick(dialog.export_button, LEFT)
    hand.wait(lambda: "b_objects.svg in " in two.canvas_area.messages.text and two.session.idle)
    assert [path.name for path in folder.iterdir()] == ["b_objects.svg"]


def test_a_name_is_needed_and_something_to_write(two, hand) -> None:
    dialog: ExportDialog = asked(hand.qtbot, two)
    dialog.base.selectAll()
    hand.qtbot.keyClick(dialog.base, KEY.Key_Delete)
    assert not dialog.export_button.isEnabled()
    hand.qtbot.keyClicks(dialog.base, "a")
    assert dialog.export_button.isEnabled()
    check(hand.qtbot, dialog)
    assert (dialog.export_button.isEnabled(), dialog.summary.text()) == (False, "Choose what to export.")
    dialog.reject()
