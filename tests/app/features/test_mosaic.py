"""The mosaic: each tile is a separate run, one of them is chosen, and no run continues after cancellation."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from app.model.display.mosaic import FIRST_AXES, Axis, in_text, pick, plan, read_values, sensible_values
from app.model.document import edits
from app.model.document.document import Document
from app.model.document.modes import acting_in
from app.model.parameters.controls import controls, slider_range, value_of
from app.views.features.view.mosaic import MosaicFeature
from app.views.main_window import MainWindow
from app.views.mosaic import MosaicDialog
from app.views.mosaic.tile import EnlargedTile
from cpm_core import PRESETS, Engine, Parameters, segment
from cpm_core.model.starts import circle
from cpm_core.shapes import Charge
from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton
CONTROLS = {control.name: control for control in controls()}
OFFERED = [control.name for control in controls() if control.name in acting_in("shape")]


@pytest.fixture
def dialog(ready: MainWindow, hand: Hand) -> MosaicDialog:
    """The dialog, opened by its key, with two values each."""
    hand.key(KEY.Key_M, Qt.KeyboardModifier.ControlModifier)
    made = ready.feature(MosaicFeature).dialog
    assert made is not None
    hand.qtbot.waitExposed(made)
    assert (made.down.control.name, made.across.control.name) == FIRST_AXES
    for row, name in ((made.down, "beta"), (made.across, "ratio")):
        row.choice.setCurrentIndex(OFFERED.index(name))
    made.down.values.setText("0.6, 0.9")
    made.across.values.setText("0.7; 0.9")
    return made


def run(hand: Hand, dialog: MosaicDialog) -> None:
    """Run the mosaic to its end."""
    hand.qtbot.mouseClick(dialog.start_button, LEFT)
    hand.wait(lambda: bool(dialog.tiles) and all(view.done for view in dialog.tiles.values()))
    hand.wait(lambda: not dialog.cancel_button.isEnabled())


def mosaic_threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith(("cpm-mosaic", "cpm-task"))]


def test_each_tile_is_what_a_run_with_its_values_gives(ready, dialog, hand) -> None:
    run(hand, dialog)
    assert len(dialog.tiles) == 4
    view = dialog.tiles[0, 1]
    assert view.caption == "β = 0.6, w₁/w₂ = 0.9"
    parameters = replace(PRESETS["shape"], beta=0.6, w1=0.9 * 1.75, scales=ready.session.document.parameters.scales)
    alone = segment(disc(), circle((32.0, 32.0), radius=10.0, spacing=2.0), parameters)
    assert view.done.result.steps == alone.steps
    np.testing.assert_array_equal(view.done.result.particles, alone.particles)
    assert view.state == f"1 contour, {alone.steps} steps"
    assert not ready.session.status.started, "the run of the window is left alone"


def test_placed_charges_act_in_every_tile(ready, dialog, hand) -> None:
    session = ready.session
    charge = Charge((32.0, 50.0), 5.0)
    session.edit("place", lambda document: edits.add_shape(document, charge))
    run(hand, dialog)
    done = dialog.tiles[0, 1].done
    parameters = done.tile.parameters
    engine = Engine(disc(), parameters)
    state = engine.start(circle((32.0, 32.0), radius=10.0, spacing=2.0))
    while not state.stop_reason:
        state = engine.step(state, parameters, session.document.charges)
    np.testing.assert_array_equal(done.result.particles, state.position)
    without = segment(disc(), circle((32.0, 32.0), radius=10.0, spacing=2.0), parameters)
    assert not np.array_equal(done.result.particles, without.particles)


def test_a_click_sets_both_values_in_one_undoable_change(ready, dialog, hand) -> None:
    before = ready.session.document
    run(hand, dialog)
    hand.qtbot.mouseClick(dialog.tiles[1, 0], LEFT)
    parameters = ready.session.document.parameters
    assert (parameters.beta, parameters.w1 / parameters.w2) == (0.9, pytest.approx(0.7))
    assert ready.session.situation.undo_name == "use β = 0.9, w₁/w₂ = 0.7"
    assert [view.chosen for view in dialog.tiles.values()] == [False, False, True, False]
    ready.session.undo()
    assert ready.session.document == before
    assert not any(view.chosen for view in dialog.tiles.values())


def test_tiles_are_selected_enlarged_and_chosen_by_keys(ready, dialog, hand) -> None:
    run(hand, dialog)
    tiles = dialog.tiles
    assert dialog.focusWidget() is tiles[0, 0]
    hand.qtbot.keyClick(tiles[0, 0], KEY.Key_Right)
    hand.qtbot.keyClick(tiles[0, 1], KEY.Key_Down)
    assert dialog.focusWidget() is tiles[1, 1]
    hand.qtbot.keyClick(tiles[1, 1], KEY.Key_Space)
    large = dialog.findChild(EnlargedTile)
    assert large.windowTitle() == "β = 0.9, w₁/w₂ = 0.9"
    hand.qtbot.keyClick(large, KEY.Key_Escape)
    scales = ready.session.document.parameters.scales
    assert ready.session.document.parameters == replace(PRESETS["shape"], scales=scales)
    hand.qtbot.keyClick(tiles[1, 1], KEY.Key_Return)
    assert ready.session.document.parameters.beta == 0.9


def test_an_enlarged_tile_can_be_chosen(ready, dialog, hand) -> None:
    run(hand, dialog)
    hand.qtbot.keyClick(dialog.tiles[0, 0], KEY.Key_Space)
    hand.qtbot.mouseClick(dialog.findChild(EnlargedTile).take, LEFT)
    assert ready.session.document.parameters.beta == 0.6


def test_cancel_stops_all_runs_and_keeps_finished_tiles(ready, dialog, hand, monkeypatch) -> None:
    step, going, held = Engine.step, threading.Event(), threading.Event()

    def slow(engine, state, parameters, *rest):
        going.set()
        held.wait(0.05)
        return step(engine, state, parameters, *rest)

    monkeypatch.setattr(Engine, "step", slow)
    hand.qtbot.mouseClick(dialog.start_button, LEFT)
    hand.wait(going.is_set)
    assert dialog.bar.isVisible()
    hand.qtbot.mouseClick(dialog.cancel_button, LEFT)
    assert not dialog.cancel_button.isEnabled()
    assert "Canceled" in dialog.words.text()
    assert {view.state for view in dialog.tiles.values()} == {"canceled"}
    hand.wait(lambda: not mosaic_threads())


@pytest.mark.parametrize("way", ["escape", "window"])
def test_closing_leaves_no_thread(ready, dialog, hand, monkeypatch, way) -> None:
    step, going = Engine.step, threading.Event()

    def noted(engine, state, parameters, *rest):
        going.set()
        return step(engine, state, parameters, *rest)

    monkeypatch.setattr(Engine, "step", noted)
    hand.qtbot.mouseClick(dialog.start_button, LEFT)
    hand.wait(going.is_set)
    if way == "escape":
        hand.qtbot.keyClick(dialog, KEY.Key_Escape)
        assert ready.feature(MosaicFeature).dialog is None
        hand.wait(lambda: not mosaic_threads())
    else:
        ready.close()
        assert not mosaic_threads()


def test_invalid_values_are_rejected_with_a_message(dialog, hand) -> None:
    for text, expected in (("0.5, often", "often"), ("0.5", "from 2 to 6"), ("0.5, 99", "99")):
        dialog.down.values.setText(text)
        hand.qtbot.mouseClick(dialog.start_button, LEFT)
        assert expected in dialog.words.text()
        assert not dialog.tiles
    dialog.down.choice.setCurrentIndex(dialog.across.choice.currentIndex())
    hand.qtbot.mouseClick(dialog.start_button, LEFT)
    assert "choose two different ones" in dialog.words.text()


def test_without_an_initialization_the_mosaic_asks_for_one(window, hand) -> None:
    hand.key(KEY.Key_M, Qt.KeyboardModifier.ControlModifier)
    dialog = window.feature(MosaicFeature).dialog
    hand.qtbot.mouseClick(dialog.start_button, LEFT)
    assert "nothing to start from" in dialog.words.text()


def test_a_new_number_of_values_or_parameter_suggests_new_values(dialog) -> None:
    dialog.count.setCurrentIndex(2)
    assert len(read_values(dialog.down.control, dialog.down.values.text())) == 5
    dialog.down.choice.setCurrentIndex(OFFERED.index("scales"))
    assert all(value == int(value) for value in read_values(dialog.down.control, dialog.down.values.text()))


def test_with_a_ground_truth_each_tile_shows_its_overlap(ready, dialog, hand, tmp_path) -> None:
    path = tmp_path / "mask.npy"
    np.save(path, (disc() > 100).astype(np.uint8))
    truth = ready.workspace.truth
    truth.load(path)
    hand.wait(lambda: truth.truth is not None)
    run(hand, dialog)
    for view in dialog.tiles.values():
        assert view.done.dice > 0.97
        assert view.state.endswith(f"Dice {view.done.dice:.4f}")


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(sorted(CONTROLS)), st.integers(3, 5), st.floats(0, 1), st.floats(1, 255))
def test_suggested_values_are_in_range_ascending_and_include_the_present_one(name, count, share, contrast) -> None:
    control = CONTROLS[name]
    low, high = slider_range(control, contrast)
    present = low + share * (high - low)
    parameters = Parameters()
    if name not in ("w1", "w2", "ratio", "smoothing", "scales"):
        parameters = Parameters(**{name: present})
    values = sensible_values(control, parameters, contrast, count)
    assert len(values) == len(set(values)) <= count
    assert list(values) == sorted(values)
    assert all(low - 1e-9 <= value <= high + 1e-9 for value in values)
    now = value_of(parameters, name)
    if isinstance(now, float | int) and low <= now <= high:
        assert min(abs(value - now) for value in values) < 1e-9
    if len(values) >= 2:
        assert read_values(control, in_text(values)) == pytest.approx(values, rel=6e-3, abs=1e-6)


def test_suggested_values_are_shown_with_three_digits_and_used_with_all(ready, dialog) -> None:
    parameters = Parameters(w1=1.5, scales=ready.session.document.parameters.scales)
    dialog.across.suggest(parameters, 255.0, 3)
    words = dialog.across.values.text().split(", ")
    assert "0.857" in words
    assert all(len(word.replace(".", "").lstrip("0")) <= 3 for word in words)
    assert 1.5 / 1.75 in dialog.across.axis().values


def test_a_plan_has_a_tile_for_each_pair_and_picking_changes_these_two_alone() -> None:
    made = plan(Parameters(), Axis(CONTROLS["beta"], (0.5, 1.0)), Axis(CONTROLS["w2"], (1.0, 2.0, 3.0)))
    assert [(tile.row, tile.col) for tile in made.tiles] == [(r, c) for r in range(2) for c in range(3)]
    document = Document(parameters=Parameters(max_gap=7.0))
    picked = pick(document, made, made.tiles[5]).parameters
    assert (picked.beta, picked.w2, picked.max_gap) == (1.0, 3.0, 7.0)
    assert picked.w1 / picked.w2 == pytest.approx(1.6 / 1.75)
