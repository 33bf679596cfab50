"""Results are measured by a truth, exported, and selected by mouse."""

from __future__ import annotations

import csv

import numpy as np
import PIL.Image
import pytest
from cpm_app.session.features.comparison import CURRENT_KEY, TRUTH_KEY
from cpm_app.views.features.compare import CompareFeature
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from tests.app.conftest import disc
from tests.app.reading import column_texts

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton


def test_runs_and_objects_are_measured_by_a_truth_and_exported(ready, hand, tmp_path, monkeypatch) -> None:
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.scene.result is not None and ready.session.idle)
    hand.key(KEY.Key_D, Qt.KeyboardModifier.ControlModifier)
    panel, compared = ready.get_feature(CompareFeature).panel, ready.workspace.comparison
    hand.wait(panel.isVisible)
    PIL.Image.fromarray((disc() > 100).astype(np.uint8) * 255).save(tmp_path / "mask.png")
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(tmp_path / "mask.png"), ""))
    hand.qtbot.mouseClick(panel.load, LEFT)
    hand.wait(lambda: compared.agreements.keys() == {CURRENT_KEY})
    table = panel.table
    names = column_texts(table, "name")
    assert names == ["Shown now", "Run 1", "mask.png"]
    hand.qtbot.mouseClick(table.viewport(), LEFT, pos=table.visualRect(table.model().index(1, 0)).center())
    run = compared.selected
    hand.wait(lambda: compared.agreements.keys() == {CURRENT_KEY, run})
    for key, dice in zip((CURRENT_KEY, run), column_texts(table, "dice"), strict=False):
        assert compared.agreements[key].dice > 0.97
        assert dice == f"{compared.agreements[key].dice:.3f}"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "a.csv"), ""))
    hand.qtbot.mouseClick(panel.export, LEFT)
    hand.wait(lambda: ready.session.tasks.idle)
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        written = {row["name"]: row["dice"] for row in csv.DictReader(file)}
    assert [*written] == names
    assert float(written["Run 1"]) == compared.agreements[run].dice
    compared.select_row(TRUTH_KEY)
    table.setFocus()
    hand.key(KEY.Key_Delete)
    hand.wait(lambda: column_texts(table, "name") == ["Shown now", "Run 1"])
    assert compared.truth_file is None
