"""OME-Zarr: axes in any order come as channels, planes, rows and columns, with the size of each."""

import itertools
import tempfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import load_image, load_volume
from cpm_core.formats.images.ome_zarr import open_multiscale
from cpm_core.formats.images.readers import open_stack
from cpm_core.formats.images.reading import Reading

zarr = pytest.importorskip("zarr")

SIZES = {"t": 2, "c": 3, "z": 9, "y": 10, "x": 11}
SIDES = {"t": 1.0, "c": 1.0, "z": 2.0, "y": 0.5, "x": 0.25}
KINDS = {"t": "time", "c": "channel", "z": "space", "y": "space", "x": "space"}
VALUES = np.arange(np.prod(list(SIZES.values()))).reshape(tuple(SIZES.values()))
"""Axes TCZYX."""


def write(path, axes, unit="micrometer", scale=None):
    """The first part along every axis that is left out."""
    part = VALUES[tuple(slice(None) if axis in axes else 0 for axis in SIZES)]
    kept = [axis for axis in SIZES if axis in axes]
    group = zarr.open_group(path, mode="w", zarr_format=2)
    group.create_array("0", data=np.ascontiguousarray(part.transpose([kept.index(axis) for axis in axes])))
    named = [{"name": a, "type": KINDS[a], **({"unit": unit} if unit and a in "zyx" else {})} for a in axes]
    level = {"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [SIDES[a] for a in axes]}]}
    group.attrs["multiscales"] = [{"version": "0.4", "axes": named, "datasets": [level]}]
    return path


ORDERS = ["".join(order) for more in ("", "t", "c", "tc") for order in itertools.permutations((*more, "z", "y", "x"))]


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(ORDERS), st.integers(1, 3), st.integers(1, 2))
def test_axes_in_any_order_are_the_same_volume(axes, channel, time):
    channel, time = channel if "c" in axes else 1, time if "t" in axes else 1
    with tempfile.TemporaryDirectory() as folder:
        path = write(f"{folder}/a.zarr", axes)
        volume = load_volume(path, channel=channel, time=time)
        np.testing.assert_array_equal(volume.values, VALUES[time - 1, channel - 1])
        assert (volume.spacing, volume.unit) == ((2.0, 0.5, 0.25), "µm")
        np.testing.assert_array_equal(
            load_image(path, channel=channel, time=time, page=3).values, VALUES[time - 1, channel - 1, 2]
        )


@pytest.mark.parametrize("axes", ["yx", "xy", "xcy"])
def test_rows_and_columns_of_an_image_are_told_by_their_letters(tmp_path, axes):
    image = load_image(write(tmp_path / "a.zarr", axes), channel=1)
    np.testing.assert_array_equal(image.values, VALUES[0, 0, 0])
    assert (image.spacing, image.unit) == ((0.5, 0.25), "µm")


def test_a_window_is_along_planes_rows_and_columns_whatever_the_order(tmp_path):
    levels = open_multiscale(write(tmp_path / "a.zarr", "xyz"))
    window = (slice(1, 4), slice(2, 4), slice(5, 6))
    np.testing.assert_array_equal(levels.read_window(window, Reading()), VALUES[0, 0][window])


def test_without_a_unit_the_sides_keep_their_ratio(tmp_path):
    volume = load_volume(write(tmp_path / "a.zarr", "zyx", None))
    assert (volume.spacing, volume.unit) == ((8.0, 2.0, 1.0), None)


def test_units_may_differ_from_axis_to_axis(tmp_path):
    path = write(tmp_path / "a.zarr", "zyx")
    group = zarr.open_group(path, mode="a")
    scales = group.attrs["multiscales"]
    scales[0]["axes"][0]["unit"] = "nanometer"
    group.attrs["multiscales"] = scales
    volume = load_volume(path)
    assert (volume.spacing, volume.unit) == (pytest.approx((2e-3, 0.5, 0.25)), "µm")


def test_channels_have_the_names_and_colors_that_are_stated(tmp_path):
    path = write(tmp_path / "a.zarr", "cyx")
    assert open_stack(path).channel_styles == ()
    stated = [{"label": "DAPI", "color": "0000FF"}, {"label": "GFP"}, {"color": "FFFFFF"}]
    zarr.open_group(path).attrs["omero"] = {"channels": stated}
    assert open_stack(path).channel_styles == (("DAPI", "#0000ff"), ("GFP", ""), ("", "#ffffff"))
