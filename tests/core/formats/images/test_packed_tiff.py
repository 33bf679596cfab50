"""Packed TIFFs: the pixels are the same, however they are stored."""

import io
import struct

import numpy as np
import PIL.Image
import pytest
import tifffile
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.formats import load_image
from cpm_core.image.colors import WEIGHTS

RAMP = np.arange(24 * 20).reshape(24, 20)
LZW, ZSTD, DEFLATE, NONE = 5, 50000, 8, 1
PILLOW = {LZW: "tiff_lzw", DEFLATE: "tiff_adobe_deflate"}
KINDS = [
    (RAMP % 251).astype(np.uint8),
    (RAMP % 251 - 125).astype(np.int8),
    (RAMP * 130).astype(np.uint16),
    (RAMP * 130 - 31000).astype(np.int16),
    (RAMP * 8_000_000).astype(np.uint32),
    (RAMP * 4_000_000 - 1_000_000_000).astype(np.int32),
    (RAMP * 2**40).astype(np.uint64),
    (RAMP / 4 - 60).astype(np.float16),
    (RAMP * 1.5 - 300).astype(np.float32),
    RAMP * np.pi - 700,
]


def compressed(content, width, compression):
    """Rows of bytes as libtiff packs them."""
    if compression == NONE:
        return content
    if compression == ZSTD:  # a frame of one block that is stored as it is: not every Pillow can write more
        assert 256 <= len(content) < 65536
        block = (len(content) << 3 | 1).to_bytes(3, "little")
        return b"\x28\xb5\x2f\xfd\x60" + (len(content) - 256).to_bytes(2, "little") + block + content
    stream = io.BytesIO()
    rows = np.frombuffer(content, np.uint8).reshape(-1, width)
    # one strip, and no differences
    PIL.Image.fromarray(rows).save(stream, "TIFF", compression=PILLOW[compression], tiffinfo={278: len(rows)})
    stream.seek(0)
    with tifffile.TiffFile(stream) as file:
        page = file.pages.first
        assert len(page.dataoffsets) == 1
        return stream.getvalue()[page.dataoffsets[0] :][: page.databytecounts[0]]


def write(path, content, shape, bits, *, compression=LZW, form=1, order="<", **more):
    """A TIFF of one strip with the given entries."""
    row = len(content) // shape[0]
    packed = compressed(content, row, compression)
    packed += b"\0" * (len(packed) % 2)
    channels = more.pop("channels", 1)
    entries = {256: shape[1], 257: shape[0], 258: bits, 259: compression, 262: 1, 273: 8, 274: 1, 277: channels}
    entries |= {278: shape[0], 279: len(packed), 317: 1, 339: form}
    entries |= {int(tag[1:]): value for tag, value in more.items()}
    rows = b""
    for tag, value in sorted(entries.items()):
        rows += struct.pack(order + "HHII", tag, 4, 1, value)
    head = struct.pack(order + "2sHI", b"II" if order == "<" else b"MM", 42, 8 + len(packed))
    path.write_bytes(head + packed + struct.pack(order + "H", len(entries)) + rows + bytes(4))


def write_values(path, values, **more):
    order = more.get("order", "<")
    form = {"u": 1, "i": 2, "f": 3}[values.dtype.kind]
    content = values.astype(values.dtype.newbyteorder(order)).tobytes()
    write(path, content, values.shape, 8 * values.dtype.itemsize, form=form, **more)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("compression", [LZW, ZSTD])
@pytest.mark.parametrize("values", KINDS, ids=lambda values: values.dtype.name)
def test_every_type_keeps_its_values_in_every_packing(tmp_path, values, compression, order):
    write_values(tmp_path / "a.tif", values, compression=compression, order=order)
    assert np.array_equal(load_image(tmp_path / "a.tif").values, values)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("compression", ["tiff_lzw", "jpeg", "packbits", "group4", "tiff_adobe_deflate"])
def test_a_page_is_turned_once_whatever_its_packing(tmp_path, compression, orientation):
    values = ((RAMP // 20 < 12) & (RAMP % 20 < 5)).astype(np.uint8) * 255
    picture = PIL.Image.fromarray(values)
    if compression == "group4":
        picture = picture.convert("1")
    PIL.Image.fromarray(values).save(tmp_path / "plain.tif", tiffinfo={274: orientation})
    picture.save(
        tmp_path / "a.tif",
        compression=compression,
        tiffinfo={274: orientation, 282: 30000.0, 283: 60000.0, 296: 3},
    )
    image, plain = load_image(tmp_path / "a.tif"), load_image(tmp_path / "plain.tif")
    assert image.values.shape == plain.values.shape
    assert np.abs(image.values - plain.values).max() <= 30  # JPEG
    finer_along = 1 if orientation > 4 else 0
    assert image.spacing[finer_along] == pytest.approx(image.spacing[1 - finer_along] / 2)


@settings(max_examples=25, deadline=None)
@given(bits=st.integers(2, 15), compression=st.sampled_from([NONE, LZW, DEFLATE]), width=st.integers(8, 19))
def test_samples_of_any_number_of_bits_are_unpacked(tmp_path_factory, bits, compression, width):
    values = (np.arange(10 * width).reshape(10, width) * 7 % 2**bits).astype(np.uint16)
    each = (values[..., None] >> np.arange(bits - 1, -1, -1)) & 1
    path = tmp_path_factory.mktemp("bits") / "a.tif"
    content = np.packbits(each.reshape(10, -1).astype(np.uint8), axis=1).tobytes()
    write(path, content, values.shape, bits, compression=compression)
    assert np.array_equal(load_image(path).values, values)


@pytest.mark.parametrize("compression", [LZW, DEFLATE])
@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_differences_of_real_numbers_are_summed(tmp_path, kind, compression):
    values = (RAMP * 1.25 - 77).astype(kind)
    high_first = values.astype(values.dtype.newbyteorder(">")).view(np.uint8).reshape(24, 20, -1)
    rows = high_first.transpose(0, 2, 1).reshape(24, -1)
    content = np.diff(rows, axis=1, prepend=np.uint8(0)).tobytes()
    write(tmp_path / "a.tif", content, (24, 20), 8 * values.itemsize, form=3, compression=compression, t317=3)
    assert np.array_equal(load_image(tmp_path / "a.tif").values, values)


def test_differences_of_whole_numbers_are_summed(tmp_path):
    values = (RAMP * 130).astype(np.uint16)
    write_values(tmp_path / "a.tif", np.diff(values, axis=1, prepend=np.uint16(0)), t317=2)
    assert np.array_equal(load_image(tmp_path / "a.tif").values, values)


@pytest.mark.parametrize("compression", [NONE, LZW])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
def test_where_white_is_zero_every_packing_is_inverted(tmp_path, kind, compression):
    values = RAMP.astype(kind)
    write_values(tmp_path / "a.tif", values, compression=compression, t262=0)
    assert np.array_equal(load_image(tmp_path / "a.tif").values, float(np.iinfo(kind).max) - values)


@pytest.mark.parametrize("order", ["<", ">"])
def test_colors_of_sixteen_bits_stay_deep_in_a_packed_file(tmp_path, order):
    colors = np.stack([RAMP * 100, RAMP * 50, RAMP * 131], axis=2).astype(np.uint16)
    content = colors.astype(colors.dtype.newbyteorder(order)).tobytes()
    write(tmp_path / "a.tif", content, RAMP.shape, 16, order=order, channels=3, t262=2, t284=1)
    assert np.allclose(load_image(tmp_path / "a.tif").values, colors @ [0.2125, 0.7154, 0.0721])


def test_strips_and_tiles_of_a_packed_file_come_to_their_places(tmp_path):
    values = (np.arange(100 * 90).reshape(100, 90) * 7).astype(np.uint16)
    PIL.Image.fromarray(values).save(tmp_path / "a.tif", compression="tiff_lzw", tiffinfo={278: 7})
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert len(file.pages.first.dataoffsets) > 1
    assert np.array_equal(load_image(tmp_path / "a.tif").values, values)


def test_colors_that_are_multiplied_by_their_opacity_are_so_once(tmp_path):
    colors = np.full((10, 12, 4), 20000, dtype=np.uint16)  # white, of which 20000 / 65535 is there
    tifffile.imwrite(tmp_path / "a.tif", colors, photometric="rgb", extrasamples=["assocalpha"])
    assert np.allclose(load_image(tmp_path / "a.tif").values, 65535.0)


def same_as_tifffile(path, *, planar, order):
    """Whether a page is read as tifffile reads it, in gray and upright; or why it is refused."""
    true = tifffile.imread(path).astype(float)
    gray = true if planar is None else (true if planar == 1 else np.moveaxis(true, 0, -1)) @ WEIGHTS
    try:
        found = load_image(path).values
    except ValueError as error:
        return str(error)
    wanted = np.rot90(gray, -1) if order == 6 else gray
    return found.shape == wanted.shape and np.allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def write_by_tifffile(path, values, packing, predictor, planar, order):
    """Whether tifffile can write such a page."""
    data = {None: values, 1: np.stack([values, values // 2, values[::-1]], axis=2)}
    data[2] = np.moveaxis(data[1], -1, 0)
    lossless = {"jpeg2000": {"level": 0}, "jpegxl": {"lossless": True}, "webp": {"lossless": True}}
    settings = {"photometric": "minisblack"} if planar is None else {"photometric": "rgb", "planarconfig": planar}
    settings |= {"compression": packing, "predictor": predictor, "compressionargs": lossless.get(packing)}
    try:
        tifffile.imwrite(path, data[planar], extratags=[(274, 3, 1, order, True)], **settings)
        tifffile.imread(path)
    except Exception:  # tifffile raises anything where a packing lacks a kind of sample
        return False
    return True


@pytest.mark.parametrize("planar", [None, 1, 2])
@pytest.mark.parametrize(
    "packing", [None, "zlib", "lzma", "lzw", "zstd", "packbits", "jpeg2000", "jpegxl", "lerc", "png"]
)
def test_every_packing_kind_and_arrangement_is_read_as_tifffile_does_or_refused_in_a_sentence(
    tmp_path, packing, planar
):
    if packing not in (None, "zlib", "lzma"):
        pytest.importorskip("imagecodecs", reason="tifffile packs so with imagecodecs")
    written = 0
    for values in KINDS:
        predictors = (None, *((2, 3) if values.dtype.kind == "f" else (2,)))
        for predictor in predictors if packing in ("zlib", "lzw", "zstd") else (None,):
            for order in (1, 6):
                path = tmp_path / f"{values.dtype}-{predictor}-{order}.tif"
                if write_by_tifffile(path, values, packing, predictor, planar, order):
                    read = same_as_tifffile(path, planar=planar, order=order)
                    assert read is True or "imagecodecs" in read, (path.name, read)
                    written += 1
    assert written >= (0 if planar and packing in ("lerc", "jpegxl") else 4)


@pytest.mark.parametrize("compression", [NONE, LZW])
@pytest.mark.parametrize("bits", [1, 2, 4, 7, 12])
def test_where_white_is_zero_fewer_bits_are_inverted_within_their_range(tmp_path, bits, compression):
    values = RAMP % 2**bits
    each = (values[..., None] >> np.arange(bits - 1, -1, -1)) & 1
    content = np.packbits(each.reshape(24, -1).astype(np.uint8), axis=1).tobytes()
    write(tmp_path / "a.tif", content, values.shape, bits, compression=compression, t262=0)
    white = 255.0 if bits == 1 else 2.0**bits - 1.0
    assert np.array_equal(load_image(tmp_path / "a.tif").values, white - values * (255 if bits == 1 else 1))


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("compression", [NONE, LZW])
def test_numbers_of_three_bytes_are_refused(tmp_path, compression, order):
    write(tmp_path / "a.tif", RAMP.astype("u1").tobytes() * 3, RAMP.shape, 24, compression=compression, order=order)
    with pytest.raises(ValueError, match=r"a\.tif is damaged or a TIFF of an uncommon kind"):
        load_image(tmp_path / "a.tif")


def test_opacity_of_twelve_bits_is_full_where_all_are_set(tmp_path):
    levels = np.stack([RAMP * 8, np.full(RAMP.shape, 4095)], axis=2)
    each = (levels[..., None] >> np.arange(11, -1, -1)) & 1
    content = np.packbits(each.reshape(24, -1).astype(np.uint8), axis=1).tobytes()
    write(tmp_path / "a.tif", content, RAMP.shape, 12, compression=NONE, channels=2, t284=1, t338=2)
    assert np.array_equal(load_image(tmp_path / "a.tif").values, RAMP * 8)


@pytest.mark.parametrize("planes", [1, 2])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_four_inks_of_any_depth_become_light(tmp_path, kind, planes):
    white = float(np.iinfo(kind).max)
    inks = (np.random.default_rng(3).random((12, 10, 4)) * white).astype(kind)
    stored = inks if planes == 1 else np.ascontiguousarray(np.moveaxis(inks, -1, 0))
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="separated", planarconfig=planes, metadata=None)
    light = white * (1 - inks[..., :3] / white) * (1 - inks[..., 3:] / white)
    assert np.allclose(load_image(tmp_path / "a.tif").values, light @ WEIGHTS, atol=1.0)


def test_colors_that_are_not_read_are_named(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", (RAMP * 9).astype(np.uint16), photometric="cfa", metadata=None)
    with pytest.raises(ValueError, match=r"a\.tif is a TIFF with colors of the kind CFA, .* save it again"):
        load_image(tmp_path / "a.tif")


def test_colors_in_a_file_that_pillow_does_not_know_are_read_or_a_package_is_named(tmp_path):
    """Pillow reads large TIFFs of one order of bytes alone."""
    colors = np.stack([RAMP % 120, RAMP % 60 + 100, RAMP // 4], axis=2).astype(np.uint8)
    pytest.importorskip("imagecodecs")
    tifffile.imwrite(
        tmp_path / "a.tif", colors, photometric="rgb", compression="jpeg", byteorder=">", bigtiff=True, metadata=None
    )
    tifffile.imwrite(tmp_path / "b.tif", colors, photometric="rgb", compression="jpeg", metadata=None)
    assert np.abs(load_image(tmp_path / "a.tif").values - load_image(tmp_path / "b.tif").values).max() < 3.0
