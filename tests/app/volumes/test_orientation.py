"""Letters at the edges of slices and at the axes in space tell how a volume lies."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.views.features.view.slices import SlicesFeature
from app.views.features.view.space import SpaceFeature
from tests.app.volumes.conftest import ball, open_file

pytestmark = pytest.mark.shared_window


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
    slices = patient.feature(SlicesFeature)
    canvas = patient.canvas_area.canvas
    assert shown(canvas) == ("A", "P", "R", "L")
    assert [shown(view) for view in slices.sides] == [("I", "S", "R", "L"), ("I", "S", "A", "P")]
    hand.qtbot.mouseClick(slices.bar.axes[2], Qt.MouseButton.LeftButton)
    assert shown(canvas) == ("I", "S", "A", "P")
    assert [shown(view) for view in slices.sides] == [("A", "P", "R", "L"), ("I", "S", "R", "L")]


def test_the_axes_in_space_have_the_same_letters(patient) -> None:
    assert patient.feature(SpaceFeature).panel.view.marks.names == (("I", "S"), ("A", "P"), ("R", "L"))


def test_the_letters_can_be_hidden(patient) -> None:
    patient.actions_by_name["layer_orientation"].trigger()
    assert shown(patient.canvas_area.canvas) == ("", "", "", "")
    assert shown(patient.feature(SlicesFeature).sides[0]) == ("", "", "", "")


@pytest.mark.own_window
def test_a_volume_that_tells_nothing_has_the_names_of_its_axes(volume) -> None:
    assert shown(volume.canvas_area.canvas) == ("", "row", "", "column")
    assert volume.feature(SpaceFeature).panel.view.marks.names[0] == ("", "plane")


@pytest.mark.own_window
def test_a_plain_image_has_no_letters_and_a_plane_of_a_patient_has(patient, hand, image_file) -> None:
    patient.actions_by_name["open_stack"].trigger()
    hand.wait(lambda: patient.session.image.ndim == 2 and patient.session.idle)
    assert shown(patient.canvas_area.canvas) == ("A", "P", "R", "L")
    open_file(patient, hand, image_file)
    assert shown(patient.canvas_area.canvas) == ("", "", "", "")
