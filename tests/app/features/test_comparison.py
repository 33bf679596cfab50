"""The comparison: each tile is a separate run, one is taken over, and no run continues after cancellation."""

from __future__ import annotations

import csv
import threading
from dataclasses import replace

import numpy as np
import PIL.Image
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QFileDialog

from app.model.display.comparison import (
    FIRST_AXES,
)
from app.model.document.modes import acting_in
from app.model.document.objects import objects_result
from app.model.parameters.controls import controls
from app.views.comparison.dialog import CompareDialog
from app.views.features.files import OpenSaveFeature
from app.views.features.run import ComparisonFeature
from app.views.window.window import MainWindow
from cpm_core import PRESETS, Engine, segment
from cpm_core.contours.ground_truth import truth_of_mask
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.model.starts import circle
from cpm_core.objects.methods import CONTOUR_METHODS, Compared
from cpm_core.objects.methods.comparison import FIRST
from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton
OFFERED = [control.name for control in controls() if control.name in acting_in("shape")]


def opened(window: MainWindow, hand: Hand, *modifiers: Qt.KeyboardModifier) -> CompareDialog:
    keys = Qt.KeyboardModifier.ControlModifier
    for modifier in modifiers:
        keys |= modifier
    hand.key(KEY.Key_M, keys)
    made = window.feature(ComparisonFeature).dialog.shown
    assert made is not None
    hand.qtbot.waitExposed(made)
    return made


@pytest.fixture
def parameters(ready: MainWindow, hand: Hand) -> CompareDialog:
    """The dialog, opened by its key, with two values of two parameters each."""
    made = opened(ready, hand)
    assert made.choices.currentWidget() is made.parameters
    down, across = made.parameters.down, made.parameters.across
    assert (down.control.name, across.control.name) == FIRST_AXES
    for row, name in ((down, "beta"), (across, "ratio")):
        row.choice.setCurrentIndex(OFFERED.index(name))
    down.values.setText("0.6, 0.9")
    across.values.setText("0.7; 0.9")
    return made


@pytest.fixture
def methods(ready: MainWindow, hand: Hand) -> CompareDialog:
    """The dialog, opened by the keys for methods."""
    made = opened(ready, hand, Qt.KeyboardModifier.ShiftModifier)
    assert made.choices.currentWidget() is made.methods
    return made


def run(hand: Hand, dialog: CompareDialog) -> None:
    hand.qtbot.mouseClick(dialog.start_button, LEFT)
    hand.wait(lambda: bool(dialog.board.tiles) and all(view.done for view in dialog.board.tiles))
    hand.wait(lambda: not dialog.cancel_button.isEnabled())


def comparing_threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith(("cpm-compare", "cpm-task"))]


def type_into(hand: Hand, field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, text)
    hand.qtbot.keyClick(field, KEY.Key_Return)


def load_truth(ready: MainWindow, hand: Hand, path) -> None:
    PIL.Image.fromarray((disc() > 100).astype(np.uint8) * 255).save(path)
    ready.workspace.truth.load(path)
    hand.wait(lambda: ready.session.scene.truth is not None)


def test_each_tile_is_what_a_run_with_its_values_gives(ready, parameters, hand) -> None:
    run(hand, parameters)
    tiles = parameters.board.tiles
    assert [(view.tile.row, view.tile.col) for view in tiles] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    view = tiles[1]
    assert view.tile.caption == "β = 0.6, w₁/w₂ = 0.9"
    chosen = replace(PRESETS["shape"], beta=0.6, w1=0.9 * 1.75, scales=ready.session.document.parameters.scales)
    alone = segment(disc(), circle((32.0, 32.0), radius=10.0, spacing=2.0), chosen)
    assert view.done.result.steps == alone.steps
    np.testing.assert_array_equal(view.done.result.particles, alone.particles)
    assert view.state == f"1 contour, {alone.steps} steps"
    assert not ready.session.status.started, "the run of the window is left alone"


def test_taking_a_tile_sets_both_values_in_one_undoable_change(ready, parameters, hand) -> None:
    before = ready.session.document
    run(hand, parameters)
    hand.qtbot.mouseClick(parameters.board.tiles[2], LEFT)
    assert ready.session.document == before
    hand.qtbot.mouseClick(parameters.take_button, LEFT)
    chosen = ready.session.document.parameters
    assert (chosen.beta, chosen.w1 / chosen.w2) == (0.9, pytest.approx(0.7))
    assert ready.session.situation.undo_name == "use β = 0.9, w₁/w₂ = 0.7"
    ready.session.undo()
    assert ready.session.document == before


def test_tiles_are_selected_and_taken_by_keys(ready, parameters, hand) -> None:
    run(hand, parameters)
    board = parameters.board
    assert parameters.focusWidget() is board.tiles[0] is board.current
    hand.qtbot.keyClick(board.tiles[0], KEY.Key_Right)
    hand.qtbot.keyClick(parameters.focusWidget(), KEY.Key_Down)
    assert parameters.focusWidget() is board.tiles[3]
    hand.qtbot.keyClick(board.tiles[3], KEY.Key_Space)
    assert board.current is board.tiles[3]
    hand.qtbot.keyClick(board.tiles[3], KEY.Key_Return)
    assert ready.session.document.parameters.beta == 0.9


def test_cancel_stops_all_runs(ready, parameters, hand, monkeypatch) -> None:
    step, going, held = Engine.step, threading.Event(), threading.Event()

    def slow(engine, state, chosen, *rest):
        going.set()
        held.wait(0.05)
        return step(engine, state, chosen, *rest)

    monkeypatch.setattr(Engine, "step", slow)
    hand.qtbot.mouseClick(parameters.start_button, LEFT)
    hand.wait(going.is_set)
    assert parameters.bar.isVisible()
    hand.qtbot.mouseClick(parameters.cancel_button, LEFT)
    assert not parameters.cancel_button.isEnabled()
    assert "Canceled" in parameters.words.text()
    assert {view.state for view in parameters.board.tiles} == {"canceled"}
    hand.wait(lambda: not comparing_threads())


def test_closing_leaves_no_thread(ready, parameters, hand, monkeypatch) -> None:
    step, going = Engine.step, threading.Event()

    def noted(engine, state, chosen, *rest):
        going.set()
        return step(engine, state, chosen, *rest)

    monkeypatch.setattr(Engine, "step", noted)
    hand.qtbot.mouseClick(parameters.start_button, LEFT)
    hand.wait(going.is_set)
    hand.qtbot.keyClick(parameters, KEY.Key_Escape)
    assert ready.feature(ComparisonFeature).dialog.shown is None
    hand.wait(lambda: not comparing_threads())


def test_figures_of_methods_are_shown_where_a_truth_is_loaded(ready, methods, hand, tmp_path) -> None:
    load_truth(ready, hand, tmp_path / "mask.png")
    run(hand, methods)
    for view in methods.board.tiles:
        assert view.state.endswith(f"Dice {view.done.facts.dice:.4f}")
        assert f"F: {view.done.facts.f:.3f}" in view.toolTip()
    assert np.array_equal(ready.session.scene.truth.labels, truth_of_mask(disc() > 100).labels)


def test_table_picture_and_contours_are_exported(ready, methods, hand, tmp_path, monkeypatch) -> None:
    run(hand, methods)
    for path in (tmp_path / "a.csv", tmp_path / "a.png", tmp_path / "a.geojson"):
        monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *rest, path=path: (str(path), ""))
        hand.qtbot.mouseClick(methods.export_button, LEFT)
        hand.wait(lambda: ready.session.tasks.idle)
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        assert {row["method"] for row in csv.DictReader(file)} == set(FIRST)
    with PIL.Image.open(tmp_path / "a.png") as picture:
        assert picture.width > 1000
    assert {path.name for path in tmp_path.glob("a.*.geojson")} == {f"a.{name}.geojson" for name in FIRST}


def test_what_a_method_has_found_is_kept_as_an_object(ready, methods, hand) -> None:
    run(hand, methods)
    next(view for view in methods.board.tiles if view.tile.method == "geodesic").click()
    hand.qtbot.mouseClick(methods.take_button, LEFT)
    (item,) = ready.session.document.objects.items
    assert item.name == "Geodesic active contour"
    assert (item.mask(disc().shape) == (disc() > 100)).mean() > 0.97
    result = objects_result(ready.session.document)
    assert [contour.closed for contour in result.contours] == [True]
    ready.session.undo()
    assert not ready.session.document.objects.items


def test_a_session_keeps_the_comparison_and_undo_takes_a_change_back(ready, methods, hand, tmp_path) -> None:
    names = list(CONTOUR_METHODS)
    choice = methods.methods
    choice.list.item(names.index("chan_vese")).setCheckState(Qt.CheckState.Unchecked)
    choice.list.item(names.index("morph_gac")).setCheckState(Qt.CheckState.Checked)
    choice.mark("geodesic")
    type_into(hand, choice.fields["balloon"], "1.5")
    hand.qtbot.mouseClick(choice.around, LEFT, pos=QPoint(8, choice.around.height() // 2))
    compared = ready.session.document.comparison
    assert set(compared.methods) == {"cpm", "gvf", "geodesic", "morph_gac"}
    own = CONTOUR_METHODS["geodesic"].settings(balloon=1.5)
    assert compared == Compared(compared.methods, (("geodesic", own),), around=True)
    file = ready.feature(OpenSaveFeature).document_file
    assert file.unsaved
    assert file.save_at_once(tmp_path / "a.cpm")
    assert load_session(tmp_path / "a.cpm").comparison == compared
    hand.qtbot.keyClick(methods, KEY.Key_Escape)
    ready.open_image(str(tmp_path / "a.cpm"))
    hand.wait(lambda: ready.session.tasks.idle and ready.session.scene.display is not None)
    assert ready.session.document.comparison == compared
    again = opened(ready, hand, Qt.KeyboardModifier.ShiftModifier).methods
    assert again.around.isChecked()
    assert again.list.item(names.index("morph_gac")).checkState() == Qt.CheckState.Checked
    again.mark("geodesic")
    assert again.fields["balloon"].value() == 1.5
    hand.qtbot.mouseClick(again.around, LEFT, pos=QPoint(8, again.around.height() // 2))
    ready.session.undo()
    assert again.around.isChecked()
