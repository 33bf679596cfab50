"""Letters at the edges of slices and at the axes in space tell how a volume lies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.volume.slices import Slices, find_edge_labels, find_front_axis, slice_directions
from cpm_app.views.features.offers import FilePartsFeature
from cpm_app.views.features.volumes import SlicesFeature
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image
from tests.app.views.volume.conftest import ball, open_file

pytestmark = pytest.mark.shared_window

NOTHING = Image(np.zeros((8, 9, 10)))

VECTORS = {"L": [1, 0, 0], "R": [-1, 0, 0], "P": [0, 1, 0], "A": [0, -1, 0], "S": [0, 0, 1], "I": [0, 0, -1]}
"""Along left, posterior, superior."""

OPPOSITE = ({"L", "R"}, {"A", "P"}, {"S", "I"})


def shown(view):
    """The letters at the top, bottom, left and right of a view."""
    return view.layers["orientation"].letters


@pytest.fixture
def patient(window, hand, tmp_path):
    """A window on a volume whose columns lead to the left, rows to the back and planes to the head."""
    nibabel = pytest.importorskip("nibabel")
    nibabel.save(nibabel.Nifti1Image(ball().astype(np.uint8), np.diag([-1.0, -1.0, 2.0, 1.0])), tmp_path / "head.nii")
    open_file(window, hand, tmp_path / "head.nii")
    return window


def test_each_slice_has_the_letters_of_its_edges(patient, hand) -> None:
    slices = patient.get_feature(SlicesFeature)
    canvas = patient.canvas_area.canvas
    assert shown(canvas) == ("A", "P", "R", "L")
    assert [shown(view) for view in slices.sides] == [("S", "I", "R", "L"), ("S", "I", "A", "P")]
    assert [button.text() for button in slices.bar.axes] == ["Axial", "Coronal", "Sagittal"]
    hand.qtbot.mouseClick(slices.bar.axes[2], Qt.MouseButton.LeftButton)
    assert shown(canvas) == ("S", "I", "A", "P")
    assert [shown(view) for view in slices.sides] == [("A", "P", "R", "L"), ("S", "I", "R", "L")]


def test_what_is_superior_is_above_and_keys_lead_where_they_point(patient, hand) -> None:
    patient.get_feature(SlicesFeature).bar.axes[1].click()
    canvas = patient.canvas_area.canvas
    foot, head = canvas.map_from_image((4.0, 10.0)), canvas.map_from_image((20.0, 10.0))
    assert head.y() < foot.y()
    assert head.x() == foot.x()
    hand.key(Qt.Key.Key_Return)
    row, col = patient.canvas_area.crosshair.position
    hand.key(Qt.Key.Key_Up)
    hand.key(Qt.Key.Key_Right)
    assert patient.canvas_area.crosshair.position == (row + 1.0, col + 1.0)
    hand.key(Qt.Key.Key_Escape)
    before = canvas.map_from_image((4.0, 10.0))
    canvas.pan_by(0.0, 30.0)
    assert canvas.map_from_image((4.0, 10.0)).y() == pytest.approx(before.y() - 30.0, abs=1.0)
    canvas.pan_by(0.0, -30.0)
    patient.get_feature(SlicesFeature).bar.axes[0].click()


@given(st.permutations(range(3)), st.tuples(*[st.sampled_from((1, -1))] * 3))
def test_a_patient_is_never_mirrored(order, signs) -> None:
    along = np.eye(3)[order] * np.array(signs)[:, None]
    volume = replace(NOTHING, geometry=Geometry((0.0, 0.0, 0.0), tuple(map(tuple, along.tolist()))))
    seen = [axes @ along for axes in slice_directions(volume)]  # along left, posterior, superior
    assert all(np.linalg.det(axes) == pytest.approx(1.0) for axes in seen)
    front = seen[find_front_axis(volume)]
    assert np.abs(front[2]).tolist() == [0.0, 1.0, 0.0]
    for axis, axes in enumerate(seen):
        (top, bottom), (left, right) = find_edge_labels(volume, replace(Slices.through_middle(volume.shape), axis=axis))
        assert [VECTORS[right], VECTORS[bottom]] == axes[:2].tolist()
        assert bottom not in "AS"
        assert right not in "RA"
        assert {top, bottom} in OPPOSITE
        assert {left, right} in OPPOSITE


@pytest.mark.own_window
def test_a_plain_image_has_no_letters_and_a_plane_of_a_patient_has(patient, hand, image_file) -> None:
    patient.actions_by_name["parts"].trigger()
    dialog = patient.get_feature(FilePartsFeature).dialog
    hand.qtbot.keyClick(dialog.kind, Qt.Key.Key_Down)
    hand.qtbot.mouseClick(dialog.open_button, Qt.MouseButton.LeftButton)
    hand.wait(lambda: patient.session.image.ndim == 2 and patient.session.idle)
    assert shown(patient.canvas_area.canvas) == ("A", "P", "R", "L")
    open_file(patient, hand, image_file)
    assert shown(patient.canvas_area.canvas) == ("", "", "", "")
