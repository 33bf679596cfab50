"""The vessel measure: large along lines, whether they are dark or bright, and nothing where there is none."""

import numpy as np
import pytest
import scipy
import skimage

from cpm_core import PRESETS, Parameters, segment, uniform_grid
from cpm_core.image import vesselness as vesselness_module
from cpm_core.image.vesselness import filter_lines

INNER = (slice(15, -15), slice(15, -15))


def line(angle, width, sign, shape=(90, 100)):
    """A line through the center with the profile of a Gaussian of this width, 100 gray levels high."""
    row, col = np.indices(shape)
    across = (row - shape[0] / 2) * np.cos(angle) - (col - shape[1] / 2) * np.sin(angle)
    return 120.0 + sign * 100.0 * np.exp(-0.5 * (across / width) ** 2), across


def test_it_agrees_with_the_filter_of_scikit_image(monkeypatch):
    values = scipy.ndimage.gaussian_filter(np.random.default_rng(1).normal(0.0, 50.0, (70, 80)), 2.0)
    monkeypatch.setattr(vesselness_module, "_SIGMA_EXPONENT", 2.0)
    for black, found in zip((True, False), filter_lines(values), strict=True):
        peer = skimage.filters.sato(values, (1.0, 2.0, 4.0), black_ridges=black, mode="nearest")[INNER]
        assert np.abs(found.curvature[INNER] - peer).max() < 0.05 * peer.max()


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 4])
def test_an_edge_is_no_line_however_high_it_is(angle):
    row, col = np.indices((90, 100)) - 45.0
    step = 200.0 / (1.0 + np.exp(-2.0 * (row * np.cos(angle) - col * np.sin(angle))))
    for kind in filter_lines(step):
        assert kind.curvature[INNER].max() > 20.0
        assert kind.contrast[INNER].max() < 0.01 * 200.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 4])
def test_the_contrast_of_a_line_is_its_difference_from_both_sides_at_the_best_width(angle, sign):
    width, sigma = 1.5, np.array([1.0, 2.0, 4.0])
    values, across = line(angle, width, sign)
    found = filter_lines(values)[0 if sign < 0 else 1].contrast[INNER][np.abs(across[INNER]) < 0.3]
    smoothed = width**2 + sigma**2
    true = 100.0 * width / np.sqrt(smoothed) * (1.0 - np.exp(-0.5 * (2.0 * sigma) ** 2 / smoothed))
    assert found == pytest.approx(true.max(), rel=0.12)


def test_faint_vessels_are_found_next_to_the_rim_of_an_aperture_and_the_rim_is_not():
    row, col = np.indices((200, 200)) - 99.5
    away = np.abs(row - 12.0 * np.sin(col / 20.0))
    values = np.where(np.hypot(row, col) < 70.0, 120.0 - 8.0 * np.exp(-0.5 * (away / 2.0) ** 2), 2.0)
    values = scipy.ndimage.gaussian_filter(values, 1.0) + np.random.default_rng(3).normal(0.0, 0.5, values.shape)
    found = segment(values, uniform_grid(values.shape), PRESETS["vessels"]).contours
    points = np.concatenate([contour.points for contour in found]) - 99.5
    beside = np.abs(points[:, 0] - 12.0 * np.sin(points[:, 1] / 20.0))
    assert (beside < 7.0).mean() > 0.9
    for side in (-1.0, 1.0):
        reached = points[side * (points[:, 0] - 12.0 * np.sin(points[:, 1] / 20.0)) > 1.0, 1]
        assert len(np.unique(reached.round() // 4)) > 0.8 * 120 / 4


def test_a_thin_vessel_in_uneven_light_is_found_on_both_sides_and_the_light_is_not():
    values, distance = line(0.3, 2.0, -0.3, (100, 110))
    values += 2.0 * np.indices(values.shape)[1]
    found = segment(values, uniform_grid(values.shape), Parameters(edges="vessels", edge_floor=0.2, scales=2)).contours
    points = np.concatenate([contour.points for contour in found])
    beside = scipy.ndimage.map_coordinates(distance, points.T, order=1)
    assert np.abs(beside).max() < 5.0
    assert min((beside < -1.0).mean(), (beside > 1.0).mean()) > 0.3
