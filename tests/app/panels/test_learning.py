"""Learning in the window: verdicts on some contours sort the others, on the canvas, in the table and in files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.session.features.contour_learning import ContourLearning
from app.views.features.file.open_save import OpenSaveFeature
from app.views.main_window import MainWindow
from cpm_core.contours.contour import Contour
from tests.app.conftest import Hand

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
DISCS = ((24, 24), (24, 72), (24, 120), (72, 24), (72, 72))


def is_disc(contour: Contour) -> bool:
    return min(abs(np.hypot(*(contour.points - center).T) - 14.0).max() for center in DISCS) < 3.0


@pytest.fixture
def found(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window in which discs and the spots of a texture have been found."""
    row, col = np.indices((144, 144)).astype(float)
    values = np.full(row.shape, 60.0)
    for center in DISCS:
        values += np.where(np.hypot(row - center[0], col - center[1]) < 14.0, 60.0, 0.0)
    spots = (np.sin(0.55 * row) * np.sin(0.6 * col) > 0.2) & (row > 96)  # with gaps, since a net is one contour
    path = tmp_path / "discs.npy"
    np.save(path, values + np.where(spots, 70.0, 0.0))
    session = window.session
    session.open(path)
    hand.wait(lambda: session.document.image is not None and session.document.image.name == "discs.npy")
    window.actions_by_name["mode_automatic"].trigger()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    window.docks["contours"].show()
    window.docks["contours"].raise_()
    return window


@pytest.fixture
def learning(found: MainWindow) -> ContourLearning:
    return found.workspace.learning


def judge(window: MainWindow, hand: Hand, contours: list[int], key: Qt.Key) -> None:
    """Give a verdict on contours, by the key for it."""
    items = window.workspace.review.items
    window.workspace.review.select(items[index].key for index in contours)
    hand.canvas.setFocus()
    hand.key(key)


def taught(window: MainWindow, hand: Hand) -> tuple[list[int], list[int]]:
    """Keep two discs, reject two spots, and learn; returns the indices of discs and of spots."""
    items = window.workspace.review.items
    discs = [index for index, item in enumerate(items) if is_disc(item.contour)]
    spots = [index for index in range(len(items)) if index not in discs]
    assert len(discs) == 5
    assert len(spots) >= 6
    judge(window, hand, discs[:2], KEY.Key_K)
    judge(window, hand, spots[:2], KEY.Key_X)
    hand.key(KEY.Key_L, Qt.KeyboardModifier.ShiftModifier)
    hand.wait(lambda: window.session.document.learning and window.workspace.learning.idle)
    return discs, spots


def left_out(window: MainWindow) -> list[int]:
    return [index for index, item in enumerate(window.workspace.review.items) if item.reviewed.left_out]


def exported(hand: Hand, window: MainWindow, path: Path) -> int:
    path.unlink(missing_ok=True)
    window.session.export(path)
    hand.wait(path.exists)
    hand.wait(lambda: window.session.idle)
    return len(json.loads(path.read_text(encoding="utf-8"))["contours"])


def test_verdicts_sort_the_other_contours_everywhere(found, hand, learning, tmp_path) -> None:
    discs, spots = taught(found, hand)
    out = left_out(found)
    assert out
    assert set(out) <= set(spots[2:])
    count = len(found.workspace.review.items)
    assert f"2 kept and 2 rejected: {len(out)} of {count} contours left out" in learning.summary
    assert f"{len(out)} of these are left out" in found.panels["contours"].summary.text()
    layer = found.canvas_area.canvas.layers.contours
    assert layer.rejected == len(out) + 2
    verdicts = found.panels["contours"].table.column("verdict")
    assert [index for index, verdict in enumerate(verdicts) if verdict == "✗ as learned"] == out
    assert exported(hand, found, tmp_path / "out.json") == count - len(out) - 2
    assert set(discs).isdisjoint(out)


def test_the_message_after_an_export_tells_what_is_left_out_as_learned(found, hand, tmp_path) -> None:
    taught(found, hand)
    said = []
    found.session.said.connect(lambda sentence, trouble: said.append(sentence))
    exported(hand, found, tmp_path / "out.json")
    hand.wait(lambda: any(f"{len(left_out(found))} left out as learned" in sentence for sentence in said))


def test_a_verdict_on_a_contour_left_out_takes_effect_at_once(found, hand, learning) -> None:
    taught(found, hand)
    chosen = left_out(found)[0]
    judge(found, hand, [chosen], KEY.Key_K)
    assert not found.workspace.review.items[chosen].reviewed.rejected
    assert "3 kept and 2 rejected" in learning.summary
    assert all(len(mark.features) for mark in found.session.document.marks)


def test_learning_is_undone_redone_and_switched_off(found, hand, learning) -> None:
    taught(found, hand)
    before = left_out(found)
    found.session.undo()
    assert left_out(found) == []
    found.session.redo()
    assert left_out(found) == before
    button = found.panels["contours"].buttons["learn"]
    assert button.isChecked()
    hand.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert left_out(found) == []
    assert learning.summary == ""
    assert not button.isChecked()


def test_without_verdicts_nothing_can_be_learned(found, hand) -> None:
    assert not found.actions_by_name["learn"].isEnabled()
    assert not found.panels["contours"].buttons["learn"].isEnabled()
    taught(found, hand)
    found.actions_by_name["forget_verdicts"].trigger()
    assert left_out(found) == []
    assert "Nothing is learned yet" in found.workspace.learning.summary


def test_the_next_doubtful_contour_has_no_verdict_until_all_have(found, hand, learning) -> None:
    taught(found, hand)
    review = found.workspace.review
    for _ in range(len(review.items) - 4):
        hand.key(KEY.Key_D, Qt.KeyboardModifier.ShiftModifier)
        assert [item.reviewed.mark for item in review.chosen] == [None]
        hand.key(KEY.Key_K)
    said = []
    found.session.said.connect(lambda sentence, trouble: said.append(sentence))
    hand.key(KEY.Key_D, Qt.KeyboardModifier.ShiftModifier)
    assert said == ["Every contour has a verdict."]


def test_what_is_learned_outlives_further_runs_and_files(found, hand, learning, tmp_path) -> None:
    taught(found, hand)
    before = left_out(found)
    saved = tmp_path / "learned.cpm"
    assert found.feature(OpenSaveFeature).document_file.save_at_once(saved)
    shown = found.workspace.review.result
    found.session.open(saved)
    hand.wait(lambda: found.session.idle and found.workspace.review.result not in (None, shown))
    hand.wait(lambda: left_out(found) == before)
    assert found.session.document.learning
    for _ in range(2):
        found.session.run()
        hand.wait_for_phase("finished")
        hand.wait(lambda: found.session.idle and learning.idle)
        assert left_out(found) == before
