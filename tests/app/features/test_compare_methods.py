"""The comparison of methods: each runs in its place from the drawn start, and nothing runs on after it is closed."""

from __future__ import annotations

import csv
import threading
from functools import partial

import numpy as np
import PIL.Image
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QFileDialog

from app.model.document import edits
from app.model.document.objects import objects_result
from app.session.features.side_by_side import method_run
from app.views.canvas.coordinates import image_rectangle
from app.views.features.file.open_save import OpenSaveFeature
from app.views.features.view.methods import MethodsFeature
from app.views.main_window import MainWindow
from app.views.mosaic.methods import CompareDialog
from cpm_core.contours.ground_truth import truth_of_mask
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.image.image import Image
from cpm_core.objects.methods import CONTOUR_METHODS, Compared, Start, run_method
from cpm_core.objects.methods.compared import FIRST
from cpm_core.objects.methods.level_sets.geodesic import GeodesicSettings
from cpm_core.shapes import Barrier, Stroke
from cpm_core.shapes.outlines import outlines_of
from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window

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
    hand.qtbot.mouseClick(dialog.transport.run_button, LEFT)
    hand.wait(lambda: not ready.workspace.comparison.running)


def test_each_place_shows_what_its_method_gives(ready, dialog, hand) -> None:
    assert [pane.method for pane in dialog.panes] == list(FIRST)
    run(ready, hand, dialog)
    start = Start(outlines_of(ready.session.document.shapes))
    for pane, frame in zip(dialog.panes, frames(ready), strict=True):
        assert frame.over and not frame.trouble
        assert pane.progress.text() == f"{frame.facts.steps} steps, {frame.facts.seconds:.2f} s"
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


def test_the_truth_is_drawn_in_each_place_and_named_in_the_legend(ready, dialog, hand, tmp_path) -> None:
    assert not dialog.legend.truth.isVisible()
    mask = tmp_path / "mask.png"
    PIL.Image.fromarray((disc() > 100).astype(np.uint8) * 255).save(mask)
    ready.workspace.truth.load(mask)
    hand.wait(lambda: ready.session.scene.truth is not None)
    assert [pane.truth.count for pane in dialog.panes] == [1] * 4
    assert dialog.legend.truth.isVisible()
    ready.workspace.truth.forget()
    assert all(pane.truth.empty for pane in dialog.panes)
    assert not dialog.legend.truth.isVisible()


def test_pictures_stay_as_large_whatever_is_said_of_runs(ready, dialog, hand) -> None:
    before = [pane.picture.size() for pane in dialog.panes]
    run(ready, hand, dialog)
    assert [pane.picture.size() for pane in dialog.panes] == before
    assert len({size.height() for size in before}) == 1
    for pane in dialog.panes:
        assert "contours: 1, closed: 1" in pane.words.text()
        assert pane.words.toolTip() == pane.words.text()


def test_the_method_with_the_focus_is_explained_with_its_source(dialog) -> None:
    for place, name in enumerate(FIRST):
        dialog.look_at(place)
        method = CONTOUR_METHODS[name]
        assert dialog.side.heading.text() == method.title
        assert dialog.side.about.text() == f"{method.about}\n{method.reference}"


def test_a_method_that_is_prepared_says_so_until_it_is_stopped(ready, dialog, hand, monkeypatch) -> None:
    gate = threading.Event()
    monkeypatch.setattr(method_run, "moments", lambda *rest: iter(gate.wait, True))
    hand.qtbot.mouseClick(dialog.transport.run_button, LEFT)
    assert [pane.progress.text() for pane in dialog.panes] == ["Preparing…"] * 4
    hand.qtbot.mouseClick(dialog.transport.stop_button, LEFT)
    assert [pane.progress.text() for pane in dialog.panes] == [""] * 4
    gate.set()


def test_what_is_drawn_and_takes_no_part_is_said(ready, dialog, hand) -> None:
    for shape in (Stroke(((5.0, 5.0), (9.0, 9.0))), Barrier(((1.0, 1.0), (1.0, 9.0)))):
        ready.session.edit("draw", partial(edits.add_shape, shape=shape))
    run(ready, hand, dialog)
    assert dialog.words.text() == (
        "Starts without an inside are left out, as most of the methods need one. "
        "Regions, barriers and charges are left out: the other methods have none."
    )


def test_all_places_zoom_and_move_together(dialog, hand) -> None:
    first, *others = [pane.view for pane in dialog.panes]
    first.scaleBy((0.5, 0.5))
    first.translateBy(x=3.0, y=-2.0)
    hand.qtbot.wait(10)
    for other in others:
        np.testing.assert_allclose(other.viewRect().getRect(), first.viewRect().getRect(), atol=1e-6)
    hand.qtbot.mouseDClick(dialog.panes[2].picture.viewport(), LEFT, pos=QPoint(20, 20))
    hand.qtbot.wait(10)
    for pane in dialog.panes:
        assert pane.view.viewRect().contains(image_rectangle(disc().shape))


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
    hand.qtbot.mouseClick(dialog.transport.run_button, LEFT)
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


def test_the_contours_of_each_method_are_exported(ready, dialog, hand, tmp_path, monkeypatch) -> None:
    run(ready, hand, dialog)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *rest: (str(tmp_path / "a.geojson"), ""))
    hand.qtbot.mouseClick(dialog.export_button, LEFT)
    hand.wait(lambda: ready.session.tasks.idle)
    assert {path.name for path in tmp_path.glob("a.*")} == {f"a.{name}.geojson" for name in FIRST}


def test_runs_are_held_led_on_by_steps_and_let_go(ready, dialog, hand) -> None:
    comparison = ready.workspace.comparison

    def steps() -> list:
        return [frame and frame.step for frame in frames(ready)]

    transport = dialog.transport
    assert not transport.pause_button.isEnabled()
    hand.qtbot.mouseClick(transport.step_button, LEFT)
    hand.wait(lambda: steps() == [0, 0, 0, 0])
    for count in (1, 2, 3):
        hand.qtbot.mouseClick(transport.step_button, LEFT)
        hand.wait(lambda count=count: steps() == [count] * 4)
    assert comparison.running and comparison.held and transport.pause_button.text() == "Resume"
    assert dialog.panes[1].progress.text().startswith("3 steps, ")
    hand.qtbot.mouseClick(transport.pause_button, LEFT)
    assert transport.pause_button.text() == "Pause"
    hand.wait(lambda: not comparison.running)
    assert all(frame.over for frame in frames(ready))
    held = [outcome(frame) for frame in frames(ready)]
    run(ready, hand, dialog)
    assert [outcome(frame) for frame in frames(ready)] == held, "a run that was held goes where others go"


def test_a_run_that_is_held_shows_where_it_waits(ready, dialog, hand, monkeypatch) -> None:
    monkeypatch.setattr(method_run, "_LEAST_PAUSE", 1e9)  # no state is shown but the first and the last
    step = partial(hand.qtbot.mouseClick, dialog.transport.step_button, LEFT)
    for count in range(4):
        step()
        hand.wait(lambda count=count: [frame and frame.step for frame in frames(ready)] == [count] * 4)


def test_all_methods_are_looked_back_on_together(ready, dialog, hand) -> None:
    run(ready, hand, dialog)
    last = [pane.words.text() for pane in dialog.panes]
    slider = dialog.transport.slider
    slider.setFocus()
    hand.qtbot.keyClick(slider, KEY.Key_Home)
    assert all(pane.progress.text().startswith("0 steps, ") for pane in dialog.panes)
    for _ in range(10):
        hand.qtbot.keyClick(slider, KEY.Key_PageUp)
    assert dialog.transport.words.text() == "50 % of the steps"
    for pane, frame in zip(dialog.panes, frames(ready), strict=True):
        assert 0 <= int(pane.progress.text().split()[0]) <= 0.5 * frame.step
    hand.qtbot.keyClick(slider, KEY.Key_End)
    assert [pane.words.text() for pane in dialog.panes] == last


def test_what_a_method_has_found_is_kept_as_an_object_and_exported_with_the_usual_exports(ready, dialog, hand) -> None:
    run(ready, hand, dialog)
    dialog.look_at(2)
    hand.qtbot.mouseClick(dialog.keep_button, LEFT)
    (item,) = ready.session.document.objects.items
    assert item.name == "Geodesic active contour"
    assert (item.mask(disc().shape) == (disc() > 100)).mean() > 0.97
    result = objects_result(ready.session.document)
    assert [contour.closed for contour in result.contours] == [True]
    ready.session.undo()
    assert not ready.session.document.objects.items


def test_a_session_keeps_the_comparison_and_undo_takes_a_change_back(ready, dialog, hand, tmp_path) -> None:
    dialog.panes[3].choice.setFocus()
    hand.qtbot.keyClicks(dialog.panes[3].choice, "Morphological GAC")
    hand.qtbot.mouseClick(dialog.panes[2].picture.viewport(), LEFT, pos=QPoint(20, 20))
    field = dialog.form.fields["balloon"]
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, "1.5")
    hand.qtbot.keyClick(field, KEY.Key_Return)
    hand.qtbot.mouseClick(dialog.around, LEFT, pos=QPoint(8, dialog.around.height() // 2))
    methods = (*FIRST[:3], "morph_gac")
    expected = Compared(methods, (("gac", GeodesicSettings(balloon=1.5)),), around=True)
    assert ready.session.document.comparison == expected
    file = ready.feature(OpenSaveFeature).document_file
    assert file.unsaved
    assert file.save_at_once(tmp_path / "a.cpm")
    assert load_session(tmp_path / "a.cpm").comparison == expected
    hand.qtbot.keyClick(dialog, KEY.Key_Escape)
    ready.open_image(str(tmp_path / "a.cpm"))
    hand.wait(lambda: ready.session.tasks.idle and ready.session.scene.display is not None)
    assert ready.session.document.comparison == expected
    ready.feature(MethodsFeature).open()
    again = ready.feature(MethodsFeature).dialog
    assert [pane.method for pane in again.panes] == list(methods) and again.around.isChecked()
    again.look_at(2)
    assert again.form.fields["balloon"].value() == 1.5
    hand.qtbot.mouseClick(again.around, LEFT, pos=QPoint(8, again.around.height() // 2))
    ready.session.undo()
    assert again.around.isChecked()


def test_the_start_that_is_shown_is_the_one_that_is_drawn_now(ready, dialog) -> None:
    assert not any(pane.start.empty for pane in dialog.panes)
    ready.session.edit("clear", edits.clear_shapes)
    assert all(pane.start.empty for pane in dialog.panes)


def test_closing_ends_all_runs(ready, dialog, hand) -> None:
    hand.qtbot.mouseClick(dialog.transport.run_button, LEFT)
    hand.qtbot.keyClick(dialog, KEY.Key_Escape)
    assert ready.feature(MethodsFeature).dialog is None
    hand.wait(lambda: not [one for one in threading.enumerate() if one.name.startswith("cpm-compare-")])
    assert not ready.workspace.comparison.running
