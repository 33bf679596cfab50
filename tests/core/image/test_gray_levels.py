"""Gray levels: what stands for no data is told and makes no edges, and the scale of the values changes no contour."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.image.gray_levels import NO_DATA, usable
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


@pytest.mark.parametrize("power", [-60, 34])
def test_a_change_of_scale_is_told(power):
    image = Image(DISK * 10.0**power)
    assert [note for note in image.notes if f"divided by 1e{power + 1:+d}" in note or f"1e{power + 2:+d}" in note]
    assert 0.1 <= np.ptp(image.values) <= 100


@pytest.mark.parametrize(
    "value", [-3.4028234663852886e38, -3.4e38, 9.969209968386869e36, NO_DATA, 1.7976931348623157e308]
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
    image = Image(np.where(rows < 8, NO_DATA, values))
    assert np.allclose(image.values[:8], 20.0)
    (contour,) = cpm.segment(image, cpm.circle((20, 24), 14), cpm.Parameters(scales=1)).contours
    assert contour.points[:, 0].min() > 9.0


@pytest.mark.parametrize("kind", [np.uint8, np.int32, np.float64])
def test_what_an_array_masks_has_no_data(kind):
    values = DISK.astype(kind)
    masked = np.ma.masked_array(values, np.zeros(DISK.shape, dtype=bool))
    masked.data[36:, 30:] = 0
    assert np.array_equal(Image(masked).values, masked.data)
    masked[36:, 30:] = np.ma.masked
    image = Image(masked)
    assert image.notes == ("216 pixels have no data, filled from around: contours there mean nothing.",)
    assert np.array_equal(image.values, Image(np.where(masked.mask, NO_DATA, DISK)).values)
    assert np.array_equal(cpm.partition(masked).image.values, image.values)
    assert "216 pixels have no data" in Image(np.ma.masked_invalid(np.where(masked.mask, np.nan, DISK))).notes[0]


def test_a_pixel_has_no_data_where_one_of_its_colors_is_masked():
    colors = np.ma.masked_array(np.stack([DISK, DISK / 2, DISK / 3], axis=2), False)
    colors[36:, 30:, 1] = np.ma.masked
    assert any("216 pixels have no data" in note for note in Image(colors).notes)


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1), share=st.floats(0.01, 0.99), shape=st.tuples(st.integers(8, 33), st.integers(8, 33))
)
def test_what_is_filled_lies_between_the_known_levels(seed, share, shape):
    rng = np.random.default_rng(seed)
    values = rng.uniform(-5, 5, shape)
    absent = rng.uniform(size=shape) < share
    absent.flat[:2], absent.flat[2] = False, True
    found, notes = usable(np.where(absent, NO_DATA, values))
    assert np.array_equal(found[~absent], values[~absent])
    assert values[~absent].min() - 1e-9 <= found.min() <= found.max() <= values[~absent].max() + 1e-9
    assert notes == (f"{absent.sum()} pixel{' has' if absent.sum() == 1 else 's have'} no data, filled from around: "
                     "contours there mean nothing.",)  # fmt: skip


@pytest.mark.parametrize(
    "values", [np.where(DISK > 100, 9e36, 0.0), np.full((9, 9), NO_DATA), DISK * 1e36, np.zeros((9, 9)), DISK]
)
def test_large_levels_of_an_image_are_not_taken_for_no_data(values):
    assert not [note for note in Image(values).notes if "no data" in note]


@pytest.mark.parametrize(
    "call",
    [
        lambda values: cpm.segment(values, SEEDS),
        cpm.edge_map,
        cpm.Image,
        cpm.skeleton,
        cpm.electric_field,
        lambda values: cpm.electric_field(values, "pppm"),
        lambda values: cpm.gradient_threshold(values, 0.5),
        cpm.divergence_centers,
        lambda values: cpm.coulomb_force(values[:, :2]),
    ],
)
def test_complex_numbers_do_not_lose_their_imaginary_part(call):
    with pytest.raises(ValueError, match=r"complex128.*real numbers"):
        call(DISK + 1j)
