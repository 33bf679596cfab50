"""Image: the grid of gray levels."""

import re

import numpy as np
import pytest
import scipy
import skimage

from cpm_core.image.image import MINIMUM_SIDE, Image


def test_values_become_a_read_only_float64_copy():
    given = np.arange(120, dtype=np.uint16).reshape(10, 12)
    image = Image(given)
    given[0, 0] = 999
    assert image.values.dtype == np.float64
    assert image.values[0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        image.values[0, 0] = 1


def test_an_array_that_nobody_can_write_to_is_shared():
    given = np.arange(120.0).reshape(10, 12).copy()
    read_only_view = given[:]
    read_only_view.flags.writeable = False
    assert not np.shares_memory(Image(read_only_view).values, given)
    given.flags.writeable = False
    assert Image(given).values is given


def test_masked_pixels_of_a_read_only_array_are_filled():
    given = np.arange(120.0).reshape(10, 12).copy()
    given.flags.writeable = False
    image = Image(np.ma.masked_greater(given, 100.0))
    assert (image.gray_range, image.notes) == (
        (0.0, 100.0),
        ("19 pixels have no data, filled from around: contours there mean nothing.",),
    )
    assert given.max() == 119.0


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_pixels_that_are_no_number_are_filled_as_masked_ones_are(kind):
    given = np.arange(120.0).reshape(10, 12).astype(kind)
    lacking = np.where(given > 100.0, kind(np.nan), given)
    image = Image(lacking)
    assert np.array_equal(image.values, Image(np.ma.masked_greater(given, 100.0)).values)
    assert image.notes == ("19 pixels have no data, filled from around: contours there mean nothing.",)
    both = Image(np.ma.masked_array(lacking, np.arange(120).reshape(10, 12) < 5))
    assert (both.gray_range, both.notes[0][:9]) == ((5.0, 100.0), "24 pixels")


def test_a_color_pixel_without_a_number_is_filled_too():
    samples = np.random.default_rng(1).random((10, 12, 3))
    samples[3, 4, 1] = np.nan
    image = Image(samples)
    assert np.isfinite(image.values).all()
    assert image.notes[-1].startswith("1 pixel has no data")


def test_an_image_is_an_array_for_numpy_and_its_friends():
    image = Image(np.arange(120, dtype=np.uint8).reshape(10, 12))
    assert np.asarray(image) is image.values
    assert np.array(image, np.float32).dtype == np.float32
    assert np.array(image).flags.writeable
    assert (image.dtype, image.shape, image.ndim) == (np.asarray(image).dtype, (10, 12), 2)
    with pytest.raises(ValueError, match="copy"):
        np.array(image, np.float32, copy=False)
    assert float(np.mean(image)) == 59.5
    assert np.array_equal(scipy.ndimage.gaussian_filter(image, 1.0), scipy.ndimage.gaussian_filter(image.values, 1.0))
    for function in (skimage.filters.gaussian, skimage.feature.canny, skimage.filters.median):
        assert len(function(image)) == len(function(image.values))


def test_integers_keep_their_type_and_are_converted_once_for_an_image_of_another_spacing():
    image = Image(np.arange(120, dtype=np.uint8).reshape(10, 12), notes=("first",))
    other = image.with_spacing((0.5, 0.25), "mm")
    assert image.stored.dtype == np.uint8
    assert other.values is image.values
    assert (other.spacing, other.unit, other.notes) == ((0.5, 0.25), "mm", ("first",))
    assert other.sha256 == image.sha256


def test_a_volume_has_planes_rows_and_columns():
    volume = Image(np.zeros((9, 20, 8)), spacing=(2.0, 0.5, 0.5))
    assert (volume.shape, volume.ndim, volume.spacing) == ((9, 20, 8), 3, (2.0, 0.5, 0.5))
    assert Image(np.zeros((9, 20, 8))).spacing == (1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="must be three positive numbers"):
        Image(np.zeros((9, 20, 8)), spacing=(1.0, 1.0))


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int16, np.uint32, np.float32, np.float64])
def test_every_kind_of_real_number_keeps_its_value(kind):
    values = np.arange(100).reshape(10, 10) % 2 if kind is bool else np.arange(100).reshape(10, 10)
    assert np.array_equal(Image(values.astype(kind)).values, values)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (np.zeros(64), "dot.png has 1 dimension (64,)"),
        (np.zeros((8, 8, 5)), "dot.png has 3 dimensions (8, 8, 5)"),
        (np.zeros((2, 8, 8, 3)), "dot.png has 4 dimensions"),
        (np.zeros((1, 1)), "dot.png is 1 x 1 px"),
        (np.zeros((MINIMUM_SIDE - 1, 100)), "dot.png is 7 x 100 px"),
        (np.zeros((100, 0)), "dot.png is 100 x 0 px"),
        (np.full((8, 8), np.nan), "dot.png holds no data: all its values are NaN or masked"),
        (np.where(np.eye(8) == 1, -np.inf, 0), "dot.png holds 8 infinite values"),
        (np.zeros((8, 8), dtype=complex), "dot.png holds values of type complex128"),
        (np.full((8, 8), "a"), "dot.png holds values of type <U1"),
    ],
)
def test_what_is_no_image_is_refused_in_one_sentence_that_names_it(values, words):
    with pytest.raises(ValueError, match=re.escape(words)) as caught:
        Image(values, source="dot.png")
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith(".")
