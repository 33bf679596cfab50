"""Letters at the edges of slices and at the axes in space tell how a volume lies."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
import scipy
from cpm_app.model.volume.slices import (
    Slices,
    find_edge_labels,
    find_front_axis,
    find_slice_flips,
    name_slices,
    slice_directions,
)
from cpm_app.views.features.offers import FilePartsFeature
from cpm_app.views.features.volumes import SlicesFeature
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from cpm_core import load_volume
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image
from tests.app.views.volume.conftest import ball, move, open_file

pytestmark = pytest.mark.shared_window

NOTHING = Image(np.zeros((8, 9, 10)))

VECTORS = {"L": [1, 0, 0], "R": [-1, 0, 0], "P": [0, 1, 0], "A": [0, -1, 0], "S": [0, 0, 1], "I": [0, 0, -1]}
"""Along left, posterior, superior."""

OPPOSITE = ({"L", "R"}, {"A", "P"}, {"S", "I"})


def shown(view):
    """The letters at the top, bottom, left and right of a view."""
    return tuple(item.html for item in view.layers["orientation"].letters)


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


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@pytest.mark.parametrize("signs", list(itertools.product((1, -1), repeat=3)))
def test_slices_of_any_file_are_shown_as_radiologists_read_them(order, signs, tmp_path) -> None:
    nibabel = pytest.importorskip("nibabel")
    to_file = np.stack([order, signs], axis=1)
    file = nibabel.Nifti1Image(np.random.default_rng(0).integers(0, 255, (9, 10, 11), np.uint8), np.diag([2, 3, 4, 1]))
    nibabel.save(file.as_reoriented(to_file), tmp_path / "head.nii")
    image = load_volume(tmp_path / "head.nii")
    ras, names = nibabel.as_closest_canonical(nibabel.load(tmp_path / "head.nii")).get_fdata(), name_slices(image)
    # top to bottom and left to right: head to feet, front to back; the right side and the front are on the left
    wanted = {"axial": ras[::-1, ::-1, :].transpose(2, 1, 0), "coronal": ras[::-1, :, ::-1].transpose(1, 2, 0),
              "sagittal": ras[:, ::-1, ::-1].transpose(0, 2, 1)}  # fmt: skip
    for axis, name in enumerate(names):
        here = Slices.through_middle(image).slice_across(axis)
        upside_down, leftward = find_slice_flips(image, here)
        seen = here.slice_array(image.values)[:: -1 if upside_down else 1, :: -1 if leftward else 1]
        letter = image.geometry.letters[axis]
        index = here.index if letter in "RAS" else image.shape[axis] - 1 - here.index
        np.testing.assert_array_equal(seen, wanted[name][index])


ANGLES = st.floats(-180.0, 180.0)


@given(ANGLES, ANGLES, ANGLES)
def test_letters_of_oblique_slices_name_all_directions_in_which_an_axis_leads(one, two, three) -> None:
    turned = scipy.spatial.transform.Rotation.from_euler("xyz", [one, two, three], degrees=True).as_matrix()
    ends = Geometry(directions=tuple(map(tuple, turned.tolist()))).oblique_ends
    for along, (begin, end) in zip(turned, ends, strict=True):
        share = [float(along @ VECTORS[letter]) for letter in end]
        assert share == sorted(share, reverse=True)
        assert min(share) >= 0.1
        assert sum(part**2 for part in share) >= 0.98
        assert [-float(along @ VECTORS[letter]) for letter in begin] == share


def test_letters_of_an_oblique_file_agree_with_its_matrix_by_nibabel(window, hand, tmp_path) -> None:
    nibabel = pytest.importorskip("nibabel")
    matrix = np.eye(4)
    matrix[:3, :3] = scipy.spatial.transform.Rotation.from_euler("x", 20, degrees=True).as_matrix()
    nibabel.save(nibabel.Nifti1Image(ball().astype(np.uint8), matrix), tmp_path / "tilted.nii")
    assert nibabel.aff2axcodes(matrix) == ("R", "A", "S")
    open_file(window, hand, tmp_path / "tilted.nii")
    assert shown(window.canvas_area.canvas) == ("AS", "PI", "R", "L")
    assert [shown(view) for view in window.get_feature(SlicesFeature).sides] == [
        ("SP", "IA", "R", "L"),
        ("SP", "IA", "AS", "PI"),
    ]


def test_in_a_slice_whose_axes_are_exchanged_all_is_where_it_belongs(window, hand, tmp_path) -> None:
    nibabel = pytest.importorskip("nibabel")
    voxels = np.zeros((20, 24, 28), np.uint8)  # columns to the left, rows to the head, planes to the front
    voxels[4:8, 16:22, 6:14] = 200
    turn = np.array([[-1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, 2.0, 0, 0], [0, 0, 0, 1.0]])
    nibabel.save(nibabel.Nifti1Image(voxels, turn), tmp_path / "coronal.nii")
    open_file(window, hand, tmp_path / "coronal.nii")
    hand.qtbot.mouseClick(window.get_feature(SlicesFeature).bar.axes[2], Qt.MouseButton.LeftButton)
    window.workspace.slices.go_through((10, 19, 6))
    canvas = hand.canvas
    assert shown(canvas) == ("S", "I", "A", "P")
    assert canvas.shape == (24, 28)
    assert canvas.map_from_image((21, 10)).y() < canvas.map_from_image((16, 10)).y(), "the head is up"
    assert hand.color_at(19, 10) == (255, 255, 255)
    assert hand.color_at(10, 19) == (0, 0, 0)
    hand.key(Qt.Key.Key_J)
    hand.drag((17, 8), (20, 8))
    assert len(window.session.document.objects.items) == 1
    hand.key(Qt.Key.Key_S)
    hand.click(18, 8)
    assert window.session.scene.slices.voxel == (8, 18, 6)
    assert len(window.workspace.object_list.selected_keys) == 1
    hand.key(Qt.Key.Key_I)
    hand.drag((15, 5), (18, 10), (22, 14))
    hand.key(Qt.Key.Key_B)
    hand.drag((10, 3), (11, 12), (10, 20))
    region, wall = window.session.document.shapes
    assert np.round(region.first)[:2].tolist() == [5, 15]
    assert np.round(region.last)[:2].tolist() == [14, 22]
    assert np.ptp(np.array(wall.points), axis=0)[0] == pytest.approx(17, abs=0.5)
    drawn = canvas.drawn_scene.document.shapes[1]
    assert np.ptp(np.array(drawn.points), axis=0)[1] == pytest.approx(17, abs=0.5)


@given(st.permutations(range(3)), st.tuples(*[st.sampled_from((1, -1))] * 3))
def test_a_patient_is_never_mirrored(order, signs) -> None:
    along = np.eye(3)[order] * np.array(signs)[:, None]
    volume = replace(NOTHING, geometry=Geometry((0.0, 0.0, 0.0), tuple(map(tuple, along.tolist()))))
    seen = [axes @ along for axes in slice_directions(volume)]  # along left, posterior, superior
    assert all(np.linalg.det(axes) == pytest.approx(1.0) for axes in seen)
    front = seen[find_front_axis(volume)]
    assert np.abs(front[2]).tolist() == [0.0, 1.0, 0.0]
    for axis, axes in enumerate(seen):
        (top, bottom), (left, right) = find_edge_labels(volume, replace(Slices.through_middle(volume), axis=axis))
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


def test_the_pointer_is_told_its_slices_from_1_its_place_in_the_scanner_and_its_hounsfield_units(
    window, hand, tmp_path
) -> None:
    nibabel = pytest.importorskip("nibabel")
    matrix = np.diag([-2.0, 2.0, 2.5, 1.0])
    matrix[:3, 3] = 30.0, -12.0, 7.5
    file = nibabel.Nifti1Image((ball() - 1020.0).astype(np.int16), matrix)
    file.header.set_xyzt_units("mm")
    nibabel.save(file, tmp_path / "ct.nii")
    open_file(window, hand, tmp_path / "ct.nii")
    views = hand.canvas, *window.get_feature(SlicesFeature).sides
    for view, at in zip(views, ((14, 3), (12, 3), (12, 14)), strict=True):
        window.workspace.slices.go_through((12, 14, 3))
        move(view, at, Qt.MouseButton.NoButton)
        numbers = [float(word) for word in re.findall(r"-?[\d.]+", window.pointer_readout.text())]
        voxel = [number - 1 for number in numbers[:3]]
        assert numbers[3:6] == (matrix @ (*voxel[::-1], 1))[:3].tolist()
        assert numbers[6] == ball()[tuple(map(int, voxel))] - 1020.0
        assert window.pointer_readout.text().startswith(f"axial {voxel[0] + 1:.0f}, coronal ")
        assert "(RAS " in window.pointer_readout.text()
        assert window.pointer_readout.text().endswith(" HU")
