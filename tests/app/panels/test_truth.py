"""Ground truth: the measures agree with geometry, follow every reconstruction, and locate the differences."""

from __future__ import annotations

import math
import threading
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from app.model.display.differences import differences
from app.session.features.background import LatestOnlyWorker
from app.views.features.contours import TruthFeature
from app.views.window.window import MainWindow
from cpm_core.contours.agreement import compare
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import truth_of_contours
from tests.app.conftest import Hand, disc

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton

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
    hand.key(KEY.Key_T, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    hand.wait(lambda: ready.workspace.truth.verified is not None)
    return ready


def figure(window: MainWindow, name: str) -> float:
    return float(window.panels["truth"].values[name].text().split()[0])


def test_a_shifted_disc_has_the_overlap_and_the_distances_of_geometry(compared) -> None:
    area, common = math.pi * RADIUS**2, lens(RADIUS, SHIFT)
    assert figure(compared, "dice") == pytest.approx(common / area, abs=0.02)
    assert figure(compared, "jaccard") == pytest.approx(common / (2 * area - common), abs=0.03)
    assert figure(compared, "hausdorff") == pytest.approx(SHIFT, abs=0.8)
    assert "mask.npy" in compared.panels["truth"].source.text()
    assert compared.panels["truth"].isVisible()


def test_differences_are_drawn_and_vanish_with_a_larger_tolerance(compared, hand) -> None:
    layer, panel = hand.canvas.layers["truth"], compared.panels["truth"]
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
    assert not panel.worst_button.isEnabled()
    assert not compared.actions_by_name["worst_place"].isEnabled()


@pytest.mark.own_window
def test_the_largest_difference_is_brought_into_view(compared, hand) -> None:
    hand.qtbot.mouseClick(compared.panels["truth"].worst_button, LEFT)
    worst = compared.workspace.truth.verified.differences[0]
    assert worst.farthest == pytest.approx(SHIFT, abs=0.8)
    seen = hand.canvas.view.viewRect()
    low, high = worst.points.min(axis=0), worst.points.max(axis=0)
    assert seen.left() < low[1] < high[1] < seen.right()
    assert seen.top() < low[0] < high[0] < seen.bottom()
    assert seen.height() < 70


def test_a_rejected_contour_is_excluded_until_it_is_restored(compared, hand) -> None:
    before = figure(compared, "dice")
    hand.canvas.setFocus()
    hand.key(KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
    hand.key(KEY.Key_X)
    hand.wait(lambda: compared.panels["truth"].values["dice"].text() == "0.0000")
    assert compared.panels["truth"].values["hausdorff"].text() == "–"
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: compared.panels["truth"].values["dice"].text() == f"{before:.4f}")


def test_a_mask_of_another_size_is_rejected_with_a_message_and_the_truth_stays(compared, hand, tmp_path) -> None:
    path = tmp_path / "small.npy"
    np.save(path, np.eye(20))
    compared.feature(TruthFeature).truth.load(path)
    hand.wait(lambda: "64 x 64" in compared.canvas_area.messages.text)
    assert compared.workspace.truth.truth.source == "mask.npy"


def test_a_new_image_has_no_ground_truth(compared, hand, tmp_path) -> None:
    other = tmp_path / "other.npy"
    np.save(other, disc(10.0))
    compared.session.open(other)
    hand.wait(lambda: compared.session.document.image.name == "other.npy")
    assert compared.workspace.truth.truth is None
    assert hand.canvas.layers["truth"].counts == (0, 0, 0)
    assert compared.panels["truth"].values["dice"].text() == "–"


def square(low: float, high: float) -> Contour:
    side = np.arange(low, high)
    rows = np.concatenate([0 * side + low, side, 0 * side + high, high + low - side])
    return Contour(np.column_stack([rows, np.roll(rows, len(side))]), True)


def test_differences_are_the_segments_beyond_the_tolerance_largest_first() -> None:
    found = square(10.0, 30.0)
    bulge = found.points.copy()
    bulge[found.points[:, 0] == 30.0, 0] += 6.0  # the lower side is pushed out
    truth = truth_of_contours([found], (48, 48))
    there = differences([Contour(bulge, True)], truth, compare([Contour(bulge, True)], truth))
    assert {difference.kind for difference in there} == {"missing", "wrong"}
    assert there[0].farthest == pytest.approx(6.0)
    assert [d.farthest for d in there] == sorted((d.farthest for d in there), reverse=True)
    for difference in there:
        assert difference.points[:, 0].min() >= 26.0
    same = differences([found], truth, compare([found], truth))
    assert same == ()


def test_of_many_jobs_the_newest_is_done_and_the_thread_ends(qtbot, session) -> None:
    latest, results, begun, held = (
        LatestOnlyWorker(session, "test", "testing"),
        [],
        threading.Event(),
        threading.Event(),
    )
    latest.ask(lambda: (begun.set(), held.wait(20), "first")[-1], results.append)
    assert begun.wait(20)
    for number in range(5):
        latest.ask(lambda number=number: number, results.append)
    held.set()
    qtbot.waitUntil(lambda: results[-1:] == [4], timeout=20_000)
    assert results == ["first", 4]
    qtbot.waitUntil(lambda: latest.idle, timeout=20_000)
    latest.close()
