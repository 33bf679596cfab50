"""Bad files: any file either loads or is refused in one sentence."""

import errno
import os
import re
import struct
import tempfile
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
import tifffile
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cpm_core.formats import load_image
from cpm_core.formats.images import readers
from cpm_core.formats.images.decoded import DecodedImage
from cpm_core.formats.images.stack import Stack
from cpm_core.image.image import Image

VALUES = (np.add.outer(np.arange(24) * 7, np.arange(30) * 5) % 251).astype(np.uint8)


def failure_report(path):
    """The sentence with which a file is refused; fails when it is not, or not in one sentence."""
    with pytest.raises(ValueError, match=re.escape(Path(path).name)) as caught:
        load_image(path)
    text = str(caught.value)
    assert "\n" not in text
    assert text.endswith(".")
    return text


def test_the_name_of_a_file_comes_first_and_a_long_folder_is_cut(tmp_path):
    folder = tmp_path / ("a" * 30) / ("b" * 30) / "study"
    name = f"{'scan' * 40}_003.nii"
    assert failure_report(folder / name).startswith(f"{name} in …{os.sep}study{os.sep} does not exist")


def save_as(kind):
    return lambda path: PIL.Image.fromarray(VALUES).save(path, format=kind)


def save_tiff(path):
    tifffile.imwrite(path, VALUES)


def save_packed_tiff(path):
    PIL.Image.fromarray(VALUES).save(path, format="TIFF", compression="tiff_lzw")


def save_array(path):
    with path.open("wb") as stream:
        np.save(stream, VALUES)


SOUND = {
    "tiff": save_tiff,
    "packed tiff": save_packed_tiff,
    "npy": save_array,
    **{kind.lower(): save_as(kind) for kind in ("PNG", "JPEG", "BMP", "PPM", "GIF", "WEBP", "JPEG2000")},
}


def test_a_file_that_is_not_there(tmp_path):
    assert "does not exist" in failure_report(tmp_path / "none.png")


def test_a_folder(tmp_path):
    assert "is a folder" in failure_report(tmp_path)


def test_an_empty_file(tmp_path):
    (tmp_path / "empty.png").touch()
    assert "is empty" in failure_report(tmp_path / "empty.png")


@pytest.mark.parametrize("content", [b"hello", b"\0" * 5000])
@pytest.mark.parametrize("name", ["notes.txt", "notes.png", "notes"])
def test_a_file_that_is_no_image(tmp_path, content, name):
    (tmp_path / name).write_bytes(content)
    assert "of an unknown kind" in failure_report(tmp_path / name)


def test_an_image_of_one_pixel(tmp_path):
    PIL.Image.new("L", (1, 1)).save(tmp_path / "dot.png")
    assert "is 1 x 1 px" in failure_report(tmp_path / "dot.png")


def test_a_pixel_that_is_no_number_has_no_data(tmp_path):
    values = VALUES.astype(np.float32)
    values[3, 4] = np.nan
    tifffile.imwrite(tmp_path / "a.tif", values)
    image = load_image(tmp_path / "a.tif")
    assert np.isfinite(image.values).all()
    assert any("no data" in note for note in image.notes)


@pytest.mark.parametrize("value", [np.inf, -np.inf])
def test_an_image_with_an_infinite_pixel(tmp_path, value):
    values = VALUES.astype(np.float32)
    values[3, 4] = value
    tifffile.imwrite(tmp_path / "a.tif", values)
    assert "holds 1 infinite value" in failure_report(tmp_path / "a.tif")


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="permissions are those of POSIX")
def test_a_file_without_read_permission():
    owner = os.geteuid()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        path = Path(folder) / "secret.png"
        SOUND["png"](path)
        path.chmod(0)
        if owner == 0:  # the superuser may read everything, so another user is set for a moment
            os.seteuid(65534)
        try:
            assert "you have no permission" in failure_report(path)
        finally:
            os.seteuid(owner)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are those of POSIX")
def test_a_pipe_does_not_make_the_program_wait(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    assert "is not an ordinary file" in failure_report(tmp_path / "pipe.png")


def test_a_name_that_no_file_can_have():
    with pytest.raises(ValueError, match="unknown kind"):
        load_image("a\0b.png")


@pytest.mark.parametrize("kind", SOUND)
def test_a_sound_file_loads(tmp_path, kind):
    SOUND[kind](tmp_path / "a")
    assert load_image(tmp_path / "a").shape == VALUES.shape


@pytest.mark.parametrize("kind", SOUND)
@pytest.mark.parametrize("share", [0.15, 0.5, 0.75])
def test_a_file_cut_short_is_refused(tmp_path, kind, share, capfd):
    SOUND[kind](tmp_path / "a")
    content = (tmp_path / "a").read_bytes()
    (tmp_path / "a").write_bytes(content[: int(share * len(content))])
    failure_report(tmp_path / "a")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", SOUND)
@settings(max_examples=10, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_bytes_load_or_are_refused_and_nothing_is_printed(tmp_path, capfd, kind, data):
    SOUND[kind](tmp_path / "a")
    content = bytearray((tmp_path / "a").read_bytes())
    start = data.draw(st.sampled_from([0, len(content) // 2]))
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(start, min(start + 200, len(content) - 1)))
        content[place] = data.draw(st.sampled_from([0, 1, 0x7F, 0x80, 0xFF, content[place] ^ 1]))
    (tmp_path / "a").write_bytes(content)
    try:
        assert isinstance(load_image(tmp_path / "a"), Image)
    except ValueError as error:
        assert "\n" not in str(error)
    assert capfd.readouterr() == ("", "")


def bomb_png(path, side):
    """A PNG of some kilobytes that declares a picture of side x side pixels."""

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(bytes(10**6)))
        + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize("side", [9000, 12000, 100_000])
def test_an_image_too_large_for_memory_is_refused_before_it_is_unpacked(tmp_path, side):
    bomb_png(tmp_path / "bomb.png", side)
    assert re.search("crop it or make it smaller", failure_report(tmp_path / "bomb.png"))


def test_a_tiff_too_large_for_memory_is_refused_before_it_is_unpacked(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", VALUES)
    with tifffile.TiffFile(tmp_path / "a.tif", mode="r+") as file:
        file.pages.first.tags["ImageLength"].overwrite(2**31)
    assert "crop it or make it smaller" in failure_report(tmp_path / "a.tif")


@pytest.mark.parametrize(
    ("widths", "length", "count"),
    [(100, 2**30 + 11, 9), (1, 11, 2**32 - 1)],
    ids=["a list of widths", "a strip longer than the file"],
)
def test_a_damaged_tiff_takes_no_memory(tmp_path, widths, length, count):
    """The product of its sides repeated the list of widths a billion times; a strip was read into all that it named."""
    tags = [(256, widths, 64), (257, 1, length), (258, 1, 8), (259, 1, 1), (262, 1, 1), (273, 1, 8), (279, 1, count)]
    entries = b"".join(struct.pack("<HHII", tag, 4, number, value) for tag, number, value in tags)
    path = tmp_path / "damaged.tif"
    path.write_bytes(struct.pack("<2sHIH", b"II", 42, 8, len(tags)) + entries + bytes(400))
    tracemalloc.start()
    with pytest.raises(ValueError, match=r"damaged\.tif is damaged"):
        load_image(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10 * 2**20


SIGNATURES = {
    "SVG": b"<svg xmlns='http://www.w3.org/2000/svg'/>",
    "HEIC": b"\0\0\0\x18ftypheic\0\0\0\0",
    "HDF5": b"\x89HDF\r\n\x1a\n" + bytes(30),
    "MINC": b"CDF\x01" + bytes(30),
}


@pytest.mark.parametrize("kind", SIGNATURES)
def test_a_sound_file_of_a_kind_that_is_not_read_is_called_by_its_name(tmp_path, kind):
    (tmp_path / "scan.dat").write_bytes(SIGNATURES[kind])
    report = failure_report(tmp_path / "scan.dat")
    assert f" {kind} " in report
    assert "damaged" not in report


def test_an_image_that_cannot_be_read_again_for_its_hash_is_refused(tmp_path, monkeypatch):
    np.save(tmp_path / "a.npy", VALUES)

    def stack(path, reading):
        values = np.load(path)[None]
        path.unlink()
        return Stack("a", values.shape, lambda *_: DecodedImage(values))

    monkeypatch.setattr(readers.numpy_array, "open_image_file", stack)
    assert f"/ cannot be read: {os.strerror(errno.ENOENT)}" in failure_report(tmp_path / "a.npy")
