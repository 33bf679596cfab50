"""The mode of skeletons in a volume: center lines in slices and in space, of the volume or of objects, in files."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.layers.skeleton import inscribed_disks
from cpm_app.views.volume.space_view_builder import SpaceViewBuilder
from PySide6.QtCore import Qt

from tests.app.exporting import asked, order

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier

SHAPE, AT = (24, 28, 40), (12.0, 14.0)


@pytest.fixture
def volume_file(tmp_path):
    """A bright rod along the columns of a dark volume."""
    planes, rows, cols = np.indices(SHAPE)
    away = np.maximum(np.hypot(planes - AT[0], rows - AT[1]), np.abs(cols - 19.5) - 11.0)
    np.save(tmp_path / "rod.npy", np.round(20 + 180 * np.clip(5.0 - away, 0, 1)).astype(np.uint8))
    return tmp_path / "rod.npy"


@pytest.fixture
def found(volume, hand):
    """A window in which the skeleton of the rod has been found."""
    volume.actions_by_name["mode_skeleton"].trigger()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle and volume.session.scene.skeleton is not None)
    return volume


def test_the_center_line_of_a_rod_is_found_and_counted(found) -> None:
    (line,) = found.session.scene.skeleton.contours
    assert np.allclose(line.points[:, :2], AT, atol=1.0)
    assert len(found.session.status.contours) == 1
    assert ("Branches", "1") in [number[:2] for number in found.session.resolved.numbers]
    assert found.session.status.found.length == pytest.approx(26.0, abs=6.0)


def test_slices_show_the_pieces_near_them_and_space_all(found, hand) -> None:
    layer = hand.canvas.layers["skeleton"]
    found.workspace.slices.go_to(12)
    assert layer.branches.count >= 1
    found.workspace.slices.go_to(2)
    assert (layer.branches.count, layer.disks.count) == (0, 0)
    found.workspace.slices.set_axis(2)
    found.workspace.slices.go_to(20)
    found.workspace.slices.set_axis(0)
    seen = SpaceViewBuilder().build_view(found.session.scene, hand.canvas.layers)
    assert seen.wires is not None
    assert np.ptp(seen.wires.ends[:, :, 2]) > 15.0


def test_disks_in_slices_are_round_in_space() -> None:
    (ring,) = inscribed_disks(np.array([(5.0, 5.0)]), np.array([3.0]), (2.0, 1.0))
    assert np.ptp(ring, axis=0) == pytest.approx((3.0, 6.0), abs=0.05)


def test_center_lines_are_exported_and_come_back_with_a_session(found, hand, tmp_path) -> None:
    dialog = asked(hand.qtbot, found)
    assert dialog.windowTitle() == "Export center lines"
    (written,) = order(hand.qtbot, found, dialog, tmp_path)
    assert written.suffix == ".swc"
    lines = [line for line in written.read_text().splitlines() if not line.startswith("#")]
    assert len(lines) > 10
    path = tmp_path / "work.cpm"
    assert found.get_feature(OpenSaveFeature).document_file.save_and_wait(path)
    before = found.session.scene.skeleton.contours[0].points
    found.open_image(str(path))
    hand.wait(lambda: found.session.idle and found.session.scene.skeleton is not None)
    assert found.session.document.mode == "skeleton"
    assert np.array_equal(found.session.scene.skeleton.contours[0].points, before)
