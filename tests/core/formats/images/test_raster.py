"""Common pictures: each pixel's grey level arrives as the file means it."""

import struct
import zlib

import numpy as np
import PIL.Image
import pytest

from cpm_core.formats import load_image

RAMP = np.arange(12 * 20).reshape(12, 20)


def png(path, rows, colour, depth, extra=b""):
    """Write a PNG by hand from rows of bytes, without any library."""
    raw = b"".join(b"\0" + bytes(row) for row in rows)
    height = len(rows)
    samples = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    width = len(bytes(rows[0])) * 8 // (depth * samples)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + extra + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")
    )
    return path


def physical_size(pixels_a_metre):
    """PNG chunk that states the resolution along x and y."""
    data = struct.pack(">IIB", *pixels_a_metre, 1)
    return struct.pack(">I", 9) + b"pHYs" + data + struct.pack(">I", zlib.crc32(b"pHYs" + data))


def test_sixteen_bit_grey_is_kept_as_it_is(tmp_path):
    values = RAMP * 271
    image = load_image(png(tmp_path / "a.png", values.astype(">u2"), colour=0, depth=16))
    assert np.array_equal(image.values, values)
    assert image.notes == ()


def test_one_bit_becomes_black_and_white(tmp_path):
    bits = (RAMP % 3 == 0)[:, :16]
    image = load_image(png(tmp_path / "a.png", np.packbits(bits, axis=1), colour=0, depth=1))
    assert np.array_equal(image.values, 255 * bits)


@pytest.mark.parametrize("colour", [2, 4, 6])
def test_sixteen_bit_colour_keeps_its_depth(tmp_path, colour):
    """Lower bytes of one color do not get into another, and opacity has 16 bits too."""
    channels = {2: 3, 4: 2, 6: 4}[colour]
    values = np.stack([(RAMP * (271 - 31 * channel)) % 65536 for channel in range(channels)], axis=2)
    image = load_image(png(tmp_path / "a.png", values.astype(">u2"), colour=colour, depth=16))
    opacity = values[..., -1:] / 65535.0 if channels % 2 == 0 else 1.0
    shown = values[..., :3] if channels > 2 else values[..., :1]
    shown = shown * opacity + 65535.0 * (1.0 - opacity)
    weights = [0.2125, 0.7154, 0.0721] if channels > 2 else [1.0]
    assert np.allclose(image.values, shown @ weights, atol=1e-6)
    assert not any("cut down" in note for note in image.notes)


def transparent(*level):
    """PNG chunk that names the gray level or color which is transparent."""
    data = struct.pack(f">{len(level)}H", *level)
    return struct.pack(">I", len(data)) + b"tRNS" + data + struct.pack(">I", zlib.crc32(b"tRNS" + data))


@pytest.mark.parametrize("bits", [4, 8, 12, 16])
@pytest.mark.parametrize("signed", [False, True])
def test_jpeg_2000_keeps_the_gray_levels_of_its_depth(tmp_path, bits, signed):
    codecs = pytest.importorskip("imagecodecs")
    values = RAMP * 53 % 2**bits - (2 ** (bits - 1) if signed else 0)
    kind = np.dtype(f"{'i' if signed else 'u'}{1 if bits <= 8 else 2}")
    packed = codecs.jpeg2k_encode(values.astype(kind), level=0, reversible=True, bitspersample=bits, codecformat="jp2")
    (tmp_path / "a.jp2").write_bytes(packed)
    assert np.array_equal(load_image(tmp_path / "a.jp2").values, values)


def test_transparent_pixels_show_white_and_opaque_ones_themselves(tmp_path):
    colours = np.zeros((10, 10, 4), dtype=np.uint8)
    colours[..., :3] = 40
    colours[:5, :, 3] = 255
    colours[7, :, 3] = 51
    PIL.Image.fromarray(colours).save(tmp_path / "a.png")
    image = load_image(tmp_path / "a.png")
    assert np.all(image.values[:5] == 40)
    assert np.all(image.values[5] == 255)
    assert np.allclose(image.values[7], 40 * 0.2 + 255 * 0.8)
    assert any("white" in note for note in image.notes)


def test_palette_gives_its_colors(tmp_path):
    picture = PIL.Image.fromarray((RAMP % 4).astype(np.uint8), mode=None).convert("P")
    picture.putpalette([0, 0, 0, 80, 80, 80, 160, 160, 160, 240, 240, 240] + [0] * 756)
    picture.save(tmp_path / "a.gif")
    picture.save(tmp_path / "a.png")
    expected = np.asarray(picture.convert("L"))
    assert np.array_equal(load_image(tmp_path / "a.png").values, expected)
    assert np.array_equal(load_image(tmp_path / "a.gif").values, expected)


@pytest.mark.parametrize("maximum", [100, 255, 1000, 4095, 65535])
def test_portable_gray_map_keeps_its_values_for_any_declared_maximum(tmp_path, maximum):
    values = RAMP * maximum // RAMP.max()
    header = f"P5\n# made by hand\n20 12\n{maximum}\n".encode()
    (tmp_path / "raw.pgm").write_bytes(header + values.astype(np.uint8 if maximum < 256 else ">u2").tobytes())
    plain = "\n".join(" ".join(map(str, row)) for row in values)
    (tmp_path / "plain.pgm").write_text(f"P2\n20 12\n{maximum}\n{plain}\n", encoding="ascii")
    assert np.array_equal(load_image(tmp_path / "raw.pgm").values, values)
    assert np.array_equal(load_image(tmp_path / "plain.pgm").values, values)


def test_floating_point_map_keeps_fractions(tmp_path):
    values = RAMP / 7 - 3
    data = values[::-1].astype("<f4").tobytes()
    (tmp_path / "a.pfm").write_bytes(b"Pf\n20 12\n-1.0\n" + data)
    assert np.array_equal(load_image(tmp_path / "a.pfm").values, values.astype(np.float32))


# Where the first row and the first column of the stored picture belong, by the definition of the orientation tag.
UPRIGHT = {
    1: lambda v: v,
    2: np.fliplr,
    3: lambda v: np.rot90(v, 2),
    4: np.flipud,
    5: lambda v: v.T,
    6: lambda v: np.rot90(v, -1),
    7: lambda v: np.rot90(v, 2).T,
    8: lambda v: np.rot90(v, 1),
}


@pytest.mark.parametrize("tag", range(1, 9))
def test_pictures_stand_upright_as_the_camera_says(tmp_path, tag):
    exif = PIL.Image.Exif()
    exif[274] = tag
    colors = np.stack([RAMP, 255 - RAMP, RAMP // 2], axis=2).astype(np.uint8)
    PIL.Image.fromarray(colors).save(tmp_path / "a.png", exif=exif)
    image = load_image(tmp_path / "a.png")
    assert np.array_equal(image.colors.samples[..., 0], UPRIGHT[tag](RAMP))
    assert np.allclose(image.values, image.colors.samples @ [0.2125, 0.7154, 0.0721])
    assert any("upright" in note for note in image.notes) == (tag != 1)


def test_broken_camera_data_leaves_the_picture_readable(tmp_path):
    PIL.Image.fromarray(RAMP.astype(np.uint8)).save(
        tmp_path / "a.jpg", exif=b"Exif\0\0II*\0\xff\xff\xff\xff", quality=95
    )
    assert load_image(tmp_path / "a.jpg").shape == RAMP.shape


def test_a_resolution_too_fine_for_any_screen_is_the_size_of_a_pixel(tmp_path):
    path = png(tmp_path / "a.png", RAMP.astype(np.uint8), 0, 8, extra=physical_size((4_000_000, 2_000_000)))
    image = load_image(path)
    assert image.spacing == pytest.approx((0.5, 0.25), rel=1e-3)
    assert image.unit == "µm"


def test_the_resolution_of_a_screen_says_nothing_about_the_specimen(tmp_path):
    image = load_image(png(tmp_path / "a.png", RAMP.astype(np.uint8), 0, 8, extra=physical_size((11811, 11811))))
    assert (image.spacing, image.unit) == ((1.0, 1.0), None)


def test_colors_are_kept_beside_the_luminance(tmp_path):
    colors = np.stack([RAMP, 255 - RAMP, RAMP // 2], axis=2).astype(np.uint8)
    PIL.Image.fromarray(colors).save(tmp_path / "a.png")
    image = load_image(tmp_path / "a.png")
    assert image.colors.samples.dtype == np.uint8
    assert np.array_equal(image.colors.samples, colors)
    assert image.colors.white == 255.0
    red, green, blue = np.moveaxis(colors.astype(float), 2, 0)
    assert np.allclose(image.values, 0.2125 * red + 0.7154 * green + 0.0721 * blue)
    assert image.notes == ("Color was turned into luminance.",)
