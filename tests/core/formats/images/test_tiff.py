"""TIFF: depth, photometry, pages and the size of a pixel arrive as the file means them."""

import numpy as np
import pytest
import tifffile

from cpm_core.formats import load_image, load_pages
from cpm_core.formats.images.readers import open_stack

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


@pytest.mark.parametrize("planar", ["contig", "separate"])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_samples_of_a_gray_page_are_channels(tmp_path, count, planar):
    bands = np.stack([RAMP + band for band in range(count)]).astype(np.uint16)
    stored = bands if planar == "separate" else np.moveaxis(bands, 0, -1)
    extra = ["unspecified"] * (count - 1)
    tifffile.imwrite(
        tmp_path / "a.tif", stored, photometric="minisblack", planarconfig=planar, extrasamples=extra, metadata=None
    )
    assert load_image(tmp_path / "a.tif").notes == (f"Only the first of its {count} channels was taken.",)
    for band in range(count):
        assert np.array_equal(load_image(tmp_path / "a.tif", channel=band + 1).values, bands[band])
    with pytest.raises(ValueError, match=f"a.tif has {count} of them"):
        load_image(tmp_path / "a.tif", channel=count + 1)


@pytest.mark.parametrize("planar", ["contig", "separate"])
def test_colors_with_infrared_are_one_image_unless_a_channel_is_chosen(tmp_path, planar):
    bands = np.stack([RAMP, 2 * RAMP, 3 * RAMP, 4 * RAMP]).astype(np.uint16)
    stored = bands if planar == "separate" else np.moveaxis(bands, 0, -1)
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="rgb", planarconfig=planar, extrasamples=["unspecified"])
    image = load_image(tmp_path / "a.tif")
    assert np.allclose(image.values, 0.2125 * bands[0] + 0.7154 * bands[1] + 0.0721 * bands[2])
    assert image.notes[0] == "Only the first 3 of its 4 channels were taken."
    for band in range(4):
        assert np.array_equal(load_image(tmp_path / "a.tif", channel=band + 1).values, bands[band])
    assert len(load_pages(tmp_path / "a.tif")) == 1


def write_imagej(path, values, lines):
    tifffile.imwrite(path, values, photometric="minisblack", description=f"ImageJ=1.54f\n{lines}", metadata=None)


@pytest.mark.parametrize(
    ("lines", "curve"),
    [
        ("cf=0\nc0=-32768.0\nc1=1.0\n", lambda x: x - 32768),
        ("cf=0\nc0=3\nc1=-2\n", lambda x: 3 - 2 * x),
        ("cf=1\nc0=1.5\nc1=0\nc2=0.25\n", lambda x: 1.5 + 0.25 * x**2),
        ("cf=3\nc0=0\nc1=1\nc2=0\nc3=0\nc4=1e-6\n", lambda x: x + 1e-6 * x**4),
    ],
)
def test_gray_levels_are_those_of_the_calibration_of_imagej(tmp_path, lines, curve):
    write_imagej(tmp_path / "a.tif", RAMP.astype(np.uint16), lines)
    image = load_image(tmp_path / "a.tif")
    assert np.allclose(image.values, curve(RAMP.astype(float)))
    assert image.notes == ("Gray levels were calibrated as its description says.",)


def test_a_calibration_of_imagej_that_is_not_applied_is_told(tmp_path):
    write_imagej(tmp_path / "a.tif", RAMP.astype(np.uint16), "cf=4\nc0=1\nc1=2\n")
    image = load_image(tmp_path / "a.tif")
    assert np.array_equal(image.values, RAMP)
    assert image.notes == ("Its description calibrates gray levels by a curve, which was not applied.",)


OME = (
    '<?xml version="1.0" encoding="UTF-8"?>{doctype}<{p}OME xmlns{c}="http://www.openmicroscopy.org/Schemas/OME/2016-06">'
    '<{p}Image ID="Image:0"><{p}Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint16" SizeX="20" SizeY="12" '
    "SizeZ='1' SizeC='1' SizeT='1' PhysicalSizeX='0.25' PhysicalSizeXUnit='{unit}' PhysicalSizeY='0.5' "
    "PhysicalSizeYUnit='{unit}'><{p}Channel ID='Channel:0:0' SamplesPerPixel='1'/>"
    "<{p}TiffData IFD='0' PlaneCount='1'/></{p}Pixels></{p}Image></{p}OME>"
)


def write_ome(path, unit="mm", prefix="", doctype=""):
    text = OME.format(unit=unit, p=prefix and f"{prefix}:", c=prefix and f":{prefix}", doctype=doctype)
    tifffile.imwrite(path, RAMP.astype(np.uint16), description=text.encode(), metadata=None)


@pytest.mark.parametrize("unit", ["µm", "&#181;m", "&#xB5;m", "&#x3bc;m", "&#x75;m", "micrometer"])
@pytest.mark.parametrize("prefix", ["", "OME"])
def test_the_metadata_of_ome_are_read_as_xml(tmp_path, unit, prefix):
    write_ome(tmp_path / "a.ome.tif", unit, prefix)
    image = load_image(tmp_path / "a.ome.tif")
    assert (image.spacing, image.unit) == ((0.5, 0.25), "µm")


@pytest.mark.parametrize("unit", ["&unknown;", "mm' <", "&big;"])
def test_metadata_of_ome_that_are_no_plain_xml_leave_the_size_unknown(tmp_path, unit):
    doctype = '<!DOCTYPE x [<!ENTITY big "mm">]>' if unit == "&big;" else ""
    write_ome(tmp_path / "a.ome.tif", unit, doctype=doctype)
    image = load_image(tmp_path / "a.ome.tif")
    assert np.array_equal(image.values, RAMP)
    assert (image.spacing, image.unit) == ((1.0, 1.0), None)


@pytest.mark.parametrize("unit", ["um", "micron", "\\u00B5m"])
def test_imagej_tells_the_size_of_a_pixel(tmp_path, unit):
    tifffile.imwrite(
        tmp_path / "a.tif", RAMP.astype(np.uint16), imagej=True, resolution=(4, 2), metadata={"unit": unit}
    )
    image = load_image(tmp_path / "a.tif")
    assert image.spacing == pytest.approx((0.5, 0.25))
    assert image.unit == "µm"


@pytest.mark.parametrize(("axes", "asked"), [("CYX", False), ("TYX", False), ("ZYX", True)])
def test_only_several_planes_need_a_distance(tmp_path, axes, asked):
    stack = np.stack([RAMP.astype(np.uint16)] * 3)
    tifffile.imwrite(tmp_path / "a.tif", stack, imagej=True, resolution=(4, 4), metadata={"axes": axes, "unit": "um"})
    assert bool(open_stack(tmp_path / "a.tif").volume_notes) == asked


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
