"""Gray levels: what stands for no data is told and makes no edges, and the scale of the values changes no contour."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.image.gray_levels import NO_DATA_VALUE, make_usable
from cpm_core.image.image import Image

ROW, COL = np.mgrid[:48, :48]
DISK = np.where(np.hypot(ROW - 20, COL - 20) < 12, 200.0, 50.0)
SEEDS = cpm.circle((20, 20), 6)


@pytest.fixture(scope="module")
def length():
    (contour,) = cpm.segment(DISK, SEEDS).contours
    return contour.length


@settings(max_examples=6, deadline=None)
@given(power=st.sampled_from([-305, -100, -60, -20, -13, -5, 5, 13, 34, 60, 150, 305]))
def test_the_unit_of_the_gray_levels_changes_no_contour(length, power):
    (contour,) = cpm.segment(DISK * 10.0**power, SEEDS).contours
    assert contour.length == pytest.approx(length, abs=1e-3)


@pytest.mark.parametrize(
    "value", [-3.4028234663852886e38, -3.4e38, 9.969209968386869e36, NO_DATA_VALUE, 1.7976931348623157e308]
)
def test_pixels_without_data_are_told_and_make_no_edges(length, value):
    values = DISK.copy()
    values[36:, 30:] = value
    image = Image(values, notes=("first",))
    assert image.notes == ("first", "216 pixels have no data, filled from around: contours there mean nothing.")
    assert np.array_equal(image.values[:36], DISK[:36])
    assert 50 <= image.values.min() <= image.values.max() <= 200
    assert cpm.edge_map(image.values)[34:, 28:].max() < 0.5
    (contour,) = cpm.segment(image, SEEDS).contours
    assert contour.length == pytest.approx(length, abs=0.01)


def test_an_object_near_pixels_without_data_has_no_edge_there():
    rows, cols = np.mgrid[:40, :48]
    values = 20.0 + 100.0 * (np.hypot(rows - 20, cols - 24) < 10)  # two rows of background before the missing ones
    image = Image(np.where(rows < 8, NO_DATA_VALUE, values))
    assert np.allclose(image.values[:8], 20.0)
    (contour,) = cpm.segment(image, cpm.circle((20, 24), 14), cpm.Parameters(scales=1)).contours
    assert contour.points[:, 0].min() > 9.0


@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1), share=st.floats(0.01, 0.99), shape=st.tuples(st.integers(8, 33), st.integers(8, 33))
)
def test_what_is_filled_lies_between_the_known_levels(seed, share, shape):
    rng = np.random.default_rng(seed)
    values = rng.uniform(-5, 5, shape)
    absent = rng.uniform(size=shape) < share
    absent.flat[:2], absent.flat[2] = False, True
    found, notes = make_usable(np.where(absent, NO_DATA_VALUE, values), (NO_DATA_VALUE, float(values[~absent].max())))
    assert np.array_equal(found[~absent], values[~absent])
    assert values[~absent].min() - 1e-9 <= found.min() <= found.max() <= values[~absent].max() + 1e-9
    (note,) = notes
    assert note.startswith(f"{absent.sum()} pixel{' has' if absent.sum() == 1 else 's have'} ")
