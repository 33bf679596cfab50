"""Runs to compare: each is a run of its own, one is taken over, and no run continues after cancellation."""

from __future__ import annotations

import csv
import threading
from dataclasses import replace

import numpy as np
import PIL.Image
import pytest
from cpm_app.model.document.modes import find_effective_controls
from cpm_app.model.document.objects import build_objects_result
from cpm_app.model.parameters.controls import build_controls
from cpm_app.session.features.comparison import CURRENT_KEY, ComparisonRow
from cpm_app.views.comparison.panel import ComparePanel
from cpm_app.views.features.compare import CompareFeature
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QFileDialog, QPushButton

from cpm_core import PRESETS, Engine, segment
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.methods import CONTOUR_METHODS, MethodComparison
from cpm_core.methods.comparison import DEFAULT_METHODS
from cpm_core.model.starts import circle
from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton
OFFERED = [control.name for control in build_controls() if control.name in find_effective_controls("shape")]


def opened(window: MainWindow, hand: Hand, entry: str) -> ComparePanel:
    """The panel, opened by its key, after an entry of its button Add."""
    hand.canvas.setFocus()
    hand.key(KEY.Key_D, Qt.KeyboardModifier.ControlModifier)
    panel = window.get_feature(CompareFeature).panel
    hand.wait(panel.isVisible)
    menu = panel.add.menu()
    menu.aboutToShow.emit()
    next(action for action in menu.actions() if action.text().replace("&", "") == entry).trigger()
    return panel


@pytest.fixture
def values(ready: MainWindow, hand: Hand) -> ComparePanel:
    """The panel with two values of two parameters each."""
    panel = opened(ready, hand, "Parameter values…")
    down, across = panel.values.down, panel.values.across
    for row, name in ((down, "beta"), (across, "ratio")):
        row.choice.setCurrentIndex(OFFERED.index(name))
    down.values.setText("0.6, 0.9")
    across.values.setText("0.7; 0.9")
    return panel


@pytest.fixture
def methods(ready: MainWindow, hand: Hand) -> ComparePanel:
    """The panel with the choice of methods."""
    return opened(ready, hand, "Methods…")


def start(hand: Hand, panel: ComparePanel) -> None:
    page = panel.pages.currentWidget()
    hand.qtbot.mouseClick(next(b for b in page.findChildren(QPushButton) if b.text() == "Run"), LEFT)


def rows(window: MainWindow) -> list[ComparisonRow]:
    return [row for row in window.workspace.comparison.rows.values() if row.key != CURRENT_KEY]


def run(window: MainWindow, hand: Hand, panel: ComparePanel) -> None:
    start(hand, panel)
    hand.wait(lambda: window.workspace.comparison.task is None and all(row.found for row in rows(window)))


def choose(window: MainWindow, hand: Hand, title: str) -> None:
    table = window.get_feature(CompareFeature).panel.table
    place = table.visualRect(table.model().index(table.column_texts("name").index(title), 0)).center()
    hand.qtbot.mouseClick(table.viewport(), LEFT, pos=place)


def comparing_threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith(("cpm-compare", "cpm-task"))]


def type_into(hand: Hand, field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, text)
    hand.qtbot.keyClick(field, KEY.Key_Return)


def test_each_row_is_what_a_run_with_its_values_gives(ready, values, hand) -> None:
    run(ready, hand, values)
    titles = ["β 0.6, w₁/w₂ 0.7", "β 0.6, w₁/w₂ 0.9", "β 0.9, w₁/w₂ 0.7", "β 0.9, w₁/w₂ 0.9"]
    assert values.table.column_texts("name") == ["Shown now", *titles]
    chosen = replace(PRESETS["shape"], beta=0.6, w1=0.9 * 1.75, scales=ready.session.document.parameters.scales)
    alone = segment(disc(), circle((32.0, 32.0), radius=10.0, spacing=2.0), chosen)
    np.testing.assert_array_equal(rows(ready)[1].found.particles, alone.particles)
    assert values.table.column_texts("count")[2] == "1"
    assert not ready.session.status.started, "the run of the window is left alone"


def test_using_a_row_sets_both_values_in_one_undoable_change(ready, values, hand) -> None:
    before = ready.session.document
    run(ready, hand, values)
    choose(ready, hand, "β 0.9, w₁/w₂ 0.7")
    assert ready.session.document == before
    hand.key(KEY.Key_Return)
    chosen = ready.session.document.parameters
    assert (chosen.beta, chosen.w1 / chosen.w2) == (0.9, pytest.approx(0.7))
    assert ready.session.situation.undo_name == "use β 0.9, w₁/w₂ 0.7"
    ready.session.undo()
    assert ready.session.document == before


def test_cancel_stops_all_runs_and_removes_their_rows(ready, values, hand, monkeypatch) -> None:
    step, going, held = Engine.step, threading.Event(), threading.Event()

    def slow(engine, state, chosen, *rest):
        going.set()
        held.wait(0.05)
        return step(engine, state, chosen, *rest)

    monkeypatch.setattr(Engine, "step", slow)
    start(hand, values)
    hand.wait(going.is_set)
    assert len(rows(ready)) == 4
    hand.key(KEY.Key_Period, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: rows(ready) == [])
    hand.wait(lambda: not comparing_threads())


def test_values_that_are_no_numbers_are_named_where_they_are_typed(ready, values, hand) -> None:
    values.values.down.values.setText("0.6, many")
    start(hand, values)
    said = [label.text() for label in values.pages.currentWidget().findChildren(type(values.summary))]
    assert any("“many” is not a number" in text for text in said)
    assert rows(ready) == []


def test_methods_are_measured_by_a_truth_and_exported(ready, methods, hand, tmp_path, monkeypatch) -> None:
    PIL.Image.fromarray((disc() > 100).astype(np.uint8) * 255).save(tmp_path / "mask.png")
    compared = ready.workspace.comparison
    compared.load_truth_file(tmp_path / "mask.png")
    hand.wait(lambda: ready.session.scene.truth is not None)
    run(ready, hand, methods)
    hand.wait(lambda: len(compared.agreements) == len(DEFAULT_METHODS))
    figures = dict(zip(methods.table.column_texts("name"), methods.table.column_texts("dice"), strict=True))
    for row in rows(ready):
        if row.trial is not None:
            assert figures[row.title] == f"{compared.agreements[row.key].dice:.3f}"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "a.csv"), ""))
    hand.qtbot.mouseClick(methods.export, LEFT)
    hand.wait(lambda: ready.session.tasks.idle)
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        written = {row["name"]: row["dice"] for row in csv.DictReader(file)}
    assert written.keys() == figures.keys()
    assert all(float(written[row.title]) == compared.agreements[row.key].dice for row in rows(ready) if row.trial)


def test_what_a_method_has_found_becomes_an_object(ready, methods, hand) -> None:
    run(ready, hand, methods)
    choose(ready, hand, "Geodesic active contour")
    methods.acts["use"].trigger()
    hand.wait(lambda: bool(ready.session.document.objects.items))
    (item,) = ready.session.document.objects.items
    assert item.name == "Geodesic active contour"
    assert (item.mask(disc().shape) == (disc() > 100)).mean() > 0.97
    assert [contour.closed for contour in build_objects_result(ready.session.document).contours] == [True]
    ready.session.undo()
    assert not ready.session.document.objects.items


def test_a_session_keeps_the_methods_and_undo_takes_a_change_back(ready, methods, hand, tmp_path) -> None:
    names = list(CONTOUR_METHODS)
    choice = methods.methods
    choice.list.item(names.index("chan_vese")).setCheckState(Qt.CheckState.Unchecked)
    choice.list.item(names.index("morph_gac")).setCheckState(Qt.CheckState.Checked)
    choice.list.setCurrentRow(list(CONTOUR_METHODS).index("geodesic"))
    type_into(hand, choice.fields["balloon"], "1.5")
    hand.qtbot.mouseClick(choice.around, LEFT, pos=QPoint(8, choice.around.height() // 2))
    compared = ready.session.document.comparison
    assert set(compared.methods) == {"cpm", "gvf", "geodesic", "morph_gac"}
    own = CONTOUR_METHODS["geodesic"].settings(balloon=1.5)
    assert compared == MethodComparison(compared.methods, (("geodesic", own),), around=True)
    file = ready.get_feature(OpenSaveFeature).document_file
    assert file.unsaved
    assert file.save_and_wait(tmp_path / "a.cpm")
    assert load_session(tmp_path / "a.cpm").comparison == compared
    ready.session.undo()
    assert not choice.around.isChecked()
    ready.open_image(str(tmp_path / "a.cpm"))
    hand.wait(lambda: ready.session.tasks.idle and ready.session.document.comparison == compared)
    assert choice.around.isChecked()
    assert choice.list.item(names.index("morph_gac")).checkState() == Qt.CheckState.Checked
    choice.list.setCurrentRow(list(CONTOUR_METHODS).index("geodesic"))
    assert choice.fields["balloon"].value() == 1.5
