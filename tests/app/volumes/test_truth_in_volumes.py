"""The ground truth of a volume: a surface is compared with labels, slices show where both differ, sessions keep it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from app.views.features.volumes import SpaceFeature
from app.views.window.window import MainWindow
from cpm_core.contours.agreement import TOLERANCE
from tests.app.conftest import Hand
from tests.app.volumes.conftest import SHAPE, ball

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
    volume.workspace.truth.set_tolerance(TOLERANCE)
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    hand.key(KEY.Key_T, CONTROL | SHIFT)
    hand.wait(lambda: volume.workspace.truth.verified is not None)
    return volume


def figure(window: MainWindow, name: str) -> float:
    return float(window.panels["truth"].values[name].text().split()[0])


def test_overlap_and_distances_are_those_of_geometry(compared) -> None:
    radius, panel = 7.0, compared.panels["truth"]
    common = math.pi * (2 * radius - AWAY) ** 2 * (4 * radius + AWAY) / 12.0
    both = 2 * 4 / 3 * math.pi * radius**3 + 4**3
    assert figure(compared, "dice") == pytest.approx(2 * common / both, abs=0.04)
    assert figure(compared, "hausdorff") > 10.0  # the ball in the corner is missed
    assert panel.values["hausdorff"].text().endswith(" voxels")
    assert "Objects: 1 found, 1 missed" in panel.objects.text()
    assert "labels.npy" in panel.source.text()
    assert not panel.holes.isVisible()
    assert compared.panels["truth"].isVisible()


def test_each_slice_shows_the_truth_and_where_the_surface_differs(compared, hand) -> None:
    layer, slices = hand.canvas.layers["truth"], compared.workspace.slices
    assert layer.counts[0] == 1
    assert layer.counts[1] >= 1
    assert layer.counts[2] >= 1
    slices.at(4)
    assert layer.counts[:2] == (1, 1)
    assert layer.counts[2] == 0
    slices.at(SHAPE[0] - 1)
    assert layer.counts == (0, 0, 0)
    panel = compared.panels["truth"]
    panel.tolerance.setFocus()
    slices.at(12)
    hand.qtbot.keyClick(panel.tolerance, KEY.Key_End)
    hand.wait(lambda: layer.counts == (1, 0, 0))


def test_keys_lead_to_the_differences_one_after_the_other(compared, hand) -> None:
    hand.canvas.setFocus()
    compared.workspace.slices.at(20)
    compared.actions_by_name["worst_place"].trigger()
    worst = compared.workspace.truth.verified.differences[0]
    assert worst.kind == "missing"
    assert compared.session.scene.slices.voxel == tuple(round(at) for at in worst.place)
    assert compared.session.scene.slices.voxel[0] < 8
    hand.key(KEY.Key_W, SHIFT)
    following = compared.workspace.truth.verified.differences[1]
    assert compared.session.scene.slices.voxel == tuple(round(at) for at in following.place)


def test_space_shows_the_true_surface_while_its_layer_is_shown(compared, hand) -> None:
    panel = compared.feature(SpaceFeature).panel
    hand.wait(lambda: panel.contents is not None and len(panel.contents.truth) == 1)
    (shown,) = panel.contents.truth
    assert shown.mesh.surface.vertices.shape == compared.session.scene.truth.surface.vertices.shape
    assert shown in panel.contents.truth
    compared.actions_by_name["layer_truth"].trigger()
    hand.wait(lambda: panel.contents.truth == ())
