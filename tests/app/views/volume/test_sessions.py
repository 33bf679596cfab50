"""Work on a volume is saved and opened again."""

from __future__ import annotations

import json

import numpy as np
import pytest
from cpm_app.views.features.files import OpenSaveFeature
from PySide6.QtCore import Qt

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, load_session, save_session
from cpm_core.shapes import Circle, Sphere
from tests.app.views.volume.conftest import open_file

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier


def test_a_session_brings_back_drawing_run_and_slice(volume, hand, tmp_path, image_file) -> None:
    path, file = tmp_path / "work.cpm", volume.get_feature(OpenSaveFeature).document_file
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    volume.workspace.slices.set_axis(2)
    volume.workspace.slices.go_to(9)
    found, document = volume.session.scene.snapshot.position, volume.session.document
    assert file.unsaved
    file.save_and_wait(path)
    assert load_session(path).image.shape == document.image.shape
    open_file(volume, hand, image_file)
    assert volume.session.scene.slices is None
    volume.open_image(str(path))
    hand.wait(lambda: volume.session.document.image.name == "ball.npy" and volume.session.idle)
    assert volume.session.document.shapes == document.shapes
    assert volume.session.document.parameters == document.parameters
    now = volume.session.scene.slices
    assert (now.axis, now.current.index) == (2, 9)
    np.testing.assert_array_equal(volume.session.scene.snapshot.position, found)
    hand.wait(lambda: len(volume.canvas_area.canvas.drawn_scene.contours) > 0)
    assert not file.unsaved


@pytest.mark.parametrize(
    "kept", [None, {}, {"axis": 7, "voxel": [1, 2]}, {"axis": "x", "voxel": "y"}, {"axis": True, "voxel": [1.5, 2, 3]}]
)
def test_slices_that_make_no_sense_in_a_file_change_nothing(volume, kept) -> None:
    before = volume.session.scene.slices
    volume.workspace.slices.use_view_state(json.loads(json.dumps({"slices": kept})))
    assert volume.session.scene.slices == before


@pytest.mark.parametrize("volumes", [True, False])
def test_a_drawing_of_another_dimension_is_refused_and_nothing_is_lost(
    volume, hand, tmp_path, volume_file, image_file, volumes
) -> None:
    shape = Sphere((12.0, 14.0, 16.0), 5.0) if volumes else Circle((20.0, 20.0), 9.0)
    file = image_file if volumes else volume_file
    save_session(SessionFile(ImageFile(str(file)), (shape,)), tmp_path / "other.cpm")
    hand.drag((14, 16), (14, 18), (14, 20))
    before = volume.session.document
    volume.open_image(str(tmp_path / "other.cpm"))
    words = "shape 1 (sphere) is for volumes" if volumes else "shape 1 (circle) is for images"
    hand.wait(lambda: words in volume.canvas_area.messages.text.lower())
    assert volume.session.document is before
