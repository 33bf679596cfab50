"""Ground truth: the measures agree with geometry, follow every reconstruction, and locate the differences."""

from __future__ import annotations

import math
import threading
from pathlib import Path

import numpy as np
import pytest
import tifffile
from cpm_app.model.display.differences import find_boundary_differences
from cpm_app.model.document.imported import add_objects, objects_from_contours
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.features.comparison import CURRENT_KEY, TRUTH_KEY, ComparisonRow
from cpm_app.views.features.compare import CompareFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from cpm_core.contours.agreement import compare
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import truth_from_contours
from tests.app.conftest import Hand, disc
from tests.app.reading import column_texts

pytestmark = pytest.mark.shared_window

KEY = Qt.Key

RADIUS, SHIFT = 18.0, 9.0
"""Of the disc in the image, and how far the one in the truth is shifted."""


def lens(radius: float, shift: float) -> float:
    """Common area of two discs of equal radius at a distance of their centers."""
    half = shift / (2 * radius)
    return 2 * radius**2 * math.acos(half) - 0.5 * shift * math.sqrt(4 * radius**2 - shift**2)


@pytest.fixture
def mask_file(tmp_path: Path) -> Path:
    """A mask of the disc, shifted to the right."""
    path = tmp_path / "mask.npy"
    np.save(path, np.roll(disc(RADIUS) > 100, int(SHIFT), axis=1).astype(np.uint8))
    return path


@pytest.fixture
def compared(ready: MainWindow, hand: Hand, mask_file: Path, monkeypatch: pytest.MonkeyPatch) -> MainWindow:
    """A window in which the contour of the disc has been compared with a shifted one, chosen by the menu."""
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle)
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(mask_file), ""))
    hand.key(KEY.Key_D, Qt.KeyboardModifier.ControlModifier)
    ready.get_feature(CompareFeature).panel.load.click()
    hand.wait(lambda: CURRENT_KEY in ready.workspace.comparison.agreements)
    return ready


def truth_row(window: MainWindow) -> ComparisonRow:
    return window.workspace.comparison.rows[TRUTH_KEY]


def figure(window: MainWindow, name: str) -> float:
    """A figure in the row of what is shown now."""
    table = window.panels["compare"].table
    table.setColumnHidden(table.column_index(name), False)
    return float(column_texts(table, name)[column_texts(table, "name").index("Shown now")])


def test_a_shifted_disc_has_the_overlap_and_the_distances_of_geometry(compared) -> None:
    area, common = math.pi * RADIUS**2, lens(RADIUS, SHIFT)
    assert figure(compared, "dice") == pytest.approx(common / area, abs=0.02)
    assert figure(compared, "jaccard") == pytest.approx(common / (2 * area - common), abs=0.03)
    assert figure(compared, "largest") == pytest.approx(SHIFT, abs=0.8)
    assert column_texts(compared.panels["compare"].table, "name") == ["Shown now", "Run 1", "mask.npy"]
    assert compared.panels["compare"].isVisible()


def test_differences_are_drawn_and_vanish_with_a_larger_tolerance(compared, hand) -> None:
    layer, panel = hand.canvas.layers["truth"], compared.panels["compare"]
    boundaries, missing, wrong = layer.counts
    assert boundaries == 1
    assert missing >= 1
    assert wrong >= 1
    assert figure(compared, "precision") < 0.5
    panel.tolerance.setFocus()
    hand.qtbot.keyClick(panel.tolerance, KEY.Key_End)
    hand.wait(lambda: layer.counts == (1, 0, 0))
    assert figure(compared, "precision") == 1.0
    assert figure(compared, "recall") == 1.0
    assert not compared.actions_by_name["next_difference"].isEnabled()


@pytest.mark.own_window
def test_the_largest_difference_is_brought_into_view(compared, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_W, Qt.KeyboardModifier.ShiftModifier)
    worst = compared.session.scene.differences[0]
    assert worst.farthest == pytest.approx(SHIFT, abs=0.8)
    seen = hand.canvas.view.viewRect()
    low, high = worst.points.min(axis=0), worst.points.max(axis=0)
    assert seen.left() < low[1] < high[1] < seen.right()
    assert seen.top() < low[0] < high[0] < seen.bottom()
    assert seen.height() < 70


def test_objects_are_compared_where_there_are_any(compared, hand) -> None:
    before = figure(compared, "dice")
    (item,) = objects_from_contours(truth_row(compared).found.contours)
    compared.session.edit("add", lambda document: add_objects(document, [item]))
    hand.wait(lambda: figure(compared, "dice") > 0.99)
    compared.session.undo()
    hand.wait(lambda: figure(compared, "dice") == before)


def test_without_the_truth_a_run_is_compared_with_what_is_shown_now(compared, hand) -> None:
    comparison = compared.workspace.comparison
    run = compared.workspace.navigation.branches[0].identity
    comparison.select_row(run)
    hand.wait(lambda: comparison.agreements.keys() == {CURRENT_KEY, run})
    assert comparison.agreements[run].dice < 0.8
    comparison.remove_truth()
    assert comparison.reference == CURRENT_KEY
    hand.wait(lambda: comparison.agreements.keys() == {run})
    assert comparison.agreements[run].dice == 1.0
    assert compared.session.scene.truth is None


def test_what_is_left_out_of_a_truth_is_told(compared, hand, tmp_path) -> None:
    path = tmp_path / "two.tif"
    labels = np.zeros((64, 64), np.uint8)
    labels[10:30, 10:30] = 1
    tifffile.imwrite(path, np.stack([labels, 0 * labels]), photometric="minisblack", metadata={"axes": "CYX"})
    compared.workspace.comparison.load_truth_file(path)
    hand.wait(lambda: truth_row(compared).title == "two.tif")
    assert compared.canvas_area.messages.text == "two.tif: Only the first of its 2 channels was taken."


def test_a_mask_of_another_size_is_rejected_with_a_message_and_the_truth_stays(compared, hand, tmp_path) -> None:
    path = tmp_path / "small.npy"
    np.save(path, np.eye(20))
    compared.workspace.comparison.load_truth_file(path)
    hand.wait(lambda: "64 x 64" in compared.canvas_area.messages.text)
    assert compared.session.scene.truth.source == truth_row(compared).title == "mask.npy"
    assert compared.workspace.comparison.truth_file.path.endswith("mask.npy")


def test_a_new_image_has_nothing_to_compare_with(compared, hand, tmp_path) -> None:
    other = tmp_path / "other.npy"
    np.save(other, disc(10.0))
    compared.session.open_file(other)
    hand.wait(lambda: compared.session.document.image.name == "other.npy")
    assert compared.session.scene.truth is None
    assert hand.canvas.layers["truth"].counts == (0, 0, 0)
    hand.wait(lambda: column_texts(compared.panels["compare"].table, "dice") == ["–"])


def test_a_session_with_a_truth_has_the_tab_for_it_when_it_is_opened_again(compared, hand, tmp_path) -> None:
    session, tabs = compared.session, compared.docks.tabs
    place = tabs.indexOf(compared.panels["compare"])
    assert compared.document_file.save_and_wait(tmp_path / "kept.cpm")
    other = tmp_path / "other.npy"
    np.save(other, disc(10.0))
    session.open_file(other)
    hand.wait(lambda: session.document.image.name == "other.npy")
    compared.docks.set_tab_available("compare", False)
    session.open_file(tmp_path / "kept.cpm")
    hand.wait(lambda: TRUTH_KEY in compared.workspace.comparison.rows)
    assert tabs.isTabVisible(place)


def square(low: float, high: float) -> Contour:
    side = np.arange(low, high)
    rows = np.concatenate([0 * side + low, side, 0 * side + high, high + low - side])
    return Contour(np.column_stack([rows, np.roll(rows, len(side))]), True)


def test_differences_are_the_segments_beyond_the_tolerance_largest_first() -> None:
    found = square(10.0, 30.0)
    bulge = found.points.copy()
    bulge[found.points[:, 0] == 30.0, 0] += 6.0  # the lower side is pushed out
    truth = truth_from_contours([found], (48, 48))
    there = find_boundary_differences([Contour(bulge, True)], compare([Contour(bulge, True)], truth))
    assert {difference.kind for difference in there} == {"missing", "wrong"}
    assert there[0].farthest == pytest.approx(6.0)
    assert [d.farthest for d in there] == sorted((d.farthest for d in there), reverse=True)
    for difference in there:
        assert difference.points[:, 0].min() >= 26.0
    same = find_boundary_differences([found], compare([found], truth))
    assert same == ()


def test_of_many_jobs_the_newest_is_done_and_the_thread_ends(qtbot, session) -> None:
    latest, results, begun, held = (
        LatestOnlyWorker(session, "test", "testing"),
        [],
        threading.Event(),
        threading.Event(),
    )
    latest.submit(lambda: (begun.set(), held.wait(20), "first")[-1], results.append)
    assert begun.wait(20)
    for number in range(5):
        latest.submit(lambda number=number: number, results.append)
    held.set()
    qtbot.waitUntil(lambda: results[-1:] == [4], timeout=20_000)
    assert results == ["first", 4]
    qtbot.waitUntil(lambda: latest.idle, timeout=20_000)
    latest.close()
