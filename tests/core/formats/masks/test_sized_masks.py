"""Label masks that know the size of a pixel: TIFF for ImageJ, NIfTI for radiology."""

import gzip
import io
import struct
from dataclasses import replace

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core import Contour
from cpm_core.contours.rasterize import paint
from cpm_core.formats import encoded, export, load_image

from ..drawn import FIBRE, RESULT

MASK = paint(RESULT.contours, RESULT.shape)


def many(count):
    """A result with so many triangles, all in the same place."""
    triangle = Contour(np.array([[1.0, 1.0], [1.0, 4.0], [4.0, 1.0]]), closed=True)
    return replace(RESULT, contours=(triangle,) * count)


@pytest.mark.parametrize("suffix", [".tif", ".tiff"])
def test_the_tiff_holds_the_label_mask_in_sixteen_bits(suffix):
    with PIL.Image.open(io.BytesIO(encoded(RESULT, suffix))) as image:
        assert image.mode == "I;16"
        assert np.array_equal(np.asarray(image), MASK)
    assert MASK.max() == 3


def test_imagej_and_we_find_the_size_of_a_pixel_in_the_tiff(tmp_path):
    export(RESULT, tmp_path / "a.tif")
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.is_imagej
        assert file.imagej_metadata["unit"] == "um"
        assert file.pages[0].tags["XResolution"].value == (4, 1)
        assert file.pages[0].tags["YResolution"].value == (2, 1)
    image = load_image(tmp_path / "a.tif")
    assert (image.spacing, image.unit) == ((0.5, 0.25), "µm")


def test_without_a_unit_lengths_are_in_pixels(tmp_path):
    export(replace(RESULT, unit=None, spacing=(1.0, 1.0)), tmp_path / "a.tif")
    image = load_image(tmp_path / "a.tif")
    assert (image.spacing, image.unit) == ((1.0, 1.0), None)


def test_more_labels_than_sixteen_bits_hold_make_thirty_two(tmp_path):
    export(many(65536), tmp_path / "a.tif", tmp_path / "a.nii")
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.pages[0].dtype == np.uint32
        assert file.asarray().max() == 65536
    image = load_image(tmp_path / "a.tif")
    assert image.spacing == pytest.approx((0.5, 0.25))
    data = (tmp_path / "a.nii").read_bytes()
    assert struct.unpack_from("<2h", data, 70) == (768, 32)
    assert np.frombuffer(data, "<u4", offset=352).max() == 65536


def header(data):
    """Entries of a NIfTI-1 header, at the offsets that its standard gives."""
    entries = {
        "size": ("<i", 0), "dim": ("<8h", 40), "type": ("<2h", 70), "pixdim": ("<8f", 76), "offset": ("<f", 108),
        "scale": ("<2f", 112), "units": ("<B", 123), "codes": ("<2h", 252), "quaternion": ("<6f", 256),
        "rows": ("<12f", 280), "magic": ("<4s", 344),
    }  # fmt: skip
    return {name: struct.unpack_from(form, data, at) for name, (form, at) in entries.items()}


def test_the_nifti_is_the_label_mask_with_columns_first():
    data = encoded(RESULT, ".nii")
    found = header(data)
    assert (found["size"], found["magic"], found["offset"]) == ((348,), (b"n+1\0",), (352.0,))
    assert found["dim"] == (3, 90, 60, 1, 1, 1, 1, 1)
    assert found["type"] == (512, 16)
    assert found["scale"] == (1.0, 0.0)
    assert data[348:352] == bytes(4)
    assert np.array_equal(np.frombuffer(data, "<u2", offset=352).reshape(60, 90), MASK)


@pytest.mark.parametrize(
    ("unit", "spacing", "code", "sizes"),
    [
        ("µm", (0.5, 0.25), 3, (0.25, 0.5)),
        ("mm", (0.5, 0.25), 2, (0.25, 0.5)),
        ("nm", (500.0, 250.0), 3, (0.25, 0.5)),
        ("cm", (0.5, 0.25), 2, (2.5, 5.0)),
        ("m", (0.5, 0.25), 1, (0.25, 0.5)),
        (None, (1.0, 1.0), 0, (1.0, 1.0)),
    ],
)
def test_the_nifti_knows_the_size_of_a_pixel_and_lies_as_a_picture_does(unit, spacing, code, sizes):
    found = header(encoded(replace(RESULT, unit=unit, spacing=spacing), ".nii"))
    assert found["units"] == (code,)
    assert found["pixdim"][1:3] == pytest.approx(sizes)
    width, height = sizes
    assert found["rows"] == pytest.approx((-width, 0, 0, 0, 0, -height, 0, 0, 0, 0, 1, 0))
    # the quaternion says the same: a rotation by half a turn
    b, c, d = found["quaternion"][:3]
    a = np.sqrt(max(0.0, 1 - b * b - c * c - d * d))
    turn = [a * a + b * b - c * c - d * d, a * a + c * c - b * b - d * d, a * a + d * d - b * b - c * c]
    np.testing.assert_allclose(turn, [-1, -1, 1])
    assert found["codes"][0] > 0
    assert found["codes"][1] > 0


def test_the_packed_nifti_is_the_same():
    assert gzip.decompress(encoded(RESULT, ".nii.gz")) == encoded(RESULT, ".nii")


@pytest.mark.parametrize("suffix", [".tif", ".nii", ".nii.gz"])
def test_without_a_closed_contour_nothing_is_written(tmp_path, suffix):
    with pytest.raises(ValueError, match="is closed, so a label mask would be empty"):
        export(replace(RESULT, contours=(FIBRE,)), tmp_path / f"a{suffix}")
    assert list(tmp_path.iterdir()) == []
