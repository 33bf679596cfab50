"""A volume of the session is seen in space as the run goes on, and what is seen can be saved."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import PIL.Image
import pytest
from cpm_app.views.features.volumes import SpaceFeature
from cpm_app.views.theme import theme
from cpm_app.views.volume import space_marks
from PySide6.QtCore import Qt

from cpm_core.shapes import Sphere
from tests.app.views.volume.conftest import open_file

pytestmark = pytest.mark.shared_window

PATIENCE = 120_000


@pytest.fixture
def space(volume):
    return volume.get_feature(SpaceFeature).panel


@pytest.fixture
def patient(hand, monkeypatch):
    """Waits longer, since the first run in a volume compiles its loops."""
    monkeypatch.setattr(hand, "patience", PATIENCE)
    return hand


def test_a_volume_opens_its_view_in_space_and_an_image_closes_it(volume, hand, image_file, space) -> None:
    hand.wait(space.view.isVisible)
    assert space.contents.image is volume.session.image
    open_file(volume, hand, image_file)
    hand.wait(lambda: not space.view.isVisible())
    assert space.contents is None


def test_particles_and_surface_of_a_run_are_seen_on_the_boundary(volume, patient, space) -> None:
    patient.drag((14, 16), (14, 18), (14, 20))
    assert isinstance(volume.session.document.shapes[0], Sphere)
    volume.session.run()
    patient.wait(lambda: volume.session.status.phase == "finished" and volume.session.idle)
    patient.wait(lambda: space.contents.mesh is not None)
    contents = space.contents
    away = np.linalg.norm(contents.particles.positions - np.array([11.5, 13.5, 15.5]), axis=1)
    assert np.abs(away - 7.5).max() < 1.0
    assert len(contents.particles.colors) == len(contents.particles.positions)
    assert contents.mesh.surface is volume.session.scene.reconstruction.result.surface
    again = space.contents
    volume.workspace.slices.go_by(1)
    assert space.contents.mesh is again.mesh, "nothing is made again when only the slice changes"
    assert space.contents.slices.voxel != again.slices.voxel


def test_a_click_in_space_moves_the_slices_there(volume, hand, space) -> None:
    space.bar.checks["slices"].setChecked(True)
    space.view.look_along(1)
    hand.wait(lambda: space.view.is_idle)
    hand.qtbot.mouseClick(space.view, Qt.MouseButton.LeftButton, pos=space.view.rect().center())
    assert volume.session.scene.slices.voxel == pytest.approx((12, 14, 16), abs=1)
    axis = volume.session.scene.slices.voxel
    view = space.view
    hand.qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=view.rect().center() + view.rect().center() * 0.1)
    assert volume.session.scene.slices.voxel != axis
    assert volume.session.scene.slices.voxel[1] == axis[1]


def test_the_picture_in_space_is_saved_as_it_is_seen(volume, hand, space, tmp_path) -> None:
    hand.wait(lambda: space.view.is_idle)
    path = tmp_path / "space.png"
    volume.get_feature(SpaceFeature).write_view(path, False)
    hand.wait(path.exists)
    seen = np.asarray(PIL.Image.open(path).convert("RGB"))
    assert seen.shape[:2] == space.view.picture_size
    background = tuple(int(theme.CANVAS_COLOR[i : i + 2], 16) for i in (1, 3, 5))
    shown = space.view.grab().toImage()
    shown = shown.convertToFormat(shown.Format.Format_RGB888)
    drawn = np.frombuffer(shown.constBits(), np.uint8).reshape(shown.height(), shown.bytesPerLine())
    drawn = drawn[:, : 3 * shown.width()].reshape(shown.height(), shown.width(), 3)
    assert (seen[2, 2] == background).all()
    assert (np.abs(seen.astype(int) - drawn).max(-1) > 40).mean() < 0.01


def test_a_turntable_is_one_full_turn(volume, hand, space, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(space_marks, "TURN_FRAMES", 8)
    monkeypatch.setattr("cpm_app.views.features.volumes.TURN_FRAMES", 8)
    hand.wait(lambda: space.view.is_idle)
    path = tmp_path / "turn.gif"
    volume.get_feature(SpaceFeature).write_view(path, True)
    hand.wait(path.exists)
    with PIL.Image.open(path) as film:
        assert film.n_frames == 8
        frames = []
        for number in range(8):
            film.seek(number)
            frames.append(np.asarray(film.convert("RGB")).astype(int))
    assert max(frames[0].shape) <= 720
    assert all((one != other).any() for one, other in pairwise(frames))
