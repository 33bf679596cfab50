"""The export dialog: what is written, and what is left out."""

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
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

import cpm_core
from app.model.document import edits
from app.model.document.contours import judge
from app.model.export import formats, listed
from app.views.export.dialog import ExportDialog
from app.views.features.exchange import ExportFeature
from app.views.window.dialogs import FileDialogs
from app.views.window.window import MainWindow
from cpm_core.formats import WRITABLE
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


SVG = "{http://www.w3.org/2000/svg}"


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


def choose(hand: Hand, combo, data: str) -> None:
    """Choose an entry by arrow keys."""
    combo.setFocus()
    down = combo.findData(data) > combo.currentIndex()
    for _ in range(combo.count()):
        if combo.currentData() == data:
            return
        hand.qtbot.keyClick(combo, KEY.Key_Down if down else KEY.Key_Up)
    raise AssertionError(data)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where files are written, under the names that are suggested."""
    made = tmp_path / "written"
    made.mkdir()
    monkeypatch.setattr(
        QFileDialog, "getSaveFileName", lambda parent, title, begin, *_: (str(made / Path(begin).name), "")
    )
    return made


def write(hand: Hand, window: MainWindow, dialog: ExportDialog, suffix: str) -> Path:
    """The file that the dialog leads to, by a click on its button."""
    choose(hand, dialog.format, suffix)
    written = []
    dialog.ordered.connect(lambda path, _: written.append(path))
    hand.qtbot.mouseClick(dialog.export_button, LEFT)
    hand.wait(written[0].exists)
    hand.wait(lambda: window.session.idle)
    return written[0]


def test_the_file_names_image_start_and_whether_the_run_was_steered(found, hand, dialog) -> None:
    made = json.loads(write(hand, found, dialog, ".json").read_text(encoding="utf-8"))["provenance"]
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
    made = json.loads(write(hand, found, asked(hand, found), ".json").read_text(encoding="utf-8"))["provenance"]
    assert made["steered"] and made["parameters"]["beta"] == 0.6


@pytest.mark.parametrize("closing", ["edges", "straight"])
def test_open_contours_are_closed_on_request(found, hand, dialog, closing) -> None:
    choose(hand, dialog.format, ".tif")
    choose(hand, dialog.closing, closing)
    assert dialog.summary.text().startswith("Writes 3 contours, 1 of them closed for the export.")
    labels = tifffile.imread(write(hand, found, dialog, ".tif"))
    for disc in DISCS:
        label = labels[max(disc[0], 6), disc[1]]
        assert label > 0
        truth = inside(disc)
        assert 2 * ((labels == label) & truth).sum() / ((labels == label).sum() + truth.sum()) > 0.95
    assert "1 of them closed for the export" in found.canvas_area.messages.text


def test_kept_ones_only_and_the_selection_are_written_with_the_numbers_of_the_table(found, hand) -> None:
    review = found.workspace.review
    numbers = {item.measures.number: item.key for item in review.items}
    target = review.target(review[numbers[2]])
    found.session.edit("keep", lambda document: judge(document, [target], "kept"))
    review.select([numbers[1], numbers[3]])
    for source, wanted in (("kept", [2]), ("selected", [1, 3]), ("all", [1, 2, 3])):
        dialog = asked(hand, found)
        choose(hand, dialog.source, source)
        assert f"({len(wanted)})" in dialog.source.currentText()
        path = write(hand, found, dialog, ".json")
        assert [one["number"] for one in json.loads(path.read_text(encoding="utf-8"))["contours"]] == wanted


def test_a_figure_shows_image_contours_and_a_scale_bar(found, hand) -> None:
    found.session.edit("size", lambda document: edits.set_pixel_size(document, (0.25, 0.25), "µm"))
    hand.wait(lambda: found.session.idle)
    path = write(hand, found, asked(hand, found), ".figure.svg")
    assert path.name == "discs_contours.figure.svg"
    root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    assert root.find(f".//{SVG}image") is not None
    assert len(root.findall(f".//{SVG}path")) >= 6
    assert any("µm" in "".join(text.itertext()) for text in root.iter(f"{SVG}text"))


def test_the_image_itself_is_not_replaced(found, hand, dialog, monkeypatch) -> None:
    image = Path(found.session.document.image.path)
    monkeypatch.setattr(FileDialogs, "ask_where_to_save", lambda *_, **__: image)
    dialog.accept()
    assert "is the image itself" in dialog.summary.text()
    assert dialog.isVisible()
    dialog.reject()


def test_every_format_is_offered() -> None:
    assert {listed(suffix) for suffix in WRITABLE} == set(formats())


def test_objects_are_offered_and_written_without_a_run(window, hand) -> None:
    session = window.session
    square = ((4.0, 4.0), (4.0, 20.0), (20.0, 20.0), (20.0, 4.0))
    both = (square, ((8.0, 8.0), (12.0, 8.0), (12.0, 12.0), (8.0, 12.0)))
    item = SegmentedObject(number=7, clicks=(), boundary=both, gaps=(), confidence=1.0, strength=1.0, name="cell")
    session.edit("take", lambda document: replace(document, objects=replace(document.objects, items=(item,))))
    dialog = asked(hand, window)
    assert [dialog.source.itemData(row) for row in range(dialog.source.count())] == ["objects"]
    assert dialog.summary.text() == "Writes 1 object."
    content = json.loads(write(hand, window, dialog, ".json").read_text(encoding="utf-8"))
    assert content["provenance"]["method"] == "objects"
    assert content["provenance"]["image"]["sha256"] == session.document.image.sha256
    assert [(contour["name"], contour["closed"]) for contour in content["contours"]] == [("cell", True)] * 2
    with PIL.Image.open(write(hand, window, asked(hand, window), ".figure.png")) as figure:
        gray = np.asarray(figure.convert("L")).astype(float)
    assert gray[: len(gray) // 2].std() > 10.0  # the image is there, too
