"""The vessel measure: large along lines, whether they are dark or bright, and nothing where there is none."""

import numpy as np
import scipy
from skimage.filters import sato

from cpm_core import Parameters, segment, uniform_grid
from cpm_core.image import vesselness as vesselness_module
from cpm_core.image.vesselness import vesselness

INNER = (slice(15, -15), slice(15, -15))


def line(angle, width, sign, shape=(90, 100)):
    """A line through the center with the profile of a Gaussian of this width, 100 gray levels high."""
    row, col = np.indices(shape)
    across = (row - shape[0] / 2) * np.cos(angle) - (col - shape[1] / 2) * np.sin(angle)
    return 120.0 + sign * 100.0 * np.exp(-0.5 * (across / width) ** 2), across


def test_it_agrees_with_the_filter_of_scikit_image(monkeypatch):
    values = scipy.ndimage.gaussian_filter(np.random.default_rng(1).normal(0.0, 50.0, (70, 80)), 2.0)
    monkeypatch.setattr(vesselness_module, "_NORMALIZATION", 2.0)
    dark, bright = (sato(values, (1.0, 2.0, 4.0), black_ridges=black, mode="nearest") for black in (True, False))
    found = vesselness(values)[INNER]
    errors = [np.abs(found - peer[INNER]).max() / peer.max() for peer in (dark, bright)]
    assert min(errors) < 0.05 < max(errors)


def test_a_tube_in_a_volume_is_a_vessel_and_a_plate_is_not():
    plane, row, col = np.indices((30, 32, 34)) - 15.0
    tube = np.exp(-0.5 * (row**2 + col**2) / 4.0)
    plate = np.exp(-0.5 * plane**2 / 4.0)
    inner = (slice(10, -10),) * 3
    assert vesselness(100.0 * plate)[inner].max() < 0.05 * vesselness(100.0 * tube)[inner].max()


def test_a_thin_vessel_in_uneven_light_is_found_on_both_sides_and_the_light_is_not():
    values, distance = line(0.3, 2.0, -0.3, (100, 110))
    values += 2.0 * np.indices(values.shape)[1]
    found = segment(values, uniform_grid(values.shape), Parameters(edges="vessels", edge_floor=0.2, scales=2)).contours
    points = np.concatenate([contour.points for contour in found])
    beside = scipy.ndimage.map_coordinates(distance, points.T, order=1)
    assert np.abs(beside).max() < 5.0
    assert min((beside < -1.0).mean(), (beside > 1.0).mean()) > 0.3
