"""The export dialog: what is written, what is left out and told, and where the file goes."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
import tifffile
from PySide6.QtCore import QPoint, Qt

import cpm_core
from app.model.document import edits
from app.session.storage.folders import first_folder
from app.views.export.dialog import ExportDialog
from app.views.features.exchange import ExportFeature
from app.views.main_window import MainWindow
from cpm_core.objects.segmented.segmented_object import SegmentedObject
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle
from tests.app.conftest import Hand

pytestmark = pytest.mark.shared_window

KEY, CTRL = Qt.Key, Qt.KeyboardModifier.ControlModifier
LEFT = Qt.MouseButton.LeftButton
DISCS = ((12, 36, 18), (48, 96, 16), (60, 30, 12))
"""Row, column and radius; the border cuts the first one."""


def inside(disc: tuple[int, int, int]) -> np.ndarray:
    row, col = np.indices((80, 128))
    return np.hypot(row - disc[0], col - disc[1]) < disc[2]


@pytest.fixture
def found(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window in which two closed contours and an open one have been found."""
    (tmp_path / "images").mkdir()
    path = tmp_path / "images" / "discs.npy"
    np.save(path, 20.0 + 150.0 * sum(inside(disc) for disc in DISCS))
    session = window.session
    session.open(path)
    hand.wait(lambda: session.document.image is not None and session.document.image.name == "discs.npy")
    session.edit("reach", lambda document: replace(document, parameters=Parameters()))
    for row, col, radius in DISCS:
        circle = Circle((float(max(row, 16)), float(col)), 0.6 * radius)
        session.edit("draw", lambda document, circle=circle: edits.add_shape(document, circle))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    assert sorted(item.contour.closed for item in window.workspace.review.items) == [False, True, True]
    return window


@pytest.fixture
def dialog(found: MainWindow, hand: Hand) -> ExportDialog:
    return asked(hand, found)


def asked(hand: Hand, window: MainWindow) -> ExportDialog:
    """The dialog, opened by its key."""
    window.activateWindow()
    hand.wait(window.isActiveWindow)
    hand.canvas.setFocus()
    hand.key(KEY.Key_E, CTRL)
    opened = window.feature(ExportFeature).dialog
    assert opened is not None
    hand.qtbot.waitExposed(opened)
    return opened


def type_into(hand: Hand, field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, text)


def click(hand: Hand, button) -> None:
    hand.qtbot.mouseClick(button, LEFT, pos=QPoint(8, button.height() // 2))


def choose(hand: Hand, combo, data: str) -> None:
    """Choose an entry by arrow keys."""
    combo.setFocus()
    down = combo.findData(data) > combo.currentIndex()
    for _ in range(combo.count()):
        if combo.currentData() == data:
            return
        hand.qtbot.keyClick(combo, KEY.Key_Down if down else KEY.Key_Up)
    raise AssertionError(data)


def write(hand: Hand, window: MainWindow, dialog: ExportDialog) -> Path:
    path = dialog.file.path
    hand.qtbot.mouseClick(dialog.export_button, LEFT)
    hand.wait(path.exists)
    hand.wait(lambda: window.session.idle)
    return path


def test_the_file_tells_image_start_and_whether_the_run_was_steered(found, hand, dialog) -> None:
    type_into(hand, dialog.file.name, "plain.json")
    made = json.loads(write(hand, found, dialog).read_text(encoding="utf-8"))["provenance"]
    path = Path(found.session.document.image.path)
    assert made["image"] == {"name": "discs.npy", "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}
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
    again = asked(hand, found)
    type_into(hand, again.file.name, "steered.json")
    made = json.loads(write(hand, found, again).read_text(encoding="utf-8"))["provenance"]
    assert made["steered"] and made["parameters"]["beta"] == 0.6


@pytest.mark.parametrize("closing", ["edges", "straight"])
def test_open_contours_are_closed_on_request(found, hand, dialog, closing) -> None:
    choose(hand, dialog.format, ".tif")
    assert dialog.file.name.text() == "discs_contours.tif"
    choose(hand, dialog.closing, closing)
    hand.wait(lambda: "closed for the export" in dialog.counts.text())
    assert dialog.counts.text().startswith("Writes 3 contours, 1 of them closed for the export.")
    labels = tifffile.imread(write(hand, found, dialog))
    for disc in DISCS:
        label = labels[max(disc[0], 6), disc[1]]
        assert label > 0
        truth = inside(disc)
        assert 2 * ((labels == label) & truth).sum() / ((labels == label).sum() + truth.sum()) > 0.95
    assert "1 of them closed for the export" in found.canvas_area.messages.text


def test_kept_ones_only_and_the_selection_are_written_with_the_numbers_of_the_table(found, hand, tmp_path) -> None:
    review = found.workspace.review
    numbers = {item.measures.number: item.key for item in review.items}
    review.select([numbers[2]])
    hand.key(KEY.Key_K)
    review.select([numbers[1], numbers[3]])
    for source, wanted in (("kept", [2]), ("selected", [1, 3]), ("all", [1, 2, 3])):
        dialog = asked(hand, found)
        click(hand, dialog.sources[source])
        assert f"({len(wanted)})" in dialog.sources[source].text()
        type_into(hand, dialog.file.name, f"{source}.json")
        path = write(hand, found, dialog)
        assert [one["number"] for one in json.loads(path.read_text(encoding="utf-8"))["contours"]] == wanted


def test_a_typed_size_of_a_pixel_goes_into_the_file(found, hand, dialog) -> None:
    type_into(hand, dialog.file.name, "found.json")
    type_into(hand, dialog.pixel_size.number, "0.25")
    hand.qtbot.keyClick(dialog.pixel_size.number, KEY.Key_Tab)
    image = json.loads(write(hand, found, dialog).read_text(encoding="utf-8"))["image"]
    assert (image["spacing"], image["unit"]) == ([0.25, 0.25], "µm")


def test_a_folder_that_is_not_there_and_the_image_itself_are_refused(found, hand, dialog, tmp_path) -> None:
    type_into(hand, dialog.file.folder, str(tmp_path / "nowhere"))
    assert "there is no folder" in dialog.note.text()
    assert not dialog.export_button.isEnabled()
    type_into(hand, dialog.file.folder, str(tmp_path))
    assert dialog.export_button.isEnabled()
    dialog.file._image = tmp_path / "scan.png"
    type_into(hand, dialog.file.name, "scan.png")
    assert "is the image itself" in dialog.note.text()
    assert not dialog.export_button.isEnabled()


def test_a_folder_that_was_chosen_is_that_of_the_next_dialog_for_this_image_only(found, hand, dialog, tmp_path) -> None:
    (tmp_path / "out").mkdir()
    type_into(hand, dialog.file.folder, str(tmp_path / "out"))
    write(hand, found, dialog)
    again = asked(hand, found)
    assert again.file.path.parent == tmp_path / "out"
    assert again.note.text().endswith("is there already and will be replaced.")
    hand.qtbot.keyClick(again, KEY.Key_Escape)
    other = tmp_path / "images" / "other.npy"
    np.save(other, np.indices((64, 64))[0].astype(float))
    found.session.open(other)
    hand.wait(lambda: found.session.document.image.name == "other.npy")
    assert first_folder(found.preferences, found.session.document, "export") == tmp_path / "images"


def test_objects_are_offered_and_written_without_a_run(window, hand, tmp_path) -> None:
    session = window.session
    square = ((4.0, 4.0), (4.0, 20.0), (20.0, 20.0), (20.0, 4.0))
    both = (square, ((8.0, 8.0), (12.0, 8.0), (12.0, 12.0), (8.0, 12.0)))
    item = SegmentedObject(number=7, clicks=(), boundary=both, gaps=(), confidence=1.0, strength=1.0, name="cell")
    session.edit("take", lambda document: replace(document, objects=replace(document.objects, items=(item,))))
    dialog = asked(hand, window)
    assert [name for name, button in dialog.sources.items() if button.isEnabled()] == ["objects"]
    assert dialog.order.source == "objects"
    assert "(1)" in dialog.sources["objects"].text()
    assert dialog.counts.text() == "Writes 1 object."
    type_into(hand, dialog.file.folder, str(tmp_path))
    type_into(hand, dialog.file.name, "objects.json")
    content = json.loads(write(hand, window, dialog).read_text(encoding="utf-8"))
    assert content["provenance"]["method"] == "objects"
    assert content["provenance"]["image"]["sha256"] == session.document.image.sha256
    assert [(contour["name"], contour["closed"]) for contour in content["contours"]] == [("cell", True)] * 2
    dialog = asked(hand, window)
    type_into(hand, dialog.file.name, "objects.figure.png")
    with PIL.Image.open(write(hand, window, dialog)) as figure:
        gray = np.asarray(figure.convert("L")).astype(float)
    assert gray[: len(gray) // 2].std() > 10.0  # the image is there, too
