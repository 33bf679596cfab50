"""A second image lies where its place in space says, whatever its axes, voxels and unit."""

from __future__ import annotations

import numpy as np
import pytest

from cpm_core import Geometry, Image
from cpm_core.image.resampling import find_grid_mapping, is_label_map, resample_image


def of_place(affine: np.ndarray, shape: tuple[int, int, int]) -> np.ndarray:
    """Gray levels that grow linearly in space, so that interpolation is exact."""
    x, y, z, _ = affine @ np.stack([*np.indices(shape, float), np.ones(shape)]).reshape(4, -1)
    return (3.0 * x - 2.0 * y + z).reshape(shape)


def placed(shape, spacing, origin, unit="mm", directions=None) -> Image:
    geometry = Geometry(origin, *([] if directions is None else [directions]))
    return Image(of_place(geometry.affine(spacing, "LPS"), shape), spacing, unit, geometry=geometry)


TURNED = ((0.0, 0.6, 0.8), (0.0, -0.8, 0.6), (-1.0, 0.0, 0.0))


@pytest.mark.parametrize("directions", [None, TURNED])
def test_gray_levels_are_those_of_the_same_place_in_space(directions) -> None:
    target = placed((12, 20, 24), (2.0, 1.0, 1.0), (5.0, -3.0, 7.0))
    image = placed((40, 50, 60), (1.5, 0.7, 0.9), (60.0, -30.0, -20.0) if directions else (-5.0, -10.0, 0.0),
                   directions=directions)  # fmt: skip
    mapping = find_grid_mapping(image, target)
    found = np.concatenate([resample_image(image, mapping, target, *part, nearest=False) for part in ((0, 5), (5, 12))])
    seen = np.isfinite(found)
    assert seen.mean() > 0.1
    np.testing.assert_allclose(found[seen], target.values[seen], rtol=1e-4, atol=1e-3)


def test_units_and_pictures_without_a_place_are_matched_by_the_size_of_a_pixel() -> None:
    rows = np.arange(60.0)[:, None] + np.zeros(40)
    image, target = Image(rows, (0.5, 0.5), "µm"), Image(np.eye(20), (0.001, 0.001), "mm")
    found = resample_image(image, find_grid_mapping(image, target), target, 0, 20, nearest=False)
    np.testing.assert_allclose(found[:20, :19], np.arange(20.0)[:, None] * 2.0 + np.zeros(19))
    assert np.isnan(found[:, 20:]).all()


def test_labels_are_taken_as_they_are_and_one_grid_is_not_resampled() -> None:
    labels = np.zeros((10, 10, 10), np.uint8)
    labels[3:7, 3:7, 3:7] = 7
    image, target = Image(labels, (2.0,) * 3, "mm"), Image(np.indices((20, 20, 20))[0] * 1.0, (1.0,) * 3, "mm")
    found = resample_image(image, find_grid_mapping(image, target), target, 0, 20, nearest=True)
    assert set(np.unique(found[np.isfinite(found)])) == {0.0, 7.0}
    same = resample_image(image, find_grid_mapping(image, image), image, 2, 5, nearest=False)
    np.testing.assert_array_equal(same, labels[2:5])


def test_label_maps_are_told_from_gray_images() -> None:
    blocks = np.kron(np.random.default_rng(2).integers(0, 4, (6, 6)), np.ones((8, 8)))
    blurred = np.maximum(np.hypot(*(np.indices((48, 48)) - 24.0)) - 10.0, 0.0)
    assert is_label_map(Image(blocks)) and is_label_map(Image(blocks.astype(np.uint8)))
    assert is_label_map(Image(255.0 * (blocks > 2.0)))
    drawing = np.full((96, 96), 255, np.uint8)
    drawing[24:72, 24:72] = np.rint(5.0 * blurred)
    assert not is_label_map(Image(85.0 * blocks)) and not is_label_map(Image(drawing))
    assert not is_label_map(Image(blurred)) and not is_label_map(Image(np.rint(5.0 * blurred).astype(np.uint8)))


def test_what_does_not_fit_is_named() -> None:
    with pytest.raises(ValueError, match="is an image, but image is a volume: choose one of the same kind"):
        find_grid_mapping(Image(np.eye(9)), Image(np.indices((9, 9, 9))[0]))
    with pytest.raises(ValueError, match="nothing tells how they lie on each other"):
        find_grid_mapping(Image(np.eye(9)), Image(np.eye(12)))
