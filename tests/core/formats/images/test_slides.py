"""Whole slides and other TIFF in levels of resolution, which are too large to be read as a whole."""

import numpy as np
import pytest
import tifffile

from cpm_core import load_image
from cpm_core.chunked.grid import ChunkedSource
from cpm_core.formats.images import decoded, stack, tiff
from cpm_core.formats.images.reading import Reading

pytest.importorskip("zarr")

SIDE = 640
COLORS = np.random.default_rng(1).integers(0, 256, (SIDE, SIDE, 3), np.uint8)
LUMINANCE = COLORS @ [0.2125, 0.7154, 0.0721]


@pytest.fixture(autouse=True)
def few_pixels(monkeypatch):
    """Images of more than 300 x 300 px are too large."""
    for module in (tiff, stack, decoded):
        monkeypatch.setattr(module, "MAXIMUM_PIXELS", 300**2)


def write_slide(path, step=4, count=2, **entries):
    """A slide as scanners of Aperio write it: levels in pages of their own, after a small picture of the whole."""
    about = f"Aperio Image Library v11.2.1\r\n{SIDE}x{SIDE} (64x64) JPEG/RGB Q=70|AppMag = 20|MPP = 0.4990"
    entries = {"photometric": "rgb", "tile": (64, 64), "compression": "zlib", "metadata": None} | entries
    with tifffile.TiffWriter(path) as file:
        file.write(COLORS, description=about, **entries)
        file.write(COLORS[::8, ::8], photometric="rgb", description=about, metadata=None)
        for level in range(1, count + 1):
            file.write(COLORS[:: step**level, :: step**level], description=about, **entries)


@pytest.mark.parametrize("step", [2, 4])
def test_a_slide_opens_at_a_moderate_level_and_shows_finer_ones_in_view(tmp_path, step):
    write_slide(tmp_path / "a.svs", step)
    slide = load_image(tmp_path / "a.svs")
    side = step if SIDE // step <= 300 else step**2
    assert slide.shape == (SIDE // side,) * 2
    assert (slide.spacing, slide.unit) == (pytest.approx((0.499 * side,) * 2), "µm")
    np.testing.assert_allclose(slide.values, LUMINANCE[::side, ::side], atol=0.51)
    assert np.array_equal(slide.colors.samples, COLORS[::side, ::side])
    assert any(note.startswith(f"It has {SIDE} x {SIDE} px, of which level") for note in slide.notes)
    assert [plane.shape[0] for plane in slide.finer] == [SIDE // 2**k for k in range(round(np.log2(side)))]
    for k, plane in enumerate(slide.finer):
        part = plane[slice(7, 20), slice(30, 61)]
        np.testing.assert_allclose(part, LUMINANCE[:: 2**k, :: 2**k][7:20, 30:61], atol=0.51)


@pytest.mark.parametrize(("color", "values"), [("luminance", LUMINANCE), ("green", COLORS[..., 1])])
def test_chunks_of_a_slide_are_read_at_full_resolution(tmp_path, color, values):
    write_slide(tmp_path / "a.svs")
    source = ChunkedSource(tmp_path / "a.svs", Reading(color=color))
    assert source.shape == (SIDE, SIDE)
    window = slice(100, 380), slice(2, 301)
    np.testing.assert_allclose(source.read_grays(window), values[window], atol=0.51)


def test_channels_of_a_pyramid_are_channels(tmp_path):
    values = COLORS.transpose(2, 0, 1).astype(np.uint16) * 100
    with tifffile.TiffWriter(tmp_path / "a.ome.tif", ome=True) as file:
        axes = {"axes": "CYX", "PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5}
        file.write(values, subifds=1, photometric="minisblack", tile=(64, 64), metadata=axes)
        file.write(values[:, ::4, ::4], subfiletype=1, photometric="minisblack", tile=(64, 64))
    image = load_image(tmp_path / "a.ome.tif", channel=2)
    assert np.array_equal(image.values, values[1, ::4, ::4])
    assert image.spacing == (2.0, 2.0)
    assert np.array_equal(image.finer[0][slice(5, 9), slice(0, 70)], values[1, 5:9, :70])


def test_a_large_picture_without_levels_is_refused_as_a_whole_and_read_in_chunks(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", COLORS[..., 0], tile=(64, 64))
    with pytest.raises(ValueError, match=r"a\.tif is 640 x 640 px, more than .*: crop it or make it smaller first"):
        load_image(tmp_path / "a.tif")
    source = ChunkedSource(tmp_path / "a.tif", Reading())
    assert np.array_equal(source.read_values((slice(0, 9), slice(600, 640))), COLORS[:9, 600:, 0])
