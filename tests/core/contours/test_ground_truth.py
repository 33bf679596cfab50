"""Ground truth: masks and contours in files become objects and boundaries."""

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core import Contour, Result, load_truth
from cpm_core.contours.ground_truth import truth_from_mask
from cpm_core.contours.rasterize import rasterize_mask
from cpm_core.formats import export

from ..scenes import circle_points

SHAPE = (60, 80)
ROUND = Contour(circle_points((28.0, 33.0), 20.0, 200), closed=True, name="cell")
HOLE = Contour(circle_points((28.0, 33.0), 8.0, 90), closed=True)
LINE = Contour(np.array([(5.0, 60.0), (40.0, 75.5)]), closed=False)


def result_of(*contours, shape=SHAPE):
    return Result(np.zeros((0, 2)), contours, None, 1, True, "at rest", shape, (0.5, 0.25), "µm", "a.png")


def test_the_boundary_of_a_mask_follows_that_of_the_object():
    mask = np.where(rasterize_mask([ROUND], SHAPE), 200, 0)
    truth = truth_from_mask(mask)
    (boundary,) = truth.contours
    assert boundary.closed
    away = np.abs(np.linalg.norm(truth.boundary - (28.0, 33.0), axis=1) - 20.0)
    assert away.max() < 0.75
    assert boundary.area == pytest.approx((mask > 0).sum(), abs=2.0)  # each corner of it cuts off and adds an eighth
    assert np.array_equal(truth.labels, mask // 200)
    assert np.linalg.norm(np.diff(truth.boundary, axis=0), axis=1).max() <= 0.25 + 1e-9


def test_where_three_objects_meet_boundaries_do():
    labels = np.zeros((20, 20), int)
    labels[:, 10:], labels[10:, :10] = 1, 2
    truth = truth_from_mask(labels)
    assert len(truth.contours) == 3
    assert all(sum(contour.junctions) == 1 for contour in truth.contours)
    assert sum(contour.length for contour in truth.contours) == pytest.approx(19 + 9.5, abs=1e-9)
    assert sorted(np.unique(truth.labels)) == [0, 1, 2]


def test_pixels_that_touch_at_a_corner_share_it():
    mask = np.zeros((20, 20), bool)
    mask[5:10, 5:10] = mask[10:15, 10:15] = True
    truth = truth_from_mask(mask)
    points = np.concatenate([contour.points for contour in truth.contours])
    assert (points == (9.5, 9.5)).all(axis=1).any()
    assert sum(contour.length for contour in truth.contours) == pytest.approx(40 - 6 * (1 - np.sqrt(0.5)), abs=1e-9)


def test_the_image_border_is_no_boundary():
    mask = np.zeros((20, 30), np.uint8)
    mask[:, 12:] = 1
    (boundary,) = truth_from_mask(mask).contours
    assert not boundary.closed
    assert (boundary.points[:, 1] == 11.5).all()
    assert np.ptp(boundary.points[:, 0]) == 19.0


def test_the_gray_levels_of_a_label_mask_are_objects(tmp_path):
    labels = np.zeros(SHAPE, np.uint16)
    labels[5:20, 5:20], labels[30:50, 30:60] = 300, 70
    tifffile.imwrite(tmp_path / "t.tif", labels)
    truth = load_truth(tmp_path / "t.tif", SHAPE)
    assert (truth.labels[10, 10], truth.labels[40, 40], truth.labels[0, 0]) == (2, 1, 0)
    assert len(truth.contours) == 2
    assert truth.objects is truth.labels


def test_a_binary_mask_from_a_lossy_format_is_still_binary(tmp_path):
    mask = np.where(rasterize_mask([ROUND], SHAPE), 255, 0).astype(np.uint8)
    PIL.Image.fromarray(mask).save(tmp_path / "t.jpg", quality=97)
    with PIL.Image.open(tmp_path / "t.jpg") as image:
        assert len(np.unique(np.asarray(image))) > 8
    truth = load_truth(tmp_path / "t.jpg", SHAPE)
    assert truth.labels.max() == 1
    assert np.array_equal(truth.labels > 0, mask > 0)


@pytest.mark.parametrize("suffix", [".csv", ".geojson", ".json", ".labelme.json"])
def test_exported_contours_are_read_as_the_same_truth(tmp_path, suffix):
    export(result_of(ROUND, HOLE, LINE), tmp_path / f"t{suffix}")
    truth = load_truth(tmp_path / f"t{suffix}", SHAPE)
    assert [contour.closed for contour in truth.contours] == [True, True, False]
    for contour, original in zip(truth.contours, (ROUND, HOLE, LINE), strict=True):
        assert len(contour.points) == len(original.points)
        assert contour.length == pytest.approx(original.length, abs=0.02)
    assert truth.contours[0].name == "cell"
    expected = rasterize_mask([ROUND], SHAPE) & ~rasterize_mask([HOLE], SHAPE)
    assert np.array_equal(truth.labels > 0, expected)
    filled = load_truth(tmp_path / f"t{suffix}", SHAPE, holes=False)
    assert np.array_equal(filled.labels > 0, rasterize_mask([ROUND], SHAPE))


def test_a_noisy_image_and_a_constant_one_are_no_masks(tmp_path):
    noise = np.random.default_rng(0).integers(0, 200, SHAPE).astype(np.uint8)
    PIL.Image.fromarray(noise).save(tmp_path / "noise.png")
    with pytest.raises(ValueError, match=r"noise\.png has \d+ gray levels .* it is an image, not a mask"):
        load_truth(tmp_path / "noise.png", SHAPE)
    PIL.Image.fromarray(np.full(SHAPE, 9, np.uint8)).save(tmp_path / "blank.png")
    with pytest.raises(ValueError, match=r"blank\.png has one gray level everywhere"):
        load_truth(tmp_path / "blank.png", SHAPE)
