"""The ground truth of a volume: a surface is compared with labels, slices show where both differ, sessions keep it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from cpm_app.session.features.comparison import CURRENT_KEY
from cpm_app.views.features.volumes import SpaceFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from cpm_core.contours.agreement import DEFAULT_TOLERANCE
from tests.app.conftest import Hand
from tests.app.reading import column_texts
from tests.app.views.volume.conftest import SHAPE, ball

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier

AWAY = 3
"""How far the ball of the truth lies from that of the volume [columns]."""


@pytest.fixture
def labels_file(tmp_path: Path) -> Path:
    """Labels of the ball, shifted to the right, with one more ball in a corner."""
    labels = np.roll(ball() > 110.0, AWAY, axis=2)
    labels[2:6, 2:6, 2:6] = True
    np.save(tmp_path / "labels.npy", labels.astype(np.uint8))
    return tmp_path / "labels.npy"


@pytest.fixture
def compared(volume: MainWindow, hand: Hand, labels_file: Path, monkeypatch: pytest.MonkeyPatch) -> MainWindow:
    """A window in which the surface of the ball has been compared with labels, chosen by the key."""
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(labels_file), ""))
    volume.workspace.comparison.set_tolerance(DEFAULT_TOLERANCE)
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    hand.key(KEY.Key_D, CONTROL)
    volume.panels["compare"].load.click()
    hand.wait(lambda: CURRENT_KEY in volume.workspace.comparison.agreements)
    return volume


def test_overlap_and_distances_are_those_of_geometry(compared) -> None:
    radius, panel = 7.0, compared.panels["compare"]
    common = math.pi * (2 * radius - AWAY) ** 2 * (4 * radius + AWAY) / 12.0
    both = 2 * 4 / 3 * math.pi * radius**3 + 4**3
    agreed = compared.workspace.comparison.agreements[CURRENT_KEY]
    assert agreed.dice == pytest.approx(2 * common / both, abs=0.04)
    assert agreed.hausdorff > 10.0  # the ball in the corner is missed
    assert (agreed.objects.found, agreed.objects.missed) == (1, 1)
    assert panel.summary.text().endswith(" voxels.")
    assert column_texts(panel.table, "name") == ["Shown now", "Run 1", "labels.npy"]
    assert not panel.holes.isVisible()


def test_a_surface_is_compared_with_another_one(compared, hand) -> None:
    comparison = compared.workspace.comparison
    run = compared.workspace.navigation.branches[0].identity
    comparison.select_row(run)
    hand.wait(lambda: comparison.agreements.keys() == {CURRENT_KEY, run})
    comparison.remove_truth()
    hand.wait(lambda: comparison.agreements.keys() == {run})
    assert comparison.agreements[run].dice == 1.0


def test_each_slice_shows_the_truth_and_where_the_surface_differs(compared, hand) -> None:
    layer, slices = hand.canvas.layers["truth"], compared.workspace.slices
    assert layer.counts[0] == 1
    assert layer.counts[1] >= 1
    assert layer.counts[2] >= 1
    slices.go_to(4)
    assert layer.counts[:2] == (1, 1)
    assert layer.counts[2] == 0
    slices.go_to(SHAPE[0] - 1)
    assert layer.counts == (0, 0, 0)
    panel = compared.panels["compare"]
    panel.tolerance.setFocus()
    slices.go_to(12)
    hand.qtbot.keyClick(panel.tolerance, KEY.Key_End)
    hand.wait(lambda: layer.counts == (1, 0, 0))


def test_keys_lead_to_the_differences_one_after_the_other(compared, hand) -> None:
    hand.canvas.setFocus()
    compared.workspace.slices.go_to(20)
    hand.key(KEY.Key_W, SHIFT)
    worst = compared.session.scene.differences[0]
    assert worst.kind == "missing"
    assert compared.session.scene.slices.voxel == tuple(round(at) for at in worst.place)
    assert compared.session.scene.slices.voxel[0] < 8
    hand.key(KEY.Key_W, SHIFT)
    following = compared.session.scene.differences[1]
    assert compared.session.scene.slices.voxel == tuple(round(at) for at in following.place)


def test_space_shows_the_true_surface_while_its_layer_is_shown(compared, hand) -> None:
    panel = compared.get_feature(SpaceFeature).panel
    hand.wait(lambda: panel.contents is not None and len(panel.contents.truth) == 1)
    (shown,) = panel.contents.truth
    assert shown.mesh.surface.vertices.shape == compared.session.scene.truth.surface.vertices.shape
    assert shown in panel.contents.truth
    compared.actions_by_name["layer_truth"].trigger()
    hand.wait(lambda: panel.contents.truth == ())
