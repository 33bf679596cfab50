"""The ground truth of a volume: labels are found as they lie in space, whatever the order of the axes in their file."""

import numpy as np
import pytest

from cpm_core import load_volume, load_volume_truth

nibabel = pytest.importorskip("nibabel")

SHAPE = (9, 10, 11)
AFFINE = np.array([[0.5, 0, 0, -10], [0, 0.75, 0, 20], [0, 0, 2.0, 5], [0, 0, 0, 1]])


@pytest.fixture
def volume(tmp_path):
    values = np.arange(np.prod(SHAPE), dtype=np.float32).reshape(SHAPE)
    nibabel.save(nibabel.Nifti1Image(values, AFFINE), tmp_path / "volume.nii")
    return load_volume(tmp_path / "volume.nii")


def labels_file(path, affine=AFFINE, turned=lambda values: values):
    values = np.zeros(SHAPE, np.uint8)
    values[1:3, 2:4, 1:6] = 3
    values[4, 5, 6] = 9
    nibabel.save(nibabel.Nifti1Image(turned(values), affine), path)
    return path


def test_labels_of_the_same_place_are_taken_with_the_sides_of_the_volume(tmp_path, volume):
    truth = load_volume_truth(labels_file(tmp_path / "labels.nii.gz"), volume)
    assert (truth.shape, truth.spacing, truth.unit) == (volume.shape, volume.spacing, "mm")
    assert sorted(np.unique(truth.labels)) == [0, 1, 2]
    assert truth.source == "labels.nii.gz"


@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (2, 1, 0)])
@pytest.mark.parametrize("flips", [(1, 1, 1), (-1, 1, -1)])
def test_labels_with_turned_axes_are_turned_as_the_volume(tmp_path, volume, axes, flips):
    straight = load_volume_truth(labels_file(tmp_path / "straight.nii"), volume)
    backward = tuple(slice(None, None, step) for step in flips)
    affine = np.eye(4)
    affine[:3, :3] = AFFINE[:3, :3][:, axes] * flips
    first = [side - 1 if step < 0 else 0 for side, step in zip(np.array(SHAPE)[list(axes)], flips, strict=True)]
    begin = np.zeros(3)
    begin[list(axes)] = first
    affine[:3, 3] = AFFINE[:3, :3] @ begin + AFFINE[:3, 3]
    path = labels_file(tmp_path / "turned.nii", affine, lambda values: values.transpose(axes)[backward])
    assert np.array_equal(load_volume_truth(path, volume).labels, straight.labels)


def test_labels_that_lie_elsewhere_are_refused(tmp_path, volume):
    away = AFFINE.copy()
    away[0, 3] += 30.0
    with pytest.raises(ValueError, match="lies elsewhere in space than volume"):
        load_volume_truth(labels_file(tmp_path / "labels.nii", away), volume)
    angle = np.eye(4)
    angle[:2, :2] = [[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]]
    with pytest.raises(ValueError, match="lies elsewhere"):
        load_volume_truth(labels_file(tmp_path / "labels.nii", angle @ AFFINE), volume)


def test_labels_of_another_size_and_contours_are_refused(tmp_path, volume):
    np.save(tmp_path / "small.npy", np.eye(9)[None] * np.ones((9, 1, 1)))
    with pytest.raises(ValueError, match="has 9 x 9 x 9 voxels, but this volume has 11 x 10 x 9"):
        load_volume_truth(tmp_path / "small.npy", volume)
    with pytest.raises(ValueError, match="lie in a plane"):
        load_volume_truth(tmp_path / "a.svg", volume)
