"""Gray levels: what stands for no data is told and makes no edges, and the scale of the values changes no contour."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.image.geometry import Geometry
from cpm_core.image.gray_levels import (
    NO_DATA_VALUE,
    find_gray_ends,
    find_shown_range,
    limit_specks,
    make_usable,
    merge_gray_ends,
)
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions

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


def soft_disk(side=72, radius=16.0, noise=4.0):
    row, col = np.indices((side, side))
    away = np.hypot(row - 36, col - 36)
    return (
        300.0 + 120.0 / (1.0 + np.exp(2.0 * (away - radius))) + np.random.default_rng(1).normal(0.0, noise, away.shape)
    )


def area_found(values, seeds, smoothing):
    found = cpm.segment(values, seeds, cpm.Parameters(smoothing=smoothing)).contours
    return max((contour.area for contour in found if contour.closed), default=0.0)


@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 2**16),
    count=st.integers(1, 10),
    level=st.sampled_from([-1e6, 0.0, 700.0, 2e3, 65535.0, 1e6]),
    size=st.integers(1, 2),
    smoothing=st.sampled_from([1.0, 2.0, 3.0, 4.0]),
    grid=st.booleans(),
)
def test_hot_and_dead_pixels_hide_no_object(seed, count, level, size, smoothing, grid):
    values, rng = soft_disk(), np.random.default_rng(seed)
    seeds = cpm.uniform_grid(values.shape) if grid else cpm.circle((36, 36), 8)
    wanted = area_found(values, seeds, smoothing)
    for row, col in rng.integers(0, 71, (count, 2)):
        away = np.hypot(row - 36, col - 36)
        if abs(away - 16) > 3 * smoothing + 4:  # on the boundary it would be one of its dents
            values[row : row + size, col : col + size] = level
    assert area_found(values, seeds, smoothing) == pytest.approx(wanted, rel=0.03)


@pytest.mark.parametrize(
    "values",
    [
        DISK,
        soft_disk(),
        np.where((ROW == 20) & (COL > 5) & (COL < 15), 200.0, 50.0),  # a short line of one pixel
        np.where(ROW == COL, 65535, np.random.default_rng(0).integers(0, 9, ROW.shape)).astype(np.uint16),
        np.where((ROW == 7) & (COL == 9), 200.0, 50.0),  # nothing but a speck
        np.indices((8, 8)).sum(axis=0) % 2,
        soft_disk()[None].repeat(5, axis=0),
    ],
)
def test_what_is_no_speck_keeps_its_gray_levels(values):
    assert limit_specks(values) is values


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("shape", [(40, 50), (12, 14, 16)])
def test_specks_are_limited_in_any_type_and_also_at_the_border(kind, shape):
    values = np.random.default_rng(2).integers(20, 30, shape).astype(kind)
    for corner in (0, -1):
        one = values.copy()
        one[(corner,) * len(shape)], one[(5,) * len(shape)] = 125, 0
        limited = limit_specks(one)
        assert limited.dtype == kind
        assert (limited.min(), limited.max()) == (20, 29)
        assert np.array_equal(limited, np.clip(one, 20, 29))


@pytest.mark.parametrize("width", [1, 3])
@pytest.mark.parametrize("grid", [False, True])
def test_a_bright_rim_hides_no_object(width, grid):
    values = soft_disk()
    seeds = cpm.uniform_grid(values.shape) if grid else cpm.circle((36, 36), 8)
    rim = np.pad(values[width:-width, width:-width], width, constant_values=65535.0)
    inside = [one for one in cpm.segment(rim, seeds).contours if one.closed and one.points.min() > 8]
    assert max(one.area for one in inside) == pytest.approx(area_found(values, seeds, 1.0), rel=0.03)


def test_parts_of_an_image_give_the_ends_of_the_whole():
    values = soft_disk()
    values[31:33, 32], values[10, 50], values[:2], values[4, 9] = 65535.0, -9.0, 2e5, 9e5
    parts = [np.s_[at : at + 24, left : left + 36] for at in (0, 24, 48) for left in (0, 36)]
    whole = find_gray_ends(values)
    assert merge_gray_ends(find_gray_ends(values, part) for part in parts) == whole
    assert whole.usable == (whole.dark, whole.bright)


PADDINGS = [-2000.0, -1024.0, 0.0, 65535.0]


def pad(values, level, kind):
    """Write a level outside of a circle, in a band, or on both sides of a turned picture."""
    row, col = np.indices(values.shape)
    outside = {
        "circle": np.hypot(row - 35.5, col - 35.5) > 34.5,
        "band": row < 6,
        "turned": np.abs(row + col - 71) > 60,
    }
    return np.where(outside[kind], level, values)


paddings = st.tuples(st.sampled_from(PADDINGS), st.sampled_from(["circle", "band", "turned"]))


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**16),
    hot=st.lists(st.sampled_from([-1e6, 0.0, 65535.0, 1e6]), max_size=4),
    padding=st.none() | paddings,
    kind=st.sampled_from([np.float32, np.float64]),
)
def test_what_is_shown_survives_hot_pixels_and_padding(seed, hot, padding, kind):
    values = soft_disk()
    values = values if padding is None else pad(values, *padding)
    for level, (row, col) in zip(hot, np.random.default_rng(seed).integers(12, 60, (len(hot), 2)), strict=True):
        values[row, col] = level
    low, high = find_shown_range(values.astype(kind))
    assert 270.0 < low < 310.0
    assert 400.0 < high < 450.0


@pytest.mark.parametrize(
    "values", [DISK, np.where(ROW > 40, 2, DISK), np.linspace(0.0, 1.0, 64).reshape(8, 8), np.full((8, 8), 3.0)]
)
def test_without_hot_pixels_and_padding_all_is_shown(values):
    assert find_shown_range(values) == (values.min(), values.max())


@settings(max_examples=12, deadline=None)
@given(
    padding=paddings, preset=st.sampled_from(["shape", "automatic", "noisy"]), grid=st.booleans(), floor=st.booleans()
)
def test_in_a_region_of_interest_no_padding_around_it_hides_an_object(padding, preset, grid, floor):
    values = pad(soft_disk(), *padding)
    seeds = cpm.uniform_grid(values.shape) if grid else cpm.circle((36, 36), 8)
    parameters = replace(cpm.PRESETS[preset], edge_floor=0.1) if floor else cpm.PRESETS[preset]
    corners = np.array([(16, 16), (16, 56), (56, 56), (56, 16)], float)
    found = cpm.segment(values, seeds, parameters, regions=Regions(interest=(corners,))).contours
    assert max(one.area for one in found if one.closed) == pytest.approx(np.pi * 16.0**2, rel=0.04)


@pytest.mark.parametrize("lowest", [-1024.0, -1000.0, -2000.0, -3024.0])
@pytest.mark.parametrize("dead", [None, -32768.0, 32767.0])
def test_air_makes_a_ct_whatever_lies_outside_its_circle_and_padding_makes_none(lowest, dead):
    rng = np.random.default_rng(3)
    body = rng.uniform(-1000.0, 1500.0, (12, 24, 24))
    organ = rng.uniform(0.0, 900.0, body.shape)
    for values, is_ct in ((body, True), (organ, False)):
        padded = values.copy()
        padded[:, :4] = lowest
        if dead is not None:
            padded[6, 12, 12] = dead
        assert Image(padded, geometry=Geometry()).is_ct == is_ct
