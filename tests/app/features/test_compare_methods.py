"""The comparison of methods: each runs in its place from the drawn start, and nothing runs on after it is closed."""

from __future__ import annotations

import csv
import threading

import numpy as np
import PIL.Image
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QFileDialog

from app.model.document import edits
from app.views.features.view.methods import MethodsFeature
from app.views.main_window import MainWindow
from app.views.mosaic.methods import CompareDialog
from app.views.mosaic.methods.dialog import FIRST
from cpm_core.contours.ground_truth import truth_of_mask
from cpm_core.image.image import Image
from cpm_core.segmentation.methods import CONTOUR_METHODS, Start, run_method
from cpm_core.shapes.outlines import outlines_of
from tests.app.conftest import Hand, disc

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def dialog(ready: MainWindow, hand: Hand) -> CompareDialog:
    """The dialog, opened by its keys."""
    hand.key(KEY.Key_M, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    made = ready.feature(MethodsFeature).dialog
    assert made is not None
    hand.qtbot.waitExposed(made)
    return made


def frames(ready: MainWindow) -> list:
    return ready.workspace.comparison.frames


def outcome(frame) -> tuple:
    return frame.facts.steps, [contour.length for contour in frame.contours]


def run(ready: MainWindow, hand: Hand, dialog: CompareDialog) -> None:
    hand.qtbot.mouseClick(dialog.run_button, LEFT)
    hand.wait(lambda: not ready.workspace.comparison.running)


def test_each_place_shows_what_its_method_gives(ready, dialog, hand) -> None:
    assert [pane.method for pane in dialog.panes] == list(FIRST)
    run(ready, hand, dialog)
    start = Start(outlines_of(ready.session.document.shapes))
    for pane, frame in zip(dialog.panes, frames(ready), strict=True):
        assert frame.over and not frame.trouble
        assert pane.words.text().startswith(f"{frame.facts.steps} steps, ")
        settings = ready.session.document.parameters if pane.method == "cpm" else None
        alone = run_method(CONTOUR_METHODS[pane.method], Image(disc()), start, settings).state
        assert frame.facts.steps == alone.step
        for mine, theirs in zip(frame.contours, alone.contours, strict=True):
            np.testing.assert_array_equal(mine.points, theirs.points)
    assert not ready.session.status.started, "the run of the window is left alone"


def test_figures_are_shown_where_a_truth_is_loaded(ready, dialog, hand, tmp_path) -> None:
    mask = tmp_path / "mask.png"
    PIL.Image.fromarray((disc() > 100).astype(np.uint8) * 255).save(mask)
    ready.workspace.truth.load(mask)
    hand.wait(lambda: ready.session.scene.truth is not None)
    run(ready, hand, dialog)
    for pane, frame in zip(dialog.panes, frames(ready), strict=True):
        assert f"Dice {frame.facts.dice:.3f}, F {frame.facts.f:.3f}" in pane.words.text()
    assert frames(ready)[0].facts.f > 0.99
    assert np.array_equal(ready.session.scene.truth.labels, truth_of_mask(disc() > 100).labels)


def test_all_places_zoom_and_move_together(dialog, hand) -> None:
    first, *others = [pane.view for pane in dialog.panes]
    first.scaleBy((0.5, 0.5))
    first.translateBy(x=3.0, y=-2.0)
    hand.qtbot.wait(10)
    for other in others:
        np.testing.assert_allclose(other.viewRect().getRect(), first.viewRect().getRect(), atol=1e-6)


def test_parameters_are_those_of_the_place_with_the_focus_and_act_at_once(ready, dialog, hand) -> None:
    run(ready, hand, dialog)
    assert not dialog.form.fields, "the particles have the parameters of the window"
    pane = dialog.panes[2]
    hand.qtbot.mouseClick(pane.picture.viewport(), LEFT, pos=QPoint(20, 20))
    assert list(dialog.form.fields) == list(CONTOUR_METHODS["gac"].settings.table())
    before, others = frames(ready)[2], [frames(ready)[place] for place in (0, 1, 3)]
    field = dialog.form.fields["balloon"]
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, "1.5")
    hand.qtbot.keyClick(field, KEY.Key_Return)
    hand.wait(lambda: frames(ready)[2] is not None and frames(ready)[2] is not before and frames(ready)[2].over)
    assert outcome(frames(ready)[2]) != outcome(before)
    assert [frames(ready)[place] for place in (0, 1, 3)] == others


def test_another_method_is_chosen_in_a_place(ready, dialog, hand) -> None:
    for pane in dialog.panes[1:]:
        pane.choice.setCurrentIndex(pane.choice.findData(""))
    dialog.panes[0].choice.setFocus()
    hand.qtbot.keyClicks(dialog.panes[0].choice, "Random")
    assert dialog.panes[0].method == "random_walker"
    run(ready, hand, dialog)
    assert [frame and frame.method for frame in frames(ready)] == ["random_walker", None, None, None]


def test_without_a_start_the_dialog_says_what_to_do(ready, dialog, hand) -> None:
    ready.session.edit("clear", edits.clear_shapes)
    hand.qtbot.mouseClick(dialog.run_button, LEFT)
    assert "draw a circle, an ellipse or a polygon" in dialog.words.text()
    assert not ready.workspace.comparison.running


def test_table_and_picture_are_exported(ready, dialog, hand, tmp_path, monkeypatch) -> None:
    run(ready, hand, dialog)
    for path in (tmp_path / "a.csv", tmp_path / "a.png"):
        monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *rest, path=path: (str(path), ""))
        hand.qtbot.mouseClick(dialog.export_button, LEFT)
        hand.wait(path.exists)
        hand.wait(lambda: ready.session.tasks.idle)
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        assert [row["method"] for row in csv.DictReader(file)] == list(FIRST)
    with PIL.Image.open(tmp_path / "a.png") as picture:
        assert picture.width > 1000


def test_closing_ends_all_runs(ready, dialog, hand) -> None:
    hand.qtbot.mouseClick(dialog.run_button, LEFT)
    hand.qtbot.keyClick(dialog, KEY.Key_Escape)
    assert ready.feature(MethodsFeature).dialog is None
    hand.wait(lambda: not [one for one in threading.enumerate() if one.name.startswith("cpm-compare-")])
    assert not ready.workspace.comparison.running
