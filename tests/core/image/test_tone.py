"""The tone of an image: pale objects count beside strong ones, and nothing but the order of gray levels is kept."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cpm_core import Parameters, segment, uniform_grid
from cpm_core.image.gray_levels import apply_gamma, automatic_gamma

from ..scenes import disk

IMAGES = arrays(float, (5, 6), elements=st.integers(-1000, 1000).map(float))


@given(IMAGES, st.floats(0.2, 3.0))
def test_order_and_range_of_gray_levels_are_kept(values, gamma):
    shown = apply_gamma(values, gamma)
    assert shown.min() == pytest.approx(values.min(), abs=1e-9)
    assert shown.max() == pytest.approx(values.max(), abs=1e-9)
    order = np.argsort(values, axis=None, kind="stable")
    assert (np.diff(shown.ravel()[order]) >= 0.0).all()


@given(IMAGES, st.floats(0.1, 50.0), st.floats(-100.0, 100.0))
def test_the_exponent_does_not_depend_on_the_unit_of_gray(values, scale, offset):
    assert automatic_gamma(scale * values + offset) == pytest.approx(automatic_gamma(values), abs=1e-3)


def two_levels(share):
    """An image of which a share of the pixels is bright and the rest dark, with a few in between."""
    values = np.zeros(1000)
    values[: round(1000 * share)] = 1.0
    values[480:520] = 0.5
    return values.reshape(25, 40)


@pytest.mark.parametrize(("share", "gamma"), [(0.1, 0.5), (0.9, 0.7), (0.5, 1.0)])
def test_a_background_decides_on_the_exponent(share, gamma):
    assert automatic_gamma(two_levels(share)) == pytest.approx(gamma)


def test_a_pale_disk_is_found_beside_one_ten_times_as_bright():
    """Its edge is a tenth of the strongest, below the floor; on the square-root scale it is about a third."""
    pale, bright = (disk((90, 150), (45.3, col), 18.0).values for col in (38.6, 110.2))
    image = 10.0 + 0.08 * (pale - pale.min()) + (bright - bright.min())
    centers = {}
    for gamma in (1.0, "auto"):
        found = segment(image, uniform_grid(image.shape), Parameters(gamma=gamma, edge_floor=0.2, scales=2)).contours
        centers[gamma] = sorted(np.mean(contour.box, axis=0)[1] for contour in found if contour.closed)
    assert centers[1.0] == pytest.approx([110.2], abs=0.5)
    assert centers["auto"] == pytest.approx([38.6, 110.2], abs=0.5)
