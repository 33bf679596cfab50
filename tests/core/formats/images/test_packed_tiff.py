"""Packed TIFFs: the pixels are the same, however they are stored."""

import numpy as np
import pytest
import tifffile

from cpm_core.formats import load_image
from cpm_core.image.colors import LUMINANCE_WEIGHTS

RAMP = np.arange(24 * 20).reshape(24, 20)
KINDS = [
    (RAMP % 251).astype(np.uint8),
    (RAMP % 251 - 125).astype(np.int8),
    (RAMP * 130).astype(np.uint16),
    (RAMP * 8_000_000).astype(np.uint32),
    (RAMP * 1.5 - 300).astype(np.float32),
    RAMP * np.pi - 700,
]


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("packing", [None, "zlib", "lzw", "packbits"])
@pytest.mark.parametrize("planar", [None, 1, 2])
def test_every_type_keeps_its_values_in_every_packing(tmp_path, planar, packing, order):
    for values in KINDS:
        predicted = packing in ("zlib", "lzw") and values.dtype.kind == "u"
        colors = np.stack([values, values // 2, values[::-1]], axis=2)
        stored = values if planar is None else colors if planar == 1 else np.moveaxis(colors, -1, 0)
        kind = {"photometric": "minisblack"} if planar is None else {"photometric": "rgb", "planarconfig": planar}
        options = {"compression": packing, "predictor": predicted, "byteorder": order, "rowsperstrip": 7}
        tifffile.imwrite(tmp_path / "a.tif", stored, **kind, **options)
        wanted = values if planar is None else colors.astype(float) @ LUMINANCE_WEIGHTS
        assert np.allclose(load_image(tmp_path / "a.tif").values, wanted, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("bits", [1, 4, 12])
def test_where_white_is_zero_fewer_bits_are_inverted_within_their_range(tmp_path, bits):
    values = (RAMP % 2**bits).astype(np.bool_ if bits == 1 else np.uint8 if bits < 8 else np.uint16)
    tifffile.imwrite(tmp_path / "a.tif", values, bitspersample=bits, photometric="miniswhite", metadata=None)
    wanted = 255.0 * ~values if bits == 1 else 2.0**bits - 1.0 - values
    assert np.array_equal(load_image(tmp_path / "a.tif").values, wanted)


def test_colors_that_are_multiplied_by_their_opacity_are_so_once(tmp_path):
    colors = np.full((10, 12, 4), 20000, dtype=np.uint16)  # white, of which 20000 / 65535 is there
    tifffile.imwrite(tmp_path / "a.tif", colors, photometric="rgb", extrasamples=["assocalpha"])
    assert np.allclose(load_image(tmp_path / "a.tif").values, 65535.0)


@pytest.mark.parametrize("planes", [1, 2])
def test_four_inks_become_light(tmp_path, planes):
    inks = (np.random.default_rng(3).random((12, 10, 4)) * 255).astype(np.uint8)
    stored = inks if planes == 1 else np.ascontiguousarray(np.moveaxis(inks, -1, 0))
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="separated", planarconfig=planes, metadata=None)
    light = 255.0 * (1 - inks[..., :3] / 255.0) * (1 - inks[..., 3:] / 255.0)
    assert np.allclose(load_image(tmp_path / "a.tif").values, light @ LUMINANCE_WEIGHTS, atol=1.0)


def test_colors_that_are_not_read_are_named(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", (RAMP * 9).astype(np.uint16), photometric="cfa", metadata=None)
    with pytest.raises(ValueError, match=r"a\.tif is a TIFF of an uncommon kind \(16 bits, CFA\): save it again"):
        load_image(tmp_path / "a.tif")
