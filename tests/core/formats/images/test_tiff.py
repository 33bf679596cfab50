"""TIFF: depth, photometry, pages and the size of a pixel arrive as the file means them."""

import numpy as np
import pytest
import tifffile

from cpm_core.formats import load_image

RAMP = np.arange(12 * 20).reshape(12, 20)


@pytest.mark.parametrize("planar", ["contig", "separate"])
def test_sixteen_bit_colour_becomes_luminance_in_full_depth(tmp_path, planar):
    channels = np.stack([RAMP * 200, RAMP * 100, RAMP * 50]).astype(np.uint16)
    stored = channels if planar == "separate" else np.moveaxis(channels, 0, -1)
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="rgb", planarconfig=planar)
    image = load_image(tmp_path / "a.tif")
    assert np.allclose(image.values, 0.2125 * channels[0] + 0.7154 * channels[1] + 0.0721 * channels[2])
    assert np.abs(image.colors.samples * 257.0 - np.moveaxis(channels, 0, -1)).max() <= 129.0
    assert image.colors.white == 65535.0


def test_alpha_is_laid_on_white(tmp_path):
    colours = np.full((10, 10, 4), 1000, dtype=np.uint16)
    colours[:5, :, 3] = 65535
    colours[5:, :, 3] = 0
    tifffile.imwrite(tmp_path / "a.tif", colours, photometric="rgb", extrasamples=["unassalpha"])
    image = load_image(tmp_path / "a.tif")
    assert np.all(image.values[:5] == 1000)
    assert np.all(image.values[5:] == 65535)


def test_channels_without_a_meaning_are_left_out_and_mentioned(tmp_path):
    channels = np.stack([RAMP, RAMP + 1], axis=2).astype(np.uint16)
    tifffile.imwrite(
        tmp_path / "a.tif", channels, photometric="minisblack", planarconfig="contig", extrasamples=["unspecified"]
    )
    image = load_image(tmp_path / "a.tif")
    assert np.array_equal(image.values, RAMP)
    assert "Only the first 1 of its 2 channels were taken." in image.notes


@pytest.mark.parametrize("unit", ["um", "micron", "\\u00B5m"])
def test_imagej_tells_the_size_of_a_pixel(tmp_path, unit):
    tifffile.imwrite(
        tmp_path / "a.tif", RAMP.astype(np.uint16), imagej=True, resolution=(4, 2), metadata={"unit": unit}
    )
    image = load_image(tmp_path / "a.tif")
    assert image.spacing == pytest.approx((0.5, 0.25))
    assert image.unit == "µm"


def test_ome_tells_the_size_of_a_pixel(tmp_path):
    metadata = {"axes": "YX", "PhysicalSizeX": 65.0, "PhysicalSizeY": 130.0}
    metadata |= {"PhysicalSizeXUnit": "nm", "PhysicalSizeYUnit": "nm"}
    tifffile.imwrite(tmp_path / "a.ome.tif", RAMP.astype(np.uint16), metadata=metadata)
    image = load_image(tmp_path / "a.ome.tif")
    assert (image.spacing, image.unit) == ((130.0, 65.0), "nm")


@pytest.mark.parametrize(
    ("resolution", "unit", "spacing"),
    [((20000, 20000), "centimeter", 0.5), ((300, 300), "inch", None), ((28.35, 28.35), "centimeter", None)],
)
def test_a_plain_resolution_is_believed_only_when_too_fine_for_print(tmp_path, resolution, unit, spacing):
    tifffile.imwrite(tmp_path / "a.tif", RAMP.astype(np.uint8), resolution=resolution, resolutionunit=unit)
    image = load_image(tmp_path / "a.tif")
    assert image.unit == (None if spacing is None else "µm")
    assert image.spacing == pytest.approx((spacing or 1.0,) * 2)


@pytest.mark.parametrize("kind", [np.int16, np.float32])
def test_the_value_that_stands_for_no_data_is_told_and_left_out(tmp_path, kind):
    values = RAMP.astype(kind)
    values[5:, 7:] = -9999
    tifffile.imwrite(tmp_path / "a.tif", values, extratags=[(42113, "s", 0, "-9999", True)])
    image = load_image(tmp_path / "a.tif")
    assert [note.startswith("91 pixels ") for note in image.notes] == [True]
    assert np.array_equal(image.values[:5], RAMP[:5])
    assert image.values.min() == 0


def test_no_data_may_be_told_to_be_no_number_or_one_color(tmp_path):
    values = RAMP.astype(np.float32)
    values[5:, 7:] = np.nan
    tifffile.imwrite(tmp_path / "a.tif", values, extratags=[(42113, "s", 0, "nan", True)])
    colors = np.stack([RAMP % 99 + 1, RAMP % 50, RAMP % 70 + 9], axis=2).astype(np.uint8)
    colors[5:, 7:] = 0
    tifffile.imwrite(tmp_path / "b.tif", colors, photometric="rgb", extratags=[(42113, "s", 0, "0", True)])
    for name, whole in (("a.tif", RAMP), ("b.tif", colors @ [0.2125, 0.7154, 0.0721])):
        image = load_image(tmp_path / name)
        assert any(note.startswith("91 pixels ") for note in image.notes)
        assert np.allclose(image.values[:5], whole[:5])
        assert image.values[5:, 7:].min() > 0


@pytest.mark.parametrize("factor", [1, 257])
def test_a_palette_of_eight_bits_in_sixteen_is_as_bright_as_one_of_sixteen(tmp_path, factor):
    levels = np.arange(256)
    table = np.stack([levels, 255 - levels, levels // 2])
    indices = (RAMP % 256).astype(np.uint8)
    stored = (table * factor).astype(np.uint16)
    tifffile.imwrite(tmp_path / "a.tif", indices, photometric="palette", colormap=stored, metadata=None)
    assert np.allclose(load_image(tmp_path / "a.tif").values, table.T[indices] @ [0.2125, 0.7154, 0.0721])
