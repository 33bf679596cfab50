"""Results to compare: they are measured by a truth, exported, and taken over as objects."""

from __future__ import annotations

import csv

import numpy as np
import PIL.Image
import pytest
from cpm_app.model.document.objects import build_objects_result
from cpm_app.session.features.comparison import CURRENT_KEY, ComparisonRow
from cpm_app.views.comparison.panel import ComparePanel
from cpm_app.views.features.compare import CompareFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def panel(ready: MainWindow, hand: Hand) -> ComparePanel:
    """The panel, opened by its key, of a window with a finished run whose result has been kept by mouse."""
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.scene.result is not None and ready.session.idle)
    hand.key(Qt.Key.Key_D, Qt.KeyboardModifier.ControlModifier)
    panel = ready.get_feature(CompareFeature).panel
    hand.wait(panel.isVisible)
    hand.qtbot.mouseClick(panel.keep, LEFT)
    return panel


def kept_row(window: MainWindow) -> ComparisonRow:
    return next(row for row in window.workspace.comparison.rows.values() if row.title.startswith("Kept"))


def test_results_are_measured_by_a_truth_and_exported(ready, panel, hand, tmp_path, monkeypatch) -> None:
    PIL.Image.fromarray((disc() > 100).astype(np.uint8) * 255).save(tmp_path / "mask.png")
    compared = ready.workspace.comparison
    compared.load_truth_file(tmp_path / "mask.png")
    hand.wait(lambda: compared.agreements.keys() == {CURRENT_KEY, kept_row(ready).key})
    figures = dict(zip(panel.table.column_texts("name"), panel.table.column_texts("dice"), strict=True))
    assert figures.keys() == {"Shown now", kept_row(ready).title, "mask.png"}
    for key, agreed in compared.agreements.items():
        assert figures[compared.rows[key].title] == f"{agreed.dice:.3f}"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "a.csv"), ""))
    hand.qtbot.mouseClick(panel.export, LEFT)
    hand.wait(lambda: ready.session.tasks.idle)
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        written = {row["name"]: row["dice"] for row in csv.DictReader(file)}
    assert written.keys() == figures.keys()
    for key, agreed in compared.agreements.items():
        assert float(written[compared.rows[key].title]) == agreed.dice


def test_a_kept_result_becomes_an_object(ready, panel, hand) -> None:
    table, row = panel.table, kept_row(ready)
    place = table.visualRect(table.model().index(table.column_texts("name").index(row.title), 0)).center()
    hand.qtbot.mouseClick(table.viewport(), LEFT, pos=place)
    assert ready.workspace.comparison.selected == row.key
    panel.acts["use"].trigger()
    hand.wait(lambda: bool(ready.session.document.objects.items))
    (item,) = ready.session.document.objects.items
    assert (item.region.paste(disc().shape) == (disc() > 100)).mean() > 0.97
    assert [contour.closed for contour in build_objects_result(ready.session.document).contours] == [True]
    ready.session.undo()
    assert not ready.session.document.objects.items
